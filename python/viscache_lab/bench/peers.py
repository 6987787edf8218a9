"""Other ray tracers in processes and environments of their own, which take turns with us."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.experiment.amounts import Sample

#: A peer's module, also the name of its environment, and what pip installs there.
PACKAGES: dict[str, tuple[str, ...]] = {
    "mitsuba": ("numpy", "mitsuba"),
    "embreex": ("numpy", "embreex"),
    "bpy": ("numpy", "bpy==4.2.*"),
    "pyluxcore": ("numpy", "pyluxcore==2.11.*"),
}


def default_folder() -> Path:
    """`viscache/peers` in the user's folder of caches (`$XDG_CACHE_HOME`, else `~/.cache`)."""
    caches = os.environ.get("XDG_CACHE_HOME")
    return (Path(caches) if caches else Path.home() / ".cache") / "viscache" / "peers"


def interpreter(name: str, folder: Path) -> Path | None:
    """The interpreter that has a module of `PACKAGES`: that of its environment, or this one."""
    own = folder / name / "bin/python"
    if own.exists():
        return own
    return Path(sys.executable) if importlib.util.find_spec(name) is not None else None


def make_environments(folder: Path) -> dict[str, str]:
    """Make or update each peer's environment in a folder: by name "", or what pip said last."""
    folder.mkdir(parents=True, exist_ok=True)
    return {name: _make(folder / name, needs) for name, needs in PACKAGES.items()}


def _make(place: Path, needs: tuple[str, ...]) -> str:
    steps = (
        [sys.executable, "-m", "venv", str(place)],
        [str(place / "bin/python"), "-m", "pip", "install", "--quiet", "--upgrade", *needs],
    )
    for step in steps:
        try:
            done = subprocess.run(step, capture_output=True, text=True)
        except OSError as error:
            return str(error)
        if done.returncode:
            said = (done.stderr or done.stdout).strip().splitlines()
            return said[-1] if said else f"{step[2]} ended with status {done.returncode}"
    return ""


#: Name of a peer: (the package it needs, the module that runs it).
PEERS = {
    "mitsuba": ("mitsuba", "viscache_lab.bench.peer_mitsuba"),
    "mitsuba-scalar": ("mitsuba", "viscache_lab.bench.peer_mitsuba"),
    "cycles": ("bpy", "viscache_lab.bench.peer_cycles"),
    "luxcore": ("pyluxcore", "viscache_lab.bench.peer_luxcore"),
    "luxcore-cache": ("pyluxcore", "viscache_lab.bench.peer_luxcore"),
    "embreex": ("embreex", "viscache_lab.bench.peer_embreex"),
}
#: Starts a module of this package under an interpreter that does not have the package.
_START = """
import runpy, sys, types
for name, folder in (("viscache_lab", sys.argv[1]), ("viscache_lab.bench", sys.argv[1] + "/bench")):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [folder]
module = sys.argv[2]
del sys.argv[1:3]
runpy.run_module(module, run_name="__main__", alter_sys=True)
"""


class PeerError(RuntimeError):
    """The other program failed; the message is its own, `peer` says which one it is."""

    def __init__(self, message: str, peer: str = "") -> None:
        super().__init__(message)
        self.peer = peer


def missing(name: str, scene: vc.Scene) -> str | None:
    """Why a peer cannot be used with this scene; None if it can."""
    package = PEERS[name][0]
    if importlib.util.find_spec(package) is None:
        return f"{package} is not installed"
    return missing_scene(scene)


def missing_scene(scene: vc.Scene) -> str | None:
    """Why a scene cannot be handed over to any peer; None if it can."""
    if scene.info()["instances"]:
        return "the scene has instances, which are not handed over"
    return None


def time_of(peer: Peer, job: str) -> Sample:
    """Of a job without fields."""
    return peer.run({"job": job})[0]


def blocked(found: npt.NDArray[Any], name: str) -> npt.NDArray[np.bool_]:
    """Which rays hit, by the answers of a peer: embreex has 0 where one does, −1 where not."""
    return np.asarray(found == 0 if name == "embreex" else found.astype(bool))


class Peer:
    """One of `PEERS` with the triangles of a scene; `run(job)` runs one job and gives its duration.

    `python` is the interpreter that has the peer's package; this package need not be there. Jobs
    and reports are lines of JSON. PeerError: it did not start, ended, or reported an error.
    """

    def __init__(self, name: str, scene: vc.Scene, python: Path | None = None) -> None:
        self._name = name
        self._folder = tempfile.TemporaryDirectory(prefix="viscache-bench-")
        self._path = Path(self._folder.name)
        meshes = [m for m in scene.meshes() if m["in_world"]]
        starts = np.cumsum([0] + [len(m["vertices"]) for m in meshes])
        parts = [np.asarray(m["triangles"]) + s for m, s in zip(meshes, starts, strict=False)]
        vertices = np.concatenate([m["vertices"] for m in meshes])
        triangles = np.concatenate(parts).astype(np.uint32)
        np.savez(self._path / "scene.npz", vertices=vertices, triangles=triangles)
        lab, pipe = str(Path(__file__).parents[1]), subprocess.PIPE
        words = [python or sys.executable, "-c", _START, lab, PEERS[name][1], self._path, name]
        self._process = subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True)
        try:
            self.about = self._answer()
        except BaseException:
            self.__exit__()
            raise

    def run(self, job: dict[str, Any]) -> tuple[Sample, dict[str, Any]]:
        """Run a job; return its time and the rest of its report."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended; the answer says how
            self._process.stdin.write(json.dumps(job) + "\n")
            self._process.stdin.flush()
        report = self._answer()
        return Sample(wall_s=report["wall_s"], cpu_s=report["cpu_s"]), report

    def give(self, **arrays: Any) -> None:
        """Write arrays for the next jobs."""
        np.savez(self._path / "input.npz", **arrays)
        self.run({"job": "load"})

    def result(self) -> dict[str, Any]:
        """Arrays that the last job wrote."""
        self.run({"job": "save"})
        with np.load(self._path / "output.npz") as file:
            return dict(file)

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            status = self._process.wait()
            raise PeerError(f"the other program ended with status {status}", self._name)
        report: dict[str, Any] = json.loads(line)
        if "error" in report:
            raise PeerError(report["error"], self._name)
        return report

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None and self._process.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        self._process.wait(timeout=60)
        self._process.stdout.close()
        self._folder.cleanup()
