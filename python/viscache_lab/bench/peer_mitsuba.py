"""Mitsuba 3 in a separate process (see `peers`): rays, its own frames, frames of one kernel."""

from __future__ import annotations

import importlib
import itertools
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache_lab.bench.peer_protocol import Fields, Pictures, serve


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


#: Samples of one launch, so that memory stays small.
LAUNCH = 1 << 22


@dataclass(frozen=True)
class Samples:
    """The samples of a launch: their pixels, and their numbers in the pixel."""

    pixel: Any
    number: Any
    launch: int


class MitsubaKernels:
    """Ambient occlusion and all point lights; primary rays are random in their pixels."""

    def __init__(self, mi: Any, dr: Any, scene: Any) -> None:
        self._mi, self._dr, self._scene = mi, dr, scene

    def ao(self, given: Fields, fields: Fields) -> dict[str, Any]:
        """The open share of the hemisphere by `samples` cosine-distributed rays per hit.

        The rays of a pixel go through one R2 sequence (Roberts 2018) with a random offset.
        """
        mi, dr, scene = self._mi, self._dr, self._scene
        samples, reach = int(fields["samples"]), mi.Float(float(fields["reach"]))

        def shade(si: Any, normal: Any, at: Samples) -> Any:
            frame = mi.Frame3f(normal)
            # Offsets of the pixel; opaque, as the seed must not be a number in the kernel's code
            offset = mi.sample_tea_32(
                at.pixel, dr.opaque(mi.UInt32, int(fields["seed"]) * 64 + at.launch)
            )
            first = at.number * samples

            def unit(x: Any) -> Any:
                return mi.Float(x >> 8) * 2.0**-24

            def body(i: Any, open_: Any) -> Any:
                # Multiples of 1/p and 1/p², p = 1.3247…, in units of 2⁻³²
                u = unit(offset[0] + (first + i) * mi.UInt32(3242174889))
                v = unit(offset[1] + (first + i) * mi.UInt32(2447445414))
                # Not mi.warp: its safe_sqrt needs an instruction that some LLVM cannot select
                sine, cosine = dr.sincos(2 * dr.pi * v)
                r = dr.sqrt(u)
                local = mi.Vector3f(r * cosine, r * sine, dr.sqrt(1 - u))
                ray = si.spawn_ray(frame.to_world(local))
                ray.maxt = reach
                return i + 1, open_ + dr.select(scene.ray_test(ray), 0.0, 1.0)

            found = dr.while_loop((mi.UInt32(0), mi.Float(0)), lambda i, _: i < samples, body)
            return found[1] / samples

        return {"image": self._frame(given, fields, shade)}

    def points(self, given: Fields, fields: Fields) -> dict[str, Any]:
        """Light of all points of `lights` (N, 3), each of `intensity` W/sr, off a grey surface."""
        mi, dr, scene = self._mi, self._dr, self._scene
        lights = mi.Float(np.asarray(given["lights"], np.float32).ravel())
        count = len(given["lights"])
        scale = float(fields["albedo"]) / np.pi * float(fields["intensity"])

        def shade(si: Any, normal: Any, _: Samples) -> Any:
            def body(i: Any, sum_: Any) -> Any:
                light = dr.gather(mi.Point3f, lights, i)
                to = light - si.p
                square = dr.squared_norm(to)
                cosine = dr.dot(normal, to) * dr.rsqrt(square)
                asked = cosine > 0
                blocked = scene.ray_test(si.spawn_ray_to(light), asked)
                return i + 1, sum_ + dr.select(asked & ~blocked, cosine / square, 0.0)

            found = dr.while_loop((mi.UInt32(0), mi.Float(0)), lambda i, _: i < count, body)
            return found[1] * scale

        return {"image": self._frame(given, fields, shade)}

    def _frame(self, given: Fields, fields: Fields, shade: Callable[[Any, Any, Any], Any]) -> Any:
        """Means of the pixels (side, side); `camera` (4, 3) is origin, forward, right, up."""
        mi, dr = self._mi, self._dr
        side, spp = int(fields["side"]), int(fields["spp"])
        tangent = float(np.tan(float(fields["fov_rad"]) / 2))
        origin, forward, right, up = (mi.Vector3f([float(v) for v in a]) for a in given["camera"])
        image, passes = np.zeros(side * side), max(1, -(-side * side * spp // LAUNCH))
        bounds = [spp * i // passes for i in range(passes + 1)]
        for start, end in itertools.pairwise(bounds):
            n = end - start
            index = dr.arange(mi.UInt32, side * side * n)
            # Opaque: a number in the kernel's code would have it compiled again for each seed
            state = dr.opaque(mi.UInt64, int(fields["seed"]) * 4096 + start)
            pcg = mi.PCG32(size=side * side * n, initstate=state)
            pixel = index // n
            x = (mi.Float(pixel % side) + pcg.next_float32()) / side * 2 - 1
            y = 1 - (mi.Float(pixel // side) + pcg.next_float32()) / side * 2
            d = dr.normalize(forward + x * tangent * right + y * tangent * up)
            si = self._scene.ray_intersect(mi.Ray3f(mi.Point3f(origin), d))
            normal = dr.select(dr.dot(si.n, d) > 0, -si.n, si.n)
            at = Samples(pixel=pixel, number=index - pixel * n, launch=start)
            value = dr.select(si.is_valid(), shade(si, normal, at), 0.0)
            image = image + np.array(dr.block_sum(value, n), np.float64)
        return (image / spp).reshape(side, side)


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
