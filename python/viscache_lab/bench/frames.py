"""`viscache bench frames`: exact frames against Mitsuba's rays per second."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.bench.peers import Peer, missing
from viscache_lab.bench.ray_sets import make_ray_set
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, build_scene, interleave


@BENCHES.add("frames", "exact frames: ambient occlusion and 500 point lights against Mitsuba")
def frames(trial: Trial) -> None:
    """Ambient occlusion from a G-buffer, and 500 point lights at all pixels."""
    side, lights, samples = (64, 20, 8) if trial.quick else (512, 500, 64)
    triangles = 20_000 if trial.quick else 200_000
    spec = f"room?triangles={triangles}&lights={lights}"
    scene = build_scene(spec)
    reason = missing("mitsuba", scene)
    if reason:
        trial.skip(f"{spec} vs mitsuba", reason)
        return
    with Peer("mitsuba", scene) as peer:
        points, normals = g_buffer(scene, side)
        positions = np.array([light["position"] for light in scene.lights], np.float32)
        peer.give(points=points, normals=normals, lights=positions)
        for name, integrator, job in (
            (
                "AO",
                vc.AmbientOcclusion(n_samples=samples, max_distance=None),
                {"job": "ambient", "samples": samples},
            ),
            (f"{lights} point lights", vc.Direct(), {"job": "lights"}),
        ):
            _compare(trial, scene, f"room {side}x{side} {name}", integrator, peer, job, trial.quick)
    trial.notes.append(
        "Rays per CPU second: ours of whole frames (camera rays and sums included), Mitsuba's of"
        " ray_test over a G-buffer that it is given. Robust scene flag on both sides."
    )


def g_buffer(scene: vc.Scene, side: int) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """First hits of a square image, moved off the surface towards the camera."""
    rays = make_ray_set(scene, "camera", side * side)
    hits = scene.intersect(rays.origins, rays.directions)
    hit = hits.triangle >= 0
    meshes = [m for m in scene.meshes() if m["in_world"]]
    corners = np.concatenate(
        [np.asarray(m["vertices"])[np.asarray(m["triangles"])] for m in meshes]
    )
    tri = corners[hits.triangle[hit]].astype(np.float64)
    n = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    d = rays.directions[hit]
    n *= -np.sign(np.sum(n * d, axis=1, keepdims=True))
    points = rays.origins[hit] + hits.t[hit, None] * d + n * 1e-4
    return points.astype(np.float32), n.astype(np.float32)


def _compare(
    trial: Trial,
    scene: vc.Scene,
    label: str,
    integrator: vc.AmbientOcclusion | vc.Direct,
    peer: Peer,
    job: dict[str, Any],
    quick: bool,
) -> None:
    side = 64 if quick else 512
    ours: dict[str, vc.Frame] = {}
    reports: dict[str, Any] = {}

    def run(coherent: bool) -> Sample:
        frame = vc.render(
            scene, integrator, visibility=vc.Exact(coherent=coherent), size=(side, side)
        )
        ours[str(coherent)] = frame
        return Sample(wall_s=frame.timings["total_s"], cpu_s=frame.timings["cpu_s"])

    def theirs() -> Sample:
        time, report = peer.run(job)
        reports.update(report)
        return time

    samples = interleave(
        {"coherent": lambda: run(True), "incoherent": lambda: run(False), "mitsuba": theirs},
        2 if quick else 3,
    )
    best = min(("coherent", "incoherent"), key=lambda k: min(s.cpu_s for s in samples[k]))
    frame = ours["True" if best == "coherent" else "False"]
    rate = [frame.counters["rays"] / s.cpu_s / 1e6 for s in samples[best]]
    base = [reports["rays"] / s.cpu_s / 1e6 for s in samples["mitsuba"]]
    wall = [
        frame.counters["rays"] / a.wall_s * b.wall_s / reports["rays"]
        for a, b in zip(samples[best], samples["mitsuba"], strict=True)
    ]
    trial.figure(
        f"{label} rays/s vs mitsuba",
        float(np.median(rate)),
        "Mray/s",
        baseline=float(np.median(base)),
        ratios=[a / b for a, b in zip(rate, base, strict=True)],
        goal=1.0,
        clock="cpu",
        ratio_wall=float(np.median(wall)),
        flag=best,
    )
    free = 1 - frame.counters["occluded"] / max(1, frame.counters["rays"])
    their_free = reports.get("open", 1 - reports.get("blocked", 0) / reports["rays"])
    trial.check(f"{label}: free share unlike mitsuba's", abs(free - their_free), 0.02)
    trial.check(
        f"{label}: bytes unlike under the other flag",
        float(ours["True"].sha256 != ours["False"].sha256),
        0,
    )
