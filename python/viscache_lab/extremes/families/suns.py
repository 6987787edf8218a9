"""Skies of one bright pixel, black skies: every estimator keeps its scale and stays finite."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import bad_pixels, picture

#: Every way of estimating the light of a sky.
ESTIMATORS: dict[str, dict[str, Any]] = {
    "samples of the sky": {"integrator": vc.Direct(n_area=0, n_environment=16, n_brdf=0)},
    "both techniques": {"integrator": vc.Direct(n_area=0, n_environment=8, n_brdf=8)},
    "products": {"integrator": vc.Direct(environment="product", n_environment=16)},
    "shared directions": {"integrator": vc.Direct(environment="shared", n_environment=64)},
    "virtual lights": {"integrator": vc.Whitted(n_vpls=16, n_environment=16, n_brdf=0)},
    "bidirectional paths": {"integrator": vc.Bdpt(max_depth=2), "spp": 16},
    "quantized cache": {
        "integrator": vc.Direct(n_area=0, n_environment=16, n_brdf=0),
        "visibility": vc.Aqvc(c_e=6, exact_groups=()),
    },
    "NEE++": {
        "integrator": vc.Direct(n_area=0, n_environment=16, n_brdf=0),
        "visibility": vc.NeePlusPlus(n_voxels=4, learn_pixels=64),
    },
    "visibility maps": {
        "integrator": vc.Direct(environment="product", n_environment=16),
        "visibility": vc.VisMaps(n_startup=30),
    },
}
LINEAR = "light is linear, samples are the same: sums round by 1e-7; measured 1.6e-7, times 12"
#: Pixels along an edge of the sun that is compared with the integral: a sky of few pixels changes
#: its shape when it is resampled.
FINE = 8


@FAMILIES.add("suns", "skies of one bright pixel, and black skies")
def suns(full: bool) -> Iterator[Case]:
    powers = (1e6, 1e-6, 1e12, 1e20, 1e30, 1e37, 1e-20, 1e-30) if full else (1e6, 1e30, 1e-20)
    for name, how in ESTIMATORS.items():
        for radiance in powers:
            yield Case(
                name=f"{name}, a sun of {radiance:g}: rel_l1 against {radiance:g} times that of 1",
                measure=partial(not_linear, how, radiance),
                limit=2e-6,
                why=LINEAR,
            )
        yield Case(
            name=f"{name}, a sun of 1e6: energy against the integral",
            measure=partial(off_integral, how, 1e6),
            limit=3e-3,
            why="the floor lies open, so the integral is known; resampling of the sky costs 5e-4, "
            "and the noise is 6e-4 at most",
        )
        yield Case(
            name=f"{name}, a black sky: light, and pixels that are not finite",
            measure=partial(_of_black, how),
            why="no light, nothing to divide by",
        )
    yield Case(
        name="a sun of 1e39, infinity in single precision: not refused",
        measure=_accepted,
        why="values that are not finite are refused",
    )


def sun(radiance: float, fine: int = 1) -> npt.NDArray[np.float32]:
    """A sky of 8 × 16 squares of `fine`² pixels, one of them bright, well above the horizon."""
    made = np.zeros((8 * fine, 16 * fine, 3), np.float32)
    made[fine : 2 * fine, 5 * fine : 6 * fine] = radiance
    return made


@cache
def _open_floor() -> vc.Scene:
    return scenes.with_parts(scenes.floor(50.0), lights=(), camera=((0, 3, 6), (0, 0, 0), 20.0))


def not_linear(how: dict[str, Any], radiance: float) -> float:
    """rel_l1 between the picture of a sun and so many times the picture of the sun of 1."""
    one, many = (
        np.asarray(picture(_open_floor(), env=sun(r), **how).image, float) for r in (1.0, radiance)
    )
    return float(np.abs(many / radiance - one).sum() / one.sum())


def off_integral(how: dict[str, Any], radiance: float) -> float:
    """How far the mean of eight frames is from the integral, as a share of it."""
    sky = sun(radiance, FINE)
    frames = [picture(_open_floor(), env=sky, **{**how, "seed": s}) for s in range(8)]
    mean = np.mean([np.asarray(f.image, float).mean() for f in frames])
    return float(abs(mean / _integral(radiance) - 1))


def _integral(radiance: float) -> float:
    """Light reflected by a floor of albedo 1/2 under the sun's pixel: half of ∫ L cosθ dω / π."""
    theta, width = np.pi / 8 * np.array([1.0, 2.0]), 2 * np.pi / 16
    cosines = (np.cos(theta[0]) ** 2 - np.cos(theta[1]) ** 2) / 2
    return float(0.5 * radiance * cosines * width / np.pi)


def _of_black(how: dict[str, Any]) -> float:
    frame = picture(_open_floor(), env=np.zeros((8, 16, 3), np.float32), **how)
    return bad_pixels(frame) + float(np.abs(frame.image).sum())


def _accepted() -> float:
    try:
        frame = picture(_open_floor(), env=[1e39] * 3)
    except ValueError:
        return 0.0
    return 1.0 + bad_pixels(frame)
