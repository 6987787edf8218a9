"""Mitsuba 3 in a separate process (see `peers`)."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_mitsuba_kernels import MitsubaKernels
from viscache_lab.bench.peer_mitsuba_picture import MitsubaPicture
from viscache_lab.bench.peer_protocol import Fields, Pictures, serve


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
    picture = MitsubaPicture(mi, Path(sys.argv[1]))
    if variant == "scalar_rgb":
        # Single rays from Python would measure Python
        serve(about, {"sky": picture.sky})
        return
    scene = _scene(mi, picture)
    kernels = MitsubaKernels(mi, dr, scene)

    def rays(given: Fields) -> Any:
        ray = mi.Ray3f(mi.Point3f(given["origins"].T), mi.Vector3f(given["directions"].T))
        ray.maxt = float(given["t_max"])
        return ray

    def any_hit(given: Fields, _: Fields) -> dict[str, Any]:
        return {"occluded": np.array(scene.ray_test(rays(given)))}

    def nearest(given: Fields, _: Fields) -> dict[str, Any]:
        return {"t": np.array(scene.ray_intersect_preliminary(rays(given)).t)}

    frames = {"sky": picture.sky, "ao": kernels.ao, "points": kernels.points}
    serve(about, {"any_hit": any_hit, "nearest": nearest, **frames})


def _scene(mi: Any, arrays: Pictures) -> Any:
    mesh = mi.Mesh("all", len(arrays.vertices), len(arrays.triangles))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = arrays.vertices.astype(np.float32).ravel()
    parameters["faces"] = arrays.triangles.ravel()
    parameters.update()
    return mi.load_dict({"type": "scene", "embree_use_robust_intersections": True, "mesh": mesh})


if __name__ == "__main__":
    main()
