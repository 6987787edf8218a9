"""Exact frames are rendered once, are never those of something else, and are checked when read."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest

import viscache as vc
from viscache.shot.render import render_part
from viscache.sweeps import exact_frames
from viscache.sweeps.exact_frames import ExactFrames

SIZE = (24, 16)


@pytest.fixture
def rendered(monkeypatch):
    """One entry per frame that was rendered."""
    calls = []

    def counted(*arguments, **options):
        calls.append(options)
        return render_part(*arguments, **options)

    monkeypatch.setattr(exact_frames, "render_part", counted)
    return calls


def test_a_frame_is_rendered_once_and_is_the_one_of_render(tmp_path, rendered):
    scene = vc.scenes.cube_on_plane()
    frames = [ExactFrames(tmp_path)(scene, vc.Direct(), size=SIZE, seed=3) for _ in range(2)]
    assert len(rendered) == 1
    want = vc.render(scene, vc.Direct(), size=SIZE, seed=3)
    for frame in frames:
        assert frame.sha256 == want.sha256 and frame.parameters == want.parameters
        for name, pixels in want.layers.items():
            np.testing.assert_array_equal(frame.layers[name], pixels)
    frames[0].image[:] = 0  # a caller's own
    assert ExactFrames(tmp_path)("cube_on_plane", "direct", size=SIZE, seed=3).image.any()
    assert len(rendered) == 1


def test_what_changes_a_frame_is_another_frame(tmp_path, rendered):
    scene, exact = vc.scenes.cube_on_plane(), ExactFrames(tmp_path)
    view = vc.look_at((3, 3, 3), (0, 0, 0), fov_deg=40)
    sky = tmp_path / "sky.exr"
    vc.Frame(layers={"color": np.ones((4, 8, 3))}).save(sky)
    options = [
        {"integrator": vc.Direct()},
        {"integrator": vc.Direct(n_area=3)},
        {"integrator": vc.Whitted(n_vpls=8)},
        {"seed": 1},
        {"spp": 2},
        {"size": (16, 24)},
        {"rays": vc.Bsp()},
        {"camera": view},
        {"env": 0.5},
        {"env": str(sky)},
        {"scene": vc.scenes.stairs()},
    ]
    shas = [
        exact(**{"scene": scene, "integrator": vc.Direct(), "size": SIZE, **given}).sha256
        for given in options
    ]
    assert len(rendered) == len(options)
    vc.Frame(layers={"color": np.full((4, 8, 3), 2.0)}).save(sky)  # the same name, another sky
    assert exact(scene, vc.Direct(), size=SIZE, env=str(sky)).sha256 != shas[-2]
    assert len(rendered) == len(options) + 1
    exact(scene, vc.Direct(), size=SIZE, threads=2)  # changes no byte
    exact(scene, vc.Direct(), size=SIZE, env=0.5)
    assert len(rendered) == len(options) + 1


@pytest.mark.parametrize("what", ["code_hash", "embree_version", "isa"])
def test_frames_of_other_code_are_not_taken(what, tmp_path, rendered, monkeypatch):
    scene, exact = vc.scenes.cube_on_plane(), ExactFrames(tmp_path)
    exact(scene, vc.Direct(), size=SIZE)
    with monkeypatch.context() as patched:
        patched.setattr(exact_frames, what, lambda: ("another", "another"))
        exact(scene, vc.Direct(), size=SIZE)
        assert len(rendered) == 2
    exact(scene, vc.Direct(), size=SIZE)
    assert len(rendered) == 2


def aged(path, days=40):
    at = time.time() - days * 24 * 3600
    os.utime(path, (at, at))


def test_frames_of_other_code_go_when_nobody_uses_them(tmp_path, monkeypatch):
    scene, exact = vc.scenes.cube_on_plane(), ExactFrames(tmp_path)
    (tmp_path / "mine").mkdir()
    kept = []
    for code, days in (("old", 40), ("recent", 20)):
        monkeypatch.setattr(exact_frames, "code_hash", lambda code=code: code)
        exact(scene, vc.Direct(), size=SIZE)
        (new,) = {p for p in tmp_path.iterdir() if p.name != "mine"} - set(kept)
        aged(new / exact_frames.MARKER, days)
        kept.append(new)
    monkeypatch.setattr(exact_frames, "code_hash", lambda: "new")
    exact(scene, vc.Direct(), size=SIZE)
    assert not kept[0].exists() and kept[1].exists() and (tmp_path / "mine").exists()


def test_only_exact_frames_are_removed(tmp_path, monkeypatch):
    """Old sweeps beside them stay, and so do notes of users within, and what links lead to."""
    scene, exact = vc.scenes.cube_on_plane(), ExactFrames(tmp_path)
    given = {"over": {"c_e": [4]}, "size": SIZE, "metrics": ["rel_l1"]}
    vc.sweep(scene, vc.Direct(), directory=tmp_path / "sweep", **given)
    rooms = []
    for code in ("with notes", "a link", "not ours"):
        monkeypatch.setattr(exact_frames, "code_hash", lambda code=code: code)
        exact(scene, vc.Direct(), size=SIZE)
        rooms.append(next(p for p in tmp_path.glob(16 * "?") if p not in rooms))
    notes = [rooms[0] / "notes.txt", rooms[0] / "frames" / "notes.exr"]
    for note in notes:
        note.write_text("precious")
    outside = tmp_path.with_name("outside")
    rooms[1].rename(outside)
    rooms[1].symlink_to(outside)
    (rooms[2] / exact_frames.MARKER).write_text("precious")
    kept = {*tmp_path.rglob("*"), *outside.rglob("*")} - set(rooms[0].rglob("*"))
    for path in [*tmp_path.iterdir(), *tmp_path.rglob(exact_frames.MARKER)]:
        aged(path)
    aged(outside / exact_frames.MARKER)
    monkeypatch.setattr(exact_frames, "code_hash", lambda: "new")
    exact(scene, vc.Direct(), size=SIZE)
    assert all(path.exists() for path in kept)
    assert {p for p in rooms[0].rglob("*") if p.is_file()} == set(notes)


def test_a_damaged_frame_is_rendered_again(tmp_path, rendered):
    scene, exact = vc.scenes.cube_on_plane(), ExactFrames(tmp_path)
    good = exact(scene, vc.Direct(), size=SIZE)
    (file,) = tmp_path.glob("*/frames/*.exr")
    changed = vc.Frame.load(file)
    changed.layers["depth"][3, 4] += 1e-3
    changed.save(file)
    again = exact(scene, vc.Direct(), size=SIZE)
    assert len(rendered) == 2
    np.testing.assert_array_equal(again.layers["depth"], good.layers["depth"])
    for bad in (b"", file.read_bytes()[:200]):
        file.write_bytes(bad)
        exact(scene, vc.Direct(), size=SIZE)
    file.unlink()
    exact(scene, vc.Direct(), size=SIZE)
    assert len(rendered) == 5


def test_an_interrupted_frame_is_not_kept(tmp_path, rendered, monkeypatch):
    scene, exact = vc.scenes.cube_on_plane(), ExactFrames(tmp_path)

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(exact_frames, "render_part", interrupted)
        with pytest.raises(KeyboardInterrupt):
            exact(scene, vc.Direct(), size=SIZE)
    exact(scene, vc.Direct(), size=SIZE)  # the claim was given back
    assert len(rendered) == 1


RENDER = """
import sys, time, pathlib
import viscache as vc
from viscache.sweeps import exact_frames

def slow(*arguments, **options):
    pathlib.Path(sys.argv[1], f"rendered-{time.time_ns()}").touch()
    time.sleep(1)
    return whole(*arguments, **options)

whole, exact_frames.render_part = exact_frames.render_part, slow
exact = exact_frames.ExactFrames(sys.argv[1] + "/frames")
print(exact("cube_on_plane", "direct", size=(24, 16)).sha256)
"""


def test_processes_render_a_frame_once_and_wait_for_it(tmp_path):
    command = [sys.executable, "-c", RENDER, str(tmp_path)]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    shas = {process.communicate(timeout=60)[0] for process in running}
    assert [process.returncode for process in running] == [0, 0, 0]
    assert len(shas) == 1 and len(list(tmp_path.glob("rendered-*"))) == 1


def test_without_a_folder_nothing_is_kept(rendered):
    exact = ExactFrames(None)
    frames = [exact("cube_on_plane", "direct", size=SIZE) for _ in range(2)]
    assert len(rendered) == 2 and frames[0].sha256 == frames[1].sha256


def test_bad_input_is_refused(tmp_path):
    exact = ExactFrames(tmp_path / "frames")
    with pytest.raises(ValueError, match="spp must be an integer >= 1, got 0"):
        exact("cube_on_plane", "direct", spp=0)
    with pytest.raises(ValueError, match="size must be"):
        exact("cube_on_plane", "direct", size=(0, 4))
    with pytest.raises(ValueError, match=r"seed must be in \[0, 2\^63\), got -1"):
        exact("cube_on_plane", "direct", seed=-1)
    with pytest.raises(TypeError, match="did you mean 'camera'"):
        exact("cube_on_plane", "direct", camra=1)
    assert not (tmp_path / "frames").exists()
