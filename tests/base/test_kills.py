"""Processes killed at any moment lose nothing that was finished; full disks say what to do."""

import errno
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import viscache as vc
from codebase.repository import environment
from viscache import cli
from viscache_lab.experiment import run as everything

SCENE = "cube_on_plane"
PASSES = """
import sys
import viscache.commands.render as command
from viscache import cli
command.SAVE_EVERY_S = command.LEAST_WORK = 0.0
sys.exit(cli.main(sys.argv[1:]))
"""


def start(code, *words):
    return subprocess.Popen(
        [sys.executable, "-c", code, *words],
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def in_passes(folder, n):
    words = ["render", SCENE, "--integrator", "direct", "--size", "96x64", "--spp", "4"]
    return [
        *words,
        "--passes",
        str(n),
        "--state",
        str(folder / "s.npz"),
        "-o",
        str(folder / "x.exr"),
    ]


def picture_of():
    """As the command has it."""
    exact = {"visibility": "exact", "rays": vc.Embree()}
    return vc.Progressive(SCENE, vc.Direct(), **exact, size=(96, 64), spp=4)


def saved(folder):
    """The number of passes of a state, which must be whole."""
    if not (folder / "s.npz").exists():
        return 0
    picture = picture_of()
    picture.load(folder / "s.npz")
    return picture.n_passes


@pytest.mark.slow
def test_passes_that_are_killed_go_on_where_they_were(tmp_path):
    rng, kills, last = random.Random(3), 0, 0
    while kills < 6:
        process = start(PASSES, *in_passes(tmp_path, 100_000))
        began = time.monotonic()
        while saved(tmp_path) == last and time.monotonic() - began < 60:
            time.sleep(0.05)
        time.sleep(rng.uniform(0, 0.3))
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        kills += 1
        now = saved(tmp_path)
        assert now > last
        last = now
    picture = picture_of()
    picture.load(tmp_path / "s.npz")
    whole = picture_of().passes(last)
    assert picture.frame.sha256 == whole.sha256
    assert sum(p.name.endswith(".part") for p in tmp_path.iterdir()) <= 1
    picture.save(tmp_path / "s.npz")
    assert not any(p.name.endswith(".part") for p in tmp_path.iterdir())


FULL = [
    (errno.ENOSPC, "No space left on device", "make room and run the same command again"),
    (errno.EROFS, "Read-only file system", "choose a folder that can be written to"),
    (errno.EACCES, "Permission denied", "choose a folder and files that you may read and write"),
]


@pytest.mark.parametrize(("number", "text", "says"), FULL, ids=["full", "read-only", "denied"])
@pytest.mark.parametrize("out", ["x.exr", "x.png"])
def test_a_disk_that_takes_nothing_is_one_line_that_says_what_to_do(
    number, text, says, out, tmp_path, monkeypatch, capsys
):
    def refuse(self, target):
        raise OSError(number, text, str(target))

    monkeypatch.setattr(Path, "replace", refuse)
    words = ["render", SCENE, "--integrator", "direct", "--size", "8x8", "-o", str(tmp_path / out)]
    assert cli.main(words) == 2
    told = capsys.readouterr().err
    assert text in told and says in told and out in told
    assert told.count("\n") == 1 and list(tmp_path.iterdir()) == []


def test_a_full_disk_ends_all_figures_and_is_no_figures_fault(tmp_path, monkeypatch, capsys):
    def full(*given, **more):
        raise OSError(errno.ENOSPC, "No space left on device", "x")

    monkeypatch.setattr(everything, "reproduce", full)
    assert cli.main(["reproduce", "all", "--quick", "-o", str(tmp_path)]) == 2
    assert "make room and run the same command again" in capsys.readouterr().err
    assert not (tmp_path / "summary.json").exists()


def test_a_limit_on_the_size_of_files_leaves_nothing_half_written(tmp_path):
    """A real failure of writes, of an EXR and of a sweep."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, 2_000))

    words = ["render", SCENE, "--integrator", "direct", "--size", "64x64"]
    for out in ("x.exr", "x.png"):
        command = [sys.executable, "-m", "viscache", *words, "-o", str(tmp_path / out)]
        done = subprocess.run(
            command, preexec_fn=limited, env=environment(), capture_output=True, text=True
        )
        assert done.returncode == 2, done.stderr
        assert out in done.stderr and "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
