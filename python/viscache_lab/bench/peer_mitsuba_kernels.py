"""Whole frames written with Mitsuba's rays: each is one compiled kernel (see `peer_mitsuba`)."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from viscache_lab.bench.peer_protocol import Fields

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

    def _frame(
        self,
        given: Fields,
        fields: Fields,
        shade: Callable[[Any, Any, Any], Any],
    ) -> Any:
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
