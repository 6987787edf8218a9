"""Zero lights and 10⁵ of them, lights on surfaces and of next to no area; suns and black skies."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import METHODS, bad_pixels, picture, rel_l1

#: What asks every light.
ALL = vc.Direct(n_area=0, n_environment=0, n_brdf=0)
FEW_PIXELS = (8, 5)
MANY = 100_000
#: Places of a point light in the scene of the cube.
PLACES = {
    "at the camera": (-1.2, 2.6, 4.2),
    "in the floor": (0.5, 0.0, 0.5),
    "1e-7 above the floor": (0.5, 1e-7, 0.5),
    "in a vertex of the table": (0.5, 0.6, 0.5),
    "on an edge of the table": (0.5, 0.6, 0.0),
    "in the table": (0.1, 0.6, 0.2),
    "1e15 away": (1e15, 1e15, 1e15),
}


@FAMILIES.add("lights", "zero lights, 10⁵ lights, lights on surfaces and of next to no area")
def lights(full: bool) -> Iterator[Case]:
    for name, method in METHODS.items():
        if not method.maps:
            yield Case(
                name=f"{name}, no light: light and queries",
                measure=partial(_no_light, method.settings),
                why="nothing to ask",
            )
    yield Case(
        name=f"{MANY} lights in one place: rel_l1 against one light {MANY} times as bright",
        measure=lambda: rel_l1(_frame("one place"), _frame("one light")),
        limit=MANY / 16 * 6e-8,
        why="a pixel's sum runs in 16 lanes of single precision: as many roundings of 6e-8",
    )
    yield Case(
        name=f"{MANY} lights: rel_l1 against the sum of their halves",
        measure=_not_additive,
        limit=2e-6,
        why="light is additive; measured 2.4e-7, eight times that",
    )
    for name, limit in {
        "quantized cache": 0.15,
        'quantized cache "fast"': 0.15,
        "quantized cache, corrected": 0.02,
        "NEE++": 2e-3,
    }.items():
        yield Case(
            name=f"{name}, {MANY} lights: rel_l1",
            measure=partial(_error_of_many, name),
            limit=limit,
            why="cells are as large as this small picture: measured 0.066, 0.058, 0.008, 5e-4",
        )
    for name in ("exact by Embree", "exact by BSP", "quantized cache", "shadow maps", "NEE++"):
        for place, position in PLACES.items():
            yield Case(
                name=f"{name}, a light {place}: pixels that are not finite",
                measure=partial(_at, METHODS[name].settings, position),
                why="distances and cosines of 0 bring no light, and no division by 0",
            )
    for area in (1e-10, 1e-20, 1e-30):
        for name in ("exact by Embree", "exact by BSP"):
            yield Case(
                name=f"{name}, a lamp of area {area:g}: rel_l1 against 1e-6 and the same power",
                measure=partial(_tiny_lamp, METHODS[name].settings, area),
                limit=2e-3,
                why="the larger lamp is 1.4e-3 wide: measured 4.4e-4, 5 times that",
            )
    if full:
        yield Case(
            name="10⁴ emitting spheres: pixels that are not finite",
            measure=_spheres,
            why="a tree chooses among them",
        )


def _no_light(settings: dict[str, Any]) -> float:
    scene = scenes.with_parts(scenes.floor(), scenes.table(), lights=())
    frame = picture(scene, integrator=vc.Direct(), **settings)
    return float(np.abs(frame.image).sum() + frame.counters["queries"])


@cache
def _many(which: str) -> vc.Scene:
    """The floor and the table under 10⁵ lights, or parts of them."""
    rng = np.random.default_rng(2)
    places = rng.uniform(-1.5, 1.5, (MANY, 3)) + np.array([0, 2.5, 0])
    if which in ("one place", "one light"):
        places[:] = (2.2, 3.0, 1.2)
    power = 12.0 / MANY
    if which == "one light":
        places, power = places[:1], 12.0
    if which in ("even", "odd"):
        places = places[which == "odd" :: 2]
    lamps = tuple((tuple(map(float, p)), power) for p in places)
    return scenes.with_parts(scenes.floor(), scenes.table(), lights=lamps)


@cache
def _frame(which: str) -> vc.Frame:
    return picture(_many(which), integrator=ALL, size=FEW_PIXELS)


def _not_additive() -> float:
    whole, even, odd = (np.asarray(_frame(which).image, float) for which in ("all", "even", "odd"))
    return float(np.abs(whole - even - odd).sum() / whole.sum())


def _error_of_many(name: str) -> float:
    frame = picture(_many("all"), METHODS[name], integrator=ALL, size=FEW_PIXELS)
    return rel_l1(frame, _frame("all"))


def _at(settings: dict[str, Any], position: tuple[float, float, float]) -> float:
    lit = ((position, 12.0), ((2.2, 3.0, 1.2), 12.0))
    scene = scenes.with_parts(scenes.floor(), scenes.table(), lights=lit)
    return bad_pixels(picture(scene, integrator=ALL, **settings))


def _lamp(area: float) -> vc.Scene:
    """A triangle of this area and of a power that does not depend on it, above the table."""
    description = scenes.described(scenes.floor(), scenes.table(), lights=())
    black = description.add_material(base_color=(0.0, 0.0, 0.0))
    edge = np.sqrt(2 * area)
    corners = np.array([[0, 2, 0], [edge, 2, 0], [0, 2, edge]])
    one = np.array([[0, 1, 2]], np.uint32)
    description.add_mesh(corners, one, material=black, emission=(1.0 / area,) * 3)
    return vc.Scene.from_description(description)


def _tiny_lamp(settings: dict[str, Any], area: float) -> float:
    given = {"integrator": vc.Direct(n_area=1, n_brdf=0), **settings}
    return rel_l1(picture(_lamp(area), **given), picture(_lamp(1e-6), **given))


def _spheres() -> float:
    description = scenes.described(scenes.floor(), scenes.table(), lights=())
    rng = np.random.default_rng(4)
    for place in rng.uniform(-1.5, 1.5, (10_000, 3)) + np.array([0, 2.5, 0]):
        description.add_sphere_light(tuple(map(float, place)), 1e-3, (100.0,) * 3)
    scene = vc.Scene.from_description(description)
    return bad_pixels(picture(scene, integrator=vc.Direct(n_area=4), size=FEW_PIXELS))


OF_SKY = vc.Direct(n_area=0, n_environment=16, n_brdf=0)
PRODUCTS = vc.Direct(environment="product", n_environment=16)
#: Every way of estimating the light of a sky.
ESTIMATORS: dict[str, dict[str, Any]] = {
    "samples of the sky": {"integrator": OF_SKY},
    "both techniques": {"integrator": vc.Direct(n_area=0, n_environment=8, n_brdf=8)},
    "products": {"integrator": PRODUCTS},
    "shared directions": {"integrator": vc.Direct(environment="shared", n_environment=64)},
    "virtual lights": {"integrator": vc.Whitted(n_vpls=16, n_environment=16, n_brdf=0)},
    "bidirectional paths": {"integrator": vc.Bdpt(max_depth=2), "spp": 16},
    "quantized cache": {"integrator": OF_SKY, "visibility": vc.Aqvc(c_e=6, exact_groups=())},
    "NEE++": {"integrator": OF_SKY, "visibility": vc.NeePlusPlus(n_voxels=4, learn_pixels=64)},
    "visibility maps": {"integrator": PRODUCTS, "visibility": vc.VisMaps(n_startup=30)},
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
