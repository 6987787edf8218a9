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

    rays = {"any_hit": any_hit, "nearest": nearest}
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
