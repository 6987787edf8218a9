"""Frames of a grey scene under a sky by Mitsuba's own integrator (see `peer_mitsuba`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache_lab.bench.peer_protocol import Fields, Pictures


class MitsubaPicture(Pictures):
    """The scene of a folder, its environment of the given arrays."""

    def __init__(self, mi: Any, folder: Path) -> None:
        super().__init__(folder)
        self._mi = mi

    def sky(self, given: Fields, fields: Fields) -> dict[str, Any]:
        """Direct light of `sky` (H, W, 3).

        Its samples have one of the light and one of the surface, as many in all as are asked for:
        so its stratified sampler spreads all of a pixel's together, as ours does.
        """
        spp = int(fields["spp"]) * int(fields["samples"])
        image = self._mi.render(self.scene(given, fields), spp=spp, seed=int(fields["seed"]))
        return {"image": np.array(image, np.float64)[:, :, :3].mean(axis=2)}

    def build(self, given: Fields, fields: Fields) -> Any:
        """With the integrator of direct light."""
        mi, side = self._mi, int(fields["side"])
        _write_ply(self.folder / "scene.ply", self.vertices, self.triangles)
        origin, forward, _, up = np.asarray(given["camera"], np.float64)
        view = mi.ScalarTransform4f().look_at(
            origin=origin.tolist(), target=(origin + forward).tolist(), up=up.tolist()
        )
        grey = {"type": "rgb", "value": [float(fields["albedo"])] * 3}
        return mi.load_dict(
            {
                "type": "scene",
                "embree_use_robust_intersections": True,
                "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1},
                "sensor": {
                    "type": "perspective",
                    "fov": float(np.degrees(fields["fov_rad"])),
                    "to_world": view,
                    "film": {
                        "type": "hdrfilm",
                        "width": side,
                        "height": side,
                        "rfilter": {"type": "box"},
                        "component_format": "float32",
                    },
                    "sampler": {"type": "multijitter"},
                },
                "sky": {"type": "envmap", "bitmap": mi.Bitmap(np.array(given["sky"], np.float32))},
                "mesh": {
                    "type": "ply",
                    "filename": str(self.folder / "scene.ply"),
                    "face_normals": True,
                    "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": grey}},
                },
            }
        )


def _write_ply(path: Path, vertices: npt.NDArray[Any], triangles: npt.NDArray[Any]) -> None:
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, triangles
    path.write_bytes(head.encode("ascii") + vertices.astype("<f4").tobytes() + faces.tobytes())
