"""Files that exist completely or not at all."""

import os
import subprocess
import sys

import pytest

import viscache as vc
from viscache.base.files import inside, whole_file, write_whole
from viscache.scene import environments


def test_a_file_takes_its_place_at_the_end_alone(tmp_path):
    target = tmp_path / "table.csv"
    write_whole(target, "old")
    with whole_file(target) as partial:
        partial.write_text("näw", encoding="utf-8")
        assert target.read_text("utf-8") == "old"
    assert target.read_text("utf-8") == "näw"
    assert list(tmp_path.iterdir()) == [target]


def test_an_error_leaves_the_file_as_it_was_and_nothing_beside_it(tmp_path):
    target = tmp_path / "table.csv"
    write_whole(target, "old")
    with pytest.raises(RuntimeError, match="half way"), whole_file(target) as partial:
        partial.write_text("ne", encoding="utf-8")
        raise RuntimeError("half way")
    assert target.read_text("utf-8") == "old" and list(tmp_path.iterdir()) == [target]


KILLED = """
import os, signal, sys
from pathlib import Path
from viscache.base.files import whole_file
for path in sys.argv[1:]:
    if os.fork() == 0:
        with whole_file(Path(path)) as partial:
            partial.write_text("half")
            os.kill(os.getpid(), signal.SIGKILL)
    assert os.wait()[1] == signal.SIGKILL
"""


def test_what_a_killed_writer_left_goes_with_the_next_write(tmp_path):
    target, other = tmp_path / "state.npz", tmp_path / "state.npz2"
    subprocess.run([sys.executable, "-c", KILLED, target, other], check=True)
    assert len(list(tmp_path.iterdir())) == 2 and not target.exists()
    write_whole(target, "whole")
    left = [p.name for p in tmp_path.iterdir() if p != target]
    assert len(left) == 1 and left[0].startswith(".state.npz2.")  # of another file


def test_what_another_process_is_writing_stays(tmp_path):
    target = tmp_path / "a"
    with whole_file(target) as one:
        one.write_text("one")
        code = "import sys; from viscache.base.files import *; write_whole(Path(sys.argv[1]), 'x')"
        subprocess.run([sys.executable, "-c", code, str(target)], check=True)
    assert target.read_text() == "one" and list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("read", [vc.Frame.load, environments.read_exr])
def test_a_picture_without_its_end_is_called_damaged(read, tmp_path):
    path = tmp_path / "picture.exr"
    vc.render("cube_on_plane", "direct", size=(8, 8)).save(path)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(ValueError, match=r"picture\.exr cannot be read: it is damaged"):
        read(path)


def test_a_link_in_the_place_of_a_partial_file_is_not_followed(tmp_path, monkeypatch):
    target, victim = tmp_path / "table.csv", tmp_path / "victim"
    victim.write_text("precious")
    with whole_file(target) as partial:
        partial.write_text("x")
    partial.symlink_to(victim)
    write_whole(target, "new")
    assert victim.read_text() == "precious" and target.read_text() == "new"
    assert not target.is_symlink() and not partial.is_symlink()


def test_a_path_inside_a_folder_passes_no_link(tmp_path):
    (tmp_path / "real" / "a").mkdir(parents=True)
    (tmp_path / "real" / "a" / "link").symlink_to(tmp_path)
    (tmp_path / "folder").symlink_to(tmp_path / "real")
    assert inside(tmp_path / "folder", "a/new/file") == tmp_path / "folder" / "a/new/file"
    for name in ("a/link", "a/link/file"):
        with pytest.raises(ValueError, match="link must be a file or folder of its own, got a "):
            inside(tmp_path / "folder", name)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ValueError, match="got a device or pipe; remove it"):
        inside(tmp_path, "pipe")
