"""Virtual point lights: their expectation is the indirect light, whatever their number."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from core import testing
from render.mitsuba_scene import Look, Model, Part, ball, box, quad
from render.ztest import compare
from viscache._core import CoatKind, MaterialKind
from viscache._core.sampling import ShadingPoint

Images = npt.NDArray[np.float64]
#: Small, with many samples a pixel: an edge that crosses a pixel must be seen in every frame.
SIZE = (16, 12)

#: Walls that do not touch: the unbounded geometry term has no singular corners in sight.
FLOOR = quad((-3, 0, -3), (0, 0, 6), (6, 0, 0), look=Look(base_color=(0.8, 0.8, 0.8)))
RED = quad((-1.6, 0.3, -2), (0, 0, 3.5), (0, 2, 0), look=Look(base_color=(0.9, 0.2, 0.1)))
BLUE = quad((-1.2, 0.3, -2), (3, 0, 0), (0, 2, 0), look=Look(base_color=(0.2, 0.3, 0.9)))
GLOBE = ball((0.7, 0.7, -0.2), 0.4, look=Look(base_color=(0.5, 0.8, 0.4)))
LIGHTS: dict[str, dict[str, Any]] = {
    "point": {"points": (((0.3, 2.2, 1.0), (8, 8, 8)),)},
    "spot": {"spots": (((0.6, 2.4, 1.0), (20, 18, 15), (-0.3, -1, -0.4), (15.0, 35.0)),)},
    "directional": {"directions": (((0.3, 0.8, 0.52), (3, 3, 3)),)},
    "area": {"parts": (quad((0, 2.5, 0), (1, 0, 0), (0, 0, 1), emission=(9, 8, 7)),)},
    "sphere": {"spheres": (((0.5, 2.5, 0.8), 0.25, (20, 20, 15)),)},
    "sky": {"env": (0.8, 0.9, 1.0)},
}
#: Of them, one of each way to leave a light.
EACH_TIME = ("spot", "area", "sky")


def model(light: str) -> Model:
    extra = dict(LIGHTS[light])
    parts = (FLOOR, RED, BLUE, GLOBE, *extra.pop("parts", ()))
    return Model(parts, origin=(0.5, 2.2, 3.2), target=(0, 0.3, -0.5), **extra)


def indirect(scene: vc.Scene, seeds: int, **kwargs: Any) -> Images:
    settings = {"vpl_bound": 0.0, "vpl_max_depth": 3, "n_vpls": 2048} | kwargs
    settings |= {"n_area": 0, "n_environment": 0, "n_brdf": 0}
    frames = [
        vc.render(scene, vc.Whitted(**settings), size=SIZE, spp=9, seed=1000 + i)
        for i in range(seeds)
    ]
    dark = np.zeros_like(frames[0].image)  # of frames that found no virtual light
    return np.stack([f.layers.get("vpl", dark) for f in frames]).astype(np.float64)


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.mitsuba
@pytest.mark.parametrize(
    "light",
    [pytest.param(n, marks=() if n in EACH_TIME else pytest.mark.release) for n in LIGHTS],
)
def test_the_expectation_over_seeds_is_mitsubas_indirect_light(light: str, tmp_path: Path) -> None:
    """3 bounces of a light path, one to the eye: edges 3 to 5, less the direct light of edge 2."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    scene = model(light).to_mitsuba(mi, SIZE, tmp_path)

    def path(depth: int, seed: int) -> Any:
        integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 1000})
        return np.array(mi.render(scene, integrator=integrator, spp=512, seed=seed), np.float64)[
            ..., :3
        ]

    # The same seed does not pair the samples; the difference has the variance of both
    reference = np.stack([path(5, i) - path(2, 500 + i) for i in range(16)])
    ours = indirect(model(light).to_viscache(), 32)
    found = compare(ours, reference, tolerance=1e-4)
    assert found.same, found
    # Virtual lights are shared by all pixels: 5 % of the indirect light is what these seeds can see
    assert not compare(0.95 * ours, reference, tolerance=1e-4).same
    shallow = indirect(model(light).to_viscache(), 8, n_vpls=1024, vpl_max_depth=1)
    assert not compare(shallow, reference, tolerance=1e-4).same


@pytest.mark.slow
@pytest.mark.stat
def test_resampling_does_not_change_the_expectation() -> None:
    """Few and many of the candidates carry the light of paths of 3 to 5 edges."""
    scene = model("point").to_viscache()

    def paths(depth: int, seed: int) -> Any:
        chosen = vc.Bdpt(max_depth=depth)
        return vc.render(scene, chosen, size=SIZE, spp=64, seed=seed).image.astype(np.float64)

    reference = np.stack([paths(5, i) - paths(2, 500 + i) for i in range(24)])
    for n in (64, 512, 2048):
        found = compare(indirect(scene, 24, n_vpls=n), reference, tolerance=1e-4)
        assert found.same, (n, found)
    assert not compare(0.96 * indirect(scene, 24), reference, tolerance=1e-4).same


def test_virtual_lights_carry_no_direct_light() -> None:
    """Nothing reflects twice from a plane: all its light is direct, its VPLs give it none."""
    for light in LIGHTS:
        extra = dict(LIGHTS[light])
        black = tuple(replace(p, look=Look(base_color=(0, 0, 0))) for p in extra.pop("parts", ()))
        lit = Model((FLOOR, *black), origin=(0, 2, 2), target=(0, 0, 0), **extra).to_viscache()
        frame = vc.render(lit, vc.Whitted(n_vpls=64), size=SIZE)
        assert frame.counters["vpls"] > 0, light
        assert not frame.layers["vpl"].any() and frame.counters["groups"]["vpl"]["queries"] == 0


def test_the_number_of_virtual_lights_is_at_most_what_is_asked_for() -> None:
    scene = model("area").to_viscache()
    for n in (1, 7, 64, 1000):
        vpls = vc.render(scene, vc.Whitted(n_vpls=n), size=(8, 6)).counters["vpls"]
        assert 1 <= vpls <= n
    assert vc.render(scene, vc.Whitted(n_vpls=0), size=(8, 6)).counters["vpls"] == 0


def test_a_bound_takes_light_away_and_the_default_little() -> None:
    scene = model("point").to_viscache()
    free, slight, strong = (
        indirect(scene, 4, n_vpls=1024, vpl_bound=b).mean() for b in (0.0, 0.01, 0.2)
    )
    assert strong < 0.8 * free
    assert 0.9 * free < slight < 1.05 * free


def test_a_scene_that_leaves_no_virtual_light_renders() -> None:
    black = Look(base_color=(0, 0, 0))
    nothing = Model((replace(FLOOR, look=black),), points=(((0, 1, 0), (1, 1, 1)),))
    unlit = Model((FLOOR,))
    away = Model((FLOOR,), directions=(((0, -1, 0), (1, 1, 1)),))
    for lone in (
        nothing,
        unlit,
        replace(away, parts=(replace(FLOOR, look=Look(two_sided=False)),)),
    ):
        frame = vc.render(lone.to_viscache(), vc.Whitted(n_vpls=32), size=(8, 6))
        assert frame.counters["vpls"] == 0 and np.isfinite(frame.image).all()


@pytest.mark.stat
def test_light_by_way_of_a_mirror_reaches_the_floor() -> None:
    """VPLs at the end of light → mirror → ceiling: more than without the mirror."""
    mirror = quad((-1, 0.1, -1), (0, 0, 2), (2, 0, 0), look=Look(kind="mirror"))
    roof = quad((-2, 2, -2), (4, 0, 0), (0, 0, 4), look=Look(base_color=(0.8, 0.8, 0.8)))
    wall = quad((-2, 0, -2), (4, 0, 0), (0, 2, 0), look=Look(base_color=(0.8, 0.8, 0.8)))
    lamp: dict[str, Any] = {
        "points": (((0, 0.6, 0), (2, 2, 2)),),
        "origin": (0, 1, 3),
        "target": (0, 1.2, 0),
    }
    seen = [
        indirect(Model(parts, **lamp).to_viscache(), 4).mean()
        for parts in (
            (mirror, roof, wall),
            (replace(mirror, look=Look(base_color=(0, 0, 0))), roof, wall),
        )
    ]
    assert seen[0] > 1.3 * seen[1] > 0


# Shading normals and glossy surfaces. Light from straight above meets a floor alone; a wall beside
# it sees what the floor's virtual lights bring.

WHITE = Look(base_color=(0.8, 0.8, 0.8))


def bent(part: Part, degrees: float) -> Part:
    """The part with shading normals turned from +y towards −z."""
    normal = np.array([0, np.cos(np.radians(degrees)), -np.sin(np.radians(degrees))], np.float32)
    return replace(part, normals=np.tile(normal, (len(part.vertices), 1)))


def on_the_wall(floor: Part, direction: tuple[float, float, float] = (0, 1, 0)) -> float:
    wall = quad((-1.5, 0.3, -1.6), (3, 0, 0), (0, 2, 0), look=WHITE)
    scene = Model(
        (floor, wall),
        directions=((direction, (3, 3, 3)),),
        origin=(0, 1.2, 3),
        target=(0, 1.2, -1.6),
        fov_deg=15,
    )
    light = indirect(scene.to_viscache(), 1, n_vpls=512, vpl_max_depth=1)
    return float(light.mean())


SHEET = quad((-1.5, 0, -1.5), (0, 0, 3), (3, 0, 0), look=WHITE)


@pytest.mark.parametrize("degrees", [20, 60, 89])
def test_virtual_lights_take_up_light_by_the_shading_normal(degrees: float) -> None:
    expected = np.cos(np.radians(degrees)) * on_the_wall(bent(SHEET, 0))
    assert on_the_wall(bent(SHEET, degrees)) == pytest.approx(expected, rel=1e-4)
    assert on_the_wall(bent(SHEET, 0)) == on_the_wall(SHEET) > 0.01


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.mitsuba
def test_light_of_bent_normals_is_mitsubas(tmp_path: Path) -> None:
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    wall = quad((-1.5, 0.3, -1.6), (3, 0, 0), (0, 2, 0), look=WHITE)
    view: dict[str, Any] = {"origin": (0, 1.2, 3), "target": (0, 1.2, -1.6), "fov_deg": 15}
    lit = Model((bent(SHEET, 40), wall), points=(((0.3, 2.2, 1.0), (8, 8, 8)),), **view)
    scene = lit.to_mitsuba(mi, SIZE, tmp_path)

    def path(depth: int, seed: int) -> Any:
        integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 1000})
        image = mi.render(scene, integrator=integrator, spp=512, seed=seed)
        return np.array(image, np.float64)[..., :3]

    reference = np.stack([path(3, i) - path(2, 500 + i) for i in range(8)])
    settings = {"vpl_max_depth": 1, "n_vpls": 1024}
    found = compare(indirect(lit.to_viscache(), 16, **settings), reference, tolerance=1e-4)
    assert found.same and abs(found.energy) < 0.05, found
    plain = replace(lit, parts=(SHEET, wall)).to_viscache()
    assert not compare(indirect(plain, 4, **settings), reference, tolerance=1e-4).same


@pytest.mark.stat
def test_a_mirror_with_bent_normals_sends_photons_where_eyes_look() -> None:
    """Its beam is that of a mirror turned by as much and cut to the beam's width."""
    angle = np.radians(20)
    look = Look(kind="mirror")
    flat = quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0), look=look)
    deep = np.cos(2 * angle) / np.cos(angle)
    across = (0.0, float(deep * np.sin(angle)), float(deep * np.cos(angle)))
    corner = (-0.5, -across[1] / 2, -across[2] / 2)
    turned = quad(corner, across, (1, 0, 0), look=look)
    # The beam leaves at 40° towards −z and lights the catcher, which lights the screen
    catcher = quad((-2, 0.5, -3), (4, 0, 0), (0, 6, 0), look=WHITE)
    screen = quad((-2, 0.5, 2), (0, 4, 0), (4, 0, 0), look=WHITE)
    view: dict[str, Any] = {"origin": (0, 2.5, -2.5), "target": (0, 2.5, 2), "fov_deg": 30}
    seen = [
        indirect(
            Model(
                (mirror, catcher, screen), directions=(((0, 1, 0), (3, 3, 3)),), **view
            ).to_viscache(),
            4,
            vpl_max_depth=2,
            n_vpls=512,
        ).mean()
        for mirror in (bent(flat, 20), turned, bent(flat, 0))
    ]
    assert seen[0] == pytest.approx(seen[1], rel=0.02) and seen[0] > 1e-3
    assert seen[2] == 0


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("f0", [0.04, 0.5, 1.0])
def test_a_glossy_surface_gives_its_virtual_lights_what_the_lobe_leaves(
    cosine: float, f0: float
) -> None:
    direction = (float(np.sqrt(1 - cosine**2)), cosine, 0.0)
    plastic = Look(kind="glossy", base_color=(0.8, 0.8, 0.8), specular=(f0,) * 3)
    share = 0.99714 * (1 - f0) * (1 - (1 - cosine) ** 5)
    expected = share * on_the_wall(SHEET, direction)
    found = on_the_wall(replace(SHEET, look=plastic), direction)
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-12)


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("coat", list(CoatKind)[1:])
def test_a_coated_surface_gives_its_virtual_lights_what_leaves_the_coat(
    cosine: float, coat: CoatKind
) -> None:
    direction = (float(np.sqrt(1 - cosine**2)), cosine, 0.0)
    look = Look(kind="glossy", base_color=(0.8, 0.8, 0.8), coat=coat, nonlinear=True)
    lit = ShadingPoint(
        MaterialKind.GLOSSY,
        (direction[0], 0, cosine),
        base=look.base_color,
        roughness=look.roughness,
        coat=coat,
        nonlinear=True,
    )
    expected = testing.diffuse_albedo(lit)[0] / 0.8 * on_the_wall(SHEET, direction)
    found = on_the_wall(replace(SHEET, look=look), direction)
    assert found == pytest.approx(expected, rel=1e-4)


@pytest.mark.stat
def test_a_thin_plate_takes_from_virtual_lights_what_it_reflects() -> None:
    def below(eta: float) -> float:
        plate = Look(kind="dielectric", eta=eta, thin=True)
        wall = quad((-1.5, 0.3, -1.6), (3, 0, 0), (0, 2, 0), look=WHITE)
        parts = (SHEET, wall, quad((-1.5, 4, -1.5), (0, 0, 3), (3, 0, 0), look=plate))
        view: dict[str, Any] = {"origin": (0, 1.2, 3), "target": (0, 1.2, -1.6), "fov_deg": 15}
        scene = Model(parts, directions=(((0, 1, 0), (3, 3, 3)),), **view).to_viscache()
        return float(indirect(scene, 4, n_vpls=1024, vpl_max_depth=2).mean())

    fresnel = (1.5 / 3.5) ** 2
    assert below(2.5) == pytest.approx((1 - 2 * fresnel / (1 + fresnel)) * below(1), rel=0.05)


def test_box_and_all_kinds_of_light_at_once_stay_finite() -> None:
    room = box((-2, 0, -2), (2, 2.5, 2)).reversed()
    everything = Model(
        (room, GLOBE, *LIGHTS["area"]["parts"]),
        points=LIGHTS["point"]["points"],
        spheres=LIGHTS["sphere"]["spheres"],
        env=(1, 1, 1),
        origin=(0, 1, 1.8),
    )
    frame = vc.render(
        everything.to_viscache(), vc.Whitted(n_vpls=256, vpl_bound=0), size=SIZE, spp=4
    )
    assert np.isfinite(frame.image).all() and frame.image.min() >= 0
