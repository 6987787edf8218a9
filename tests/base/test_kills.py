"""Processes killed at any moment lose nothing that was finished; full disks say what to do."""

from __future__ import annotations

import errno
import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import viscache as vc
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
#: All figures, but only those of the first argument, which note when they begin.
FEW = """
import sys
from viscache import cli
from viscache_lab.experiment import run
from viscache_lab.figures import FIGURES
names, log = sys.argv[1].split(","), sys.argv[2]
for name in list(FIGURES):
    if name not in names:
        del FIGURES[name]
drawn = run.reproduce
def noted(name, *given, **more):
    with open(log, "a") as file:
        file.write(name + "\\n")
    return drawn(name, *given, **more)
run.reproduce = noted
sys.exit(cli.main(sys.argv[3:]))
"""


def start(code: str, *words: str) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    return subprocess.Popen(
        [sys.executable, "-c", code, *words],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def in_passes(folder: Path, n: int) -> list[str]:
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


def picture_of() -> vc.Progressive:
    """As the command has it."""
    exact: Any = {"visibility": "exact", "rays": vc.Embree()}
    return vc.Progressive(SCENE, vc.Direct(), **exact, size=(96, 64), spp=4)


def saved(folder: Path) -> int:
    """The number of passes of a state, which must be whole."""
    if not (folder / "s.npz").exists():
        return 0
    picture = picture_of()
    picture.load(folder / "s.npz")
    return picture.n_passes


@pytest.mark.slow
def test_passes_that_are_killed_go_on_where_they_were(tmp_path: Path) -> None:
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


@pytest.mark.slow
def test_figures_that_are_killed_go_on_with_the_next_one(tmp_path: Path) -> None:
    names = ["vlf-fig1", "vlf-fig2", "vlf-fig3"]
    log, folder, rng = tmp_path / "log", tmp_path / "out", random.Random(4)
    words = [",".join(names), str(log), "reproduce", "all", "--quick", "-o", str(folder)]
    finished: set[str] = set()
    for attempt in range(30):
        process = start(FEW, *words)
        try:
            process.wait(timeout=rng.uniform(2, 8) + attempt)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
        done = process.wait()
        there = {n for n in names if everything.finished(folder, n, quick=True, size=None)}
        assert finished <= there  # nothing finished is lost
        finished = there
        if done >= 0:
            break
    assert finished == set(names)
    begun = log.read_text().split()
    assert process.returncode in (0, 1)
    before = len(begun)
    again = start(FEW, *words)
    assert again.wait() in (0, 1) and len(log.read_text().split()) == before  # all were taken
    summary = json.loads((folder / "summary.json").read_text())
    assert [f["figure"] for f in summary["figures"]] == names


CORRELATE = """
import sys, viscache as vc
given = {"n_points": 600, "map_size": 16, "d_edges": 6, "theta_edges_deg": 6}
vc.correlation.measure("cube_on_plane", directory=sys.argv[1], threads=1, **given)
"""


@pytest.mark.slow
def test_correlations_share_a_folder_and_survive_kills(tmp_path: Path) -> None:
    given: dict[str, Any] = {"n_points": 600, "map_size": 16, "d_edges": 6, "theta_edges_deg": 6}
    whole = vc.correlation.measure(SCENE, directory=tmp_path / "whole", **given)
    folder, rng = tmp_path / "shared", random.Random(6)
    for _ in range(2):
        pair = [start(CORRELATE, str(folder)) for _ in range(2)]
        time.sleep(rng.uniform(0.5, 8))
        pair[0].send_signal(signal.SIGKILL)
        assert pair[1].wait() == 0 and pair[0].wait() in (0, -signal.SIGKILL)
        (next(folder.rglob("pairs-0*.npz"))).unlink()
    found = vc.correlation.measure(SCENE, directory=folder, **given)
    for name in ("mean", "sigma", "n"):
        assert found[name].values.tobytes() == whole[name].values.tobytes()


FULL = [
    (errno.ENOSPC, "No space left on device", "make room and run the same command again"),
    (errno.EROFS, "Read-only file system", "choose a folder that can be written to"),
    (errno.EACCES, "Permission denied", "choose a folder and files that you may read and write"),
]


@pytest.mark.parametrize(("number", "text", "says"), FULL, ids=["full", "read-only", "denied"])
@pytest.mark.parametrize("out", ["x.exr", "x.png"])
def test_a_disk_that_takes_nothing_is_one_line_that_says_what_to_do(
    number: int,
    text: str,
    says: str,
    out: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refuse(self: Path, target: Any) -> None:
        raise OSError(number, text, str(target))

    monkeypatch.setattr(Path, "replace", refuse)
    words = ["render", SCENE, "--integrator", "direct", "--size", "8x8", "-o", str(tmp_path / out)]
    assert cli.main(words) == 2
    told = capsys.readouterr().err
    assert text in told and says in told and out in told
    assert told.count("\n") == 1 and list(tmp_path.iterdir()) == []


def test_a_full_disk_ends_all_figures_and_is_no_figures_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*given: Any, **more: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "x")

    monkeypatch.setattr(everything, "reproduce", full)
    assert cli.main(["reproduce", "all", "--quick", "-o", str(tmp_path)]) == 2
    assert "make room and run the same command again" in capsys.readouterr().err
    assert not (tmp_path / "summary.json").exists()


def test_a_limit_on_the_size_of_files_leaves_nothing_half_written(tmp_path: Path) -> None:
    """A real failure of writes, of an EXR and of a sweep."""

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, 2_000))

    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    words = ["render", SCENE, "--integrator", "direct", "--size", "64x64"]
    for out in ("x.exr", "x.png"):
        command = [sys.executable, "-m", "viscache", *words, "-o", str(tmp_path / out)]
        done = subprocess.run(
            command, preexec_fn=limited, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 2, done.stderr
        assert out in done.stderr and "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
