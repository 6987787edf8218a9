"""Mitsuba 3 in a separate process (see `peers`)."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_mitsuba_kernels import MitsubaKernels
from viscache_lab.bench.peer_mitsuba_picture import MitsubaPicture
from viscache_lab.bench.peer_protocol import serve


def main() -> None:
    """Build the scene, then answer."""
    mi: Any = importlib.import_module("mitsuba")

    variant = "scalar_rgb" if sys.argv[2:] == ["mitsuba-scalar"] else "llvm_ad_rgb"
    try:
        mi.set_variant(variant)
    except ImportError as error:
        print(json.dumps({"error": f"Mitsuba's {variant} does not run: {error}"}), flush=True)
        return
    dr: Any = importlib.import_module("drjit")

    about = {"flags": "robust", "threads": dr.thread_count(), "version": mi.__version__}
    lit = {"sky": MitsubaPicture(mi, Path(sys.argv[1])).sky}
    if variant == "scalar_rgb":
        # Single rays from Python would measure Python
        serve(about, lit)
        return
    scene = _scene(mi)
    pictures = MitsubaKernels(mi, dr, scene)

    def any_hit(given: Mapping[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
        ray = mi.Ray3f(mi.Point3f(given["origins"].T), mi.Vector3f(given["directions"].T))
        ray.maxt = float(given["t_max"])
        return {"occluded": np.array(scene.ray_test(ray))}

    def nearest(given: Mapping[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
        ray = mi.Ray3f(mi.Point3f(given["origins"].T), mi.Vector3f(given["directions"].T))
        ray.maxt = float(given["t_max"])
        return {"t": np.array(scene.ray_intersect_preliminary(ray).t)}

    def lights(given: Mapping[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
        p, n = mi.Point3f(given["points"].T), mi.Vector3f(given["normals"].T)
        dr.eval(p, n)
        rays = blocked = 0
        for position in given["lights"]:
            d = mi.Point3f([float(v) for v in position]) - p
            ray = mi.Ray3f(p, d)
            ray.maxt = 0.9999
            asked = dr.dot(n, d) > 0
            hit = scene.ray_test(ray, asked) & asked
            counts = dr.count(asked), dr.count(hit)
            rays, blocked = rays + int(counts[0][0]), blocked + int(counts[1][0])
        return {"rays": rays, "blocked": blocked}

    def ambient(given: Mapping[str, Any], fields: Mapping[str, Any]) -> dict[str, Any]:
        p, n = mi.Point3f(given["points"].T), mi.Vector3f(given["normals"].T)
        frame = mi.Frame3f(n)
        pcg = mi.PCG32(size=len(given["points"]))
        open_ = mi.Float(0)
        samples = int(fields["samples"])
        for _ in range(samples):
            # Not mi.warp: its safe_sqrt needs an instruction that some LLVM cannot select
            u, (sine, cosine) = pcg.next_float32(), dr.sincos(2 * dr.pi * pcg.next_float32())
            r = dr.sqrt(u)
            local = mi.Vector3f(r * cosine, r * sine, dr.sqrt(1 - u))
            ray = mi.Ray3f(p, frame.to_world(local))
            open_ += dr.select(scene.ray_test(ray), 0.0, 1.0)
            dr.eval(open_, pcg)
        return {"rays": samples * len(given["points"]), "open": np.array(open_).mean() / samples}

    rays = {"any_hit": any_hit, "nearest": nearest, "lights": lights, "ambient": ambient}
    serve(about, rays | lit | {"ao": pictures.ao, "points": pictures.points})


def _scene(mi: Any) -> Any:
    with np.load(Path(sys.argv[1]) / "scene.npz") as file:
        vertices, triangles = file["vertices"], file["triangles"]
    mesh = mi.Mesh("all", len(vertices), len(triangles))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = vertices.astype(np.float32).ravel()
    parameters["faces"] = triangles.ravel()
    parameters.update()
    return mi.load_dict({"type": "scene", "embree_use_robust_intersections": True, "mesh": mesh})


if __name__ == "__main__":
    main()
