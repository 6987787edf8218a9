"""`viscache bench loading`: time and memory from a file to a scene that can be traced.

Both renderers load the same Mitsuba file, each time in a new process that has imported its package.
Mitsuba runs in its variant `scalar_rgb`, which compiles nothing and builds its tree while it loads.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, interleave
from viscache_lab.parity import renderers
from viscache_lab.parity.shared import shared_scenes
from viscache_lab.parity.zoo import scene_text

#: Ours takes at most this many times Mitsuba's seconds and bytes.
LIMIT = 1.2
#: Below these, a figure says more about the process than about the scene.
LEAST_S, LEAST_MIB = 0.05, 8.0

#: Imports, then loads a file; prints seconds, the growth of the peak of memory, and triangles.
COMMON = """
import json, re, sys, time
from pathlib import Path
def memory(key):
    return int(re.search(key + r":\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
def measured(load):
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins here
    before = memory("VmRSS")
    wall, cpu = time.perf_counter(), time.process_time()
    scene = load()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return scene, {"wall_s": wall, "cpu_s": cpu, "mib": (memory("VmHWM") - before) / 1024,
                   "kept_mib": (memory("VmRSS") - before) / 1024}
"""
OURS = """
import viscache as vc
def load():
    scene = vc.load_scene(sys.argv[1], allow_outside=True)
    scene.caster()  # builds Embree's tree
    return scene
scene, found = measured(load)
print(json.dumps(found | {"triangles": scene.triangles}))
"""
THEIRS = """
import mitsuba as mi
mi.set_variant("scalar_rgb")
mi.logger().set_log_level(mi.LogLevel.Error)
scene, found = measured(lambda: mi.load_file(sys.argv[1]))
faces = {mi.ShapeType.Rectangle: 2, mi.ShapeType.Disk: 64}
count = sum(s.face_count() if s.is_mesh() else faces.get(mi.ShapeType(s.shape_type()), 0)
            for s in scene.shapes())
tree = "Embree" if mi.MI_ENABLE_EMBREE else "kd-tree"
print(json.dumps(found | {"triangles": count, "tree": tree, "version": mi.__version__}))
"""


@BENCHES.add("loading", "time and memory to load scene files and build their trees against Mitsuba")
def loading(trial: Trial) -> None:
    """The generated meshes and the shared scenes that Mitsuba reads."""
    if reason := renderers.missing():
        trial.skip("loading", reason)
        return
    with tempfile.TemporaryDirectory(prefix="viscache-loading-") as made:
        for name, path in _files(Path(made), trial.quick, trial):
            _measure(trial, name, path)


def _measure(trial: Trial, name: str, path: Path) -> None:
    found: dict[str, list[dict[str, Any]]] = {"ours": [], "theirs": []}

    def load(side: str, program: str) -> Sample:
        words = [sys.executable, "-c", COMMON + program, str(path)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            last = done.stderr.strip().rpartition("\n")[2]
            raise RuntimeError(f"{name}, {side}", last)
        found[side].append(json.loads(done.stdout))
        return Sample(wall_s=found[side][-1]["wall_s"], cpu_s=found[side][-1]["cpu_s"])

    runs = {"ours": partial(load, "ours", OURS), "theirs": partial(load, "theirs", THEIRS)}
    try:
        seconds = interleave(runs, trial.repeats(3), warm_up=False)
    except RuntimeError as error:
        trial.skip(*error.args)
        return
    ours, theirs = found["ours"], found["theirs"]
    triangles = ours[0]["triangles"]
    trial.check(f"{name}: triangles more or less", abs(triangles - theirs[0]["triangles"]), 0)
    tree = f"Mitsuba {theirs[0]['version']}, scalar_rgb, builds: {theirs[0]['tree']}"
    if tree not in trial.notes:
        trial.notes.append(tree)
    about = f"{name} {triangles}"
    least = statistics.median(s["cpu_s"] for s in theirs) >= LEAST_S
    goal = 1 / LIMIT if least else None
    trial.ratio(f"{about} CPU seconds vs Mitsuba", *seconds.values(), goal=goal)
    peaks = [statistics.median(s["mib"] for s in side) for side in (ours, theirs)]
    trial.figure(
        f"{about} peak memory vs Mitsuba",
        peaks[0],
        "MiB",
        baseline=peaks[1],
        ratios=[b["mib"] / a["mib"] for a, b in zip(ours, theirs, strict=True)],
        goal=1 / LIMIT if peaks[1] >= LEAST_MIB else None,
        kept_mib=statistics.median(s["kept_mib"] for s in ours),
    )


def _files(folder: Path, quick: bool, trial: Trial) -> Iterator[tuple[str, Path]]:
    side = 40 if quick else 400
    for suffix in ("ply", "obj"):
        mesh = folder / f"hills.{suffix}"
        _write_hills(mesh, side)
        target = folder / f"hills-{suffix}.xml"
        text = scene_text(f"shape.{suffix}{{ string:filename(PATH) }}").replace("PATH", str(mesh))
        target.write_text(text, encoding="utf-8")
        yield f"generated {suffix}", target
    for shared in shared_scenes(folder / "shared", quick=quick):
        if shared.path is None:
            trial.skip(shared.name, shared.reason)
        else:
            yield shared.name, shared.path


def _write_hills(path: Path, side: int) -> None:
    """A height field of 2·side² triangles with normals: binary PLY, or OBJ."""
    v, u = np.mgrid[0 : side + 1, 0 : side + 1] / side
    height = 0.1 * np.sin(12 * u) * np.cos(9 * v)
    points = np.stack([u, height, v], axis=2).reshape(-1, 3).astype("<f4")
    slope = np.stack([-1.2 * np.cos(12 * u) * np.cos(9 * v), np.ones_like(u)], axis=2)
    normals = np.concatenate([slope, 0.9 * (np.sin(12 * u) * np.sin(9 * v))[..., None]], axis=2)
    normals = (normals / np.linalg.norm(normals, axis=2, keepdims=True)).reshape(-1, 3)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    below = corner + side + 1
    first, second = (corner, below, corner + 1), (corner + 1, below, below + 1)
    faces = np.stack([np.stack(f, axis=1) for f in (first, second)], axis=1).reshape(-1, 3)
    if path.suffix == ".obj":
        lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
        lines += [f"vn {x:.5f} {y:.5f} {z:.5f}" for x, y, z in normals]
        lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in faces + 1]
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        return
    names = [f"property float {n}" for n in ("x", "y", "z", "nx", "ny", "nz")]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", *names]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    rows = np.zeros(len(faces), np.dtype([("n", "u1"), ("corners", "<i4", 3)]))
    rows["n"], rows["corners"] = 3, faces
    vertices = np.concatenate([points, normals.astype("<f4")], axis=1)
    body = vertices.astype("<f4").tobytes() + rows.tobytes()
    path.write_bytes("\n".join([*head, ""]).encode("ascii") + body)
