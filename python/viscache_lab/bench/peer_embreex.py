"""embreex in a separate process (see `peers`)."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_protocol import serve


def main() -> None:
    """Build the scene, then answer."""
    from embreex import mesh_construction, rtcore_scene

    with np.load(Path(sys.argv[1]) / "scene.npz") as file:
        vertices, triangles = file["vertices"], file["triangles"]
    scene = rtcore_scene.EmbreeScene(robust=True)
    mesh_construction.TriangleMesh(scene, vertices[triangles].astype(np.float32))

    def any_hit(given: Mapping[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
        n = len(given["origins"])
        # It has no t_max per call: dists has one entry per ray and is overwritten
        dists = np.full(n, min(float(given["t_max"]), 1e37), np.float32)
        found = scene.run(given["origins"], given["directions"], dists=dists, query="OCCLUDED")
        return {"occluded": np.asarray(found)}

    def nearest(given: Mapping[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
        dists = np.full(len(given["origins"]), min(float(given["t_max"]), 1e37), np.float32)
        found = scene.run(given["origins"], given["directions"], dists=dists, output=True)
        return {"t": np.where(found["primID"] == -1, np.inf, found["tfar"])}

    serve(
        {"flags": "robust", "threads": 1, "version": metadata.version("embreex")},
        {"any_hit": any_hit, "nearest": nearest},
    )


if __name__ == "__main__":
    main()
