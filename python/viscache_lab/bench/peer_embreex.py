"""embreex in a separate process (see `peers`)."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_protocol import Fields, Pictures, serve


def main() -> None:
    """Build the scene, then answer."""
    from embreex import mesh_construction, rtcore_scene

    arrays = Pictures(Path(sys.argv[1]))
    scene = rtcore_scene.EmbreeScene(robust=True)
    corners = arrays.vertices[arrays.triangles].astype(np.float32)
    mesh_construction.TriangleMesh(scene, corners)

    def run(given: Fields, **how: Any) -> Any:
        # It has no t_max per call: dists has one entry per ray and is overwritten
        reach = min(float(given["t_max"]), 1e37)
        dists = np.full(len(given["origins"]), reach, np.float32)
        return scene.run(given["origins"], given["directions"], dists=dists, **how)

    def any_hit(given: Fields, _: Fields) -> dict[str, Any]:
        return {"occluded": np.asarray(run(given, query="OCCLUDED"))}

    def nearest(given: Fields, _: Fields) -> dict[str, Any]:
        found = run(given, output=True)
        return {"t": np.where(found["primID"] == -1, np.inf, found["tfar"])}

    about = {"flags": "robust", "threads": 1, "version": metadata.version("embreex")}
    serve(about, {"any_hit": any_hit, "nearest": nearest})


if __name__ == "__main__":
    main()
