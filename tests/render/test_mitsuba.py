"""Exact frames against Mitsuba 3, an independent renderer: z-tests over seeds, each with its power.

Mitsuba renders with `path`: its `direct` counts a delta light `emitter_samples` times. max_depth 2
is direct light. Both sides use a box filter of one pixel.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from render.mitsuba_frames import SIZE, Images, assert_same, ours, theirs
from render.mitsuba_scene import Look, Model, Part, ball, box, quad, sensor
from render.ztest import compare
from viscache import _core

pytestmark = [pytest.mark.mitsuba, pytest.mark.stat]


def without(model: Model, field: str, index: int) -> Model:
    lights = getattr(model, field)
    return replace(model, **{field: lights[:index] + lights[index + 1 :]})


GREY = Look(base_color=(0.6, 0.5, 0.4))
FLOOR = quad((-3, 0, -3), (0, 0, 6), (6, 0, 0), look=GREY)
BLOCK = box((-0.9, 0, -0.5), (-0.3, 0.9, 0.2), look=Look(base_color=(0.2, 0.5, 0.7)))
GLOBE = ball((0.6, 0.5, 0.2), 0.5, look=Look(base_color=(0.8, 0.3, 0.2)))


#: Of seeds, on both sides, where one percent of the light shows in single blocks and pixels.
FEW: dict[str, int] = {"seeds": 24}


# Three scenes for comparison


@pytest.fixture(scope="module")
def cornell() -> Path:
    path = Path(os.environ.get("VISCACHE_SCENES", "../shared/scenes")) / "cornell-box" / "scene.xml"
    if not path.exists():
        pytest.skip(f"there is no {path}")
    return path


@pytest.fixture(scope="module")
def cornell_reference(mi: Any, cornell: Path) -> Images:
    to_world = mi.ScalarTransform4f([[-1, 0, 0, 0], [0, 1, 0, 1], [0, 0, -1, 6.8], [0, 0, 0, 1]])
    camera = mi.load_dict(sensor(to_world, SIZE, fov=19.5, fov_axis="x"))
    return theirs(mi, mi.load_file(str(cornell)), sensor=camera)


def test_the_cornell_box_has_mitsubas_direct_light(
    cornell: Path, cornell_reference: Images
) -> None:
    assert_same(ours(vc.load_scene(cornell)), cornell_reference)


def test_the_cornell_box_with_its_light_turned_around_is_told_apart(
    cornell: Path, cornell_reference: Images
) -> None:
    """A light's cosine with the wrong sign: it shines at the ceiling."""
    scene = vc.load_scene(cornell)
    description, materials = vc.SceneDescription(), _core.scene_materials(scene._core)
    for mesh in scene.meshes():
        order = [2, 1, 0] if max(mesh["emission"]) > 0 else [0, 1, 2]
        material = description.add_material(base_color=materials[mesh["material"]]["base_color"])
        description.add_mesh(
            mesh["vertices"],
            mesh["triangles"][:, order],
            material=material,
            emission=mesh["emission"],
        )
    camera = scene.cameras[0]
    target = np.add(camera.origin, camera.forward)
    description.add_camera(
        camera.origin,
        target,
        up=camera.up,
        fov_deg=np.degrees(camera.fov_rad),
        horizontal=camera.fov_is_horizontal,
    )
    turned = vc.Scene.from_description(description)
    assert not compare(ours(turned, seeds=4), cornell_reference).same


POINTS = Model(
    (FLOOR, BLOCK, GLOBE),
    points=(
        ((1.5, 2.0, 1.5), (8, 6, 4)),
        ((-2, 2.5, 0.5), (2, 4, 9)),
        ((0, 1.2, 1.0), (0.5, 0.5, 0.5)),
    ),
    directions=(((0.48, 0.6, 0.64), (0.4, 0.5, 0.3)),),
)


@pytest.fixture(scope="module")
def point_reference(mi: Any, tmp_path_factory: pytest.TempPathFactory) -> Images:
    return theirs(mi, POINTS.to_mitsuba(mi, SIZE, tmp_path_factory.mktemp("points")))


def test_point_and_directional_light_is_mitsubas(point_reference: Images) -> None:
    assert_same(ours(POINTS.to_viscache()), point_reference)


@pytest.mark.parametrize(
    "wrong",
    [
        pytest.param(without(POINTS, "points", 2), id="the weakest point light dropped"),
        pytest.param(without(POINTS, "directions", 0), id="the directional light dropped"),
        pytest.param(
            replace(
                POINTS,
                parts=(
                    FLOOR,
                    BLOCK,
                    replace(GLOBE, look=replace(GLOBE.look, two_sided=False)).reversed(),
                ),
            ),
            id="one body's cosine flipped",
        ),
        pytest.param(replace(POINTS, parts=(FLOOR, BLOCK)), id="one body missing"),
    ],
)
def test_wrong_point_lit_scenes_are_told_apart(wrong: Model, point_reference: Images) -> None:
    assert not compare(ours(wrong.to_viscache(), seeds=4), point_reference).same


SKY = Model((FLOOR, BLOCK, GLOBE), env=(0.5, 0.8, 1.3))


@pytest.fixture(scope="module")
def sky_reference(mi: Any, tmp_path_factory: pytest.TempPathFactory) -> Images:
    return theirs(mi, SKY.to_mitsuba(mi, SIZE, tmp_path_factory.mktemp("sky")), spp=24, **FEW)


@pytest.mark.parametrize(("light", "brdf"), [(16, 16), (32, 0), (0, 32)])
def test_a_constant_sky_is_mitsubas_by_every_split_of_samples(
    light: int, brdf: int, sky_reference: Images
) -> None:
    split = vc.Direct(n_environment=light, n_brdf=brdf)
    assert_same(ours(SKY.to_viscache(), split, **FEW), sky_reference)


def test_a_sky_without_one_body_is_told_apart(sky_reference: Images) -> None:
    wrong = replace(SKY, parts=(FLOOR, GLOBE))
    assert not compare(ours(wrong.to_viscache(), seeds=4), sky_reference).same


def smooth_map(width: int = 1024) -> npt.NDArray[np.float32]:
    """A sky with a soft sun to one side; no two axes alike.

    Mitsuba puts the first and the last row at the poles, and so the sun up to half a row higher:
    of 128 rows, its frames have 0.14 % more light than ours, of 512 rows 0.04 %.
    """
    v, u = np.meshgrid(
        (np.arange(width // 2) + 0.5) / (width // 2),
        (np.arange(width) + 0.5) / width,
        indexing="ij",
    )
    theta, phi = np.pi * v, 2 * np.pi * u
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], -1)
    sun = 6 * np.exp(8 * (d @ np.array([0.6, 0.64, 0.48]) - 1))
    sky = 0.3 + 0.2 * d[..., 1] + 0.1 * d[..., 0]
    return np.stack([sun + sky, 0.8 * sun + sky, 0.5 * sun + 1.5 * sky], -1).astype(np.float32)


@pytest.mark.slow
def test_a_smooth_environment_map_is_mitsubas(mi: Any, tmp_path: Path) -> None:
    """The camera looks down: the map's texels, which we resample, are seen by their light alone."""
    model = replace(SKY, env=smooth_map(), origin=(0.5, 3.5, 2.0), target=(0, 0, 0), fov_deg=30)
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path))
    image = ours(model.to_viscache())
    assert_same(image, reference)
    turned = replace(model, env=np.ascontiguousarray(np.roll(smooth_map(), 128, axis=1)))
    assert not compare(ours(turned.to_viscache(), seeds=4), reference).same, (
        "45° of rotation are not seen"
    )


# Lights


def test_area_lights_of_two_colours_and_sizes_are_mitsubas(mi: Any, tmp_path: Path) -> None:
    lamps = (
        quad((-0.5, 2, -0.5), (1, 0, 0), (0, 0, 1), emission=(6, 5, 4)),
        quad((2, 0.2, -1), (0, 0, 1.5), (0, 1, 0), emission=(1, 2, 5)).reversed(),
    )
    model = Model((FLOOR, BLOCK, GLOBE, *lamps))
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path))
    assert_same(ours(model.to_viscache(), vc.Direct(n_area=32)), reference, edge=4)
    for wrong in (lamps[:1], (lamps[0], lamps[1].reversed())):
        image = ours(replace(model, parts=(FLOOR, BLOCK, GLOBE, *wrong)).to_viscache(), seeds=4)
        assert not compare(image, reference).same


@pytest.mark.slow
def test_sphere_lights_are_mitsubas(mi: Any, tmp_path: Path) -> None:
    """Out of sight: seen directly, a tessellated silhouette differs."""
    model = Model(
        (FLOOR, BLOCK, GLOBE),
        spheres=(((0.5, 2.6, 0.5), 0.3, (9, 8, 7)), ((-2.6, 0.4, 1.8), 0.2, (3, 6, 9))),
        origin=(0.3, 1.6, 3.0),
        target=(0, 0.2, 0),
    )
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path))
    assert_same(ours(model.to_viscache(), vc.Direct(n_area=32), spp=8), reference, edge=4)
    assert not compare(ours(without(model, "spheres", 1).to_viscache(), seeds=4), reference).same


# Materials


@pytest.mark.parametrize("roughness", [0.15, pytest.param(0.5, marks=pytest.mark.slow)])
def test_a_ggx_lobe_is_mitsubas_rough_conductor(roughness: float, mi: Any, tmp_path: Path) -> None:
    metal = Look(kind="glossy", base_color=(0, 0, 0), roughness=roughness)
    model = Model(
        (replace(FLOOR, look=metal), replace(GLOBE, look=metal)),
        points=(((0.5, 2.5, 0.5), (4, 4, 4)),),
        env=(0.4, 0.5, 0.6),
    )
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), **FEW)
    both = vc.Direct(n_environment=16, n_brdf=16)
    assert_same(ours(model.to_viscache(), both, spp=8, **FEW), reference)
    rougher = replace(metal, roughness=roughness * 1.2)
    wrong = replace(model, parts=tuple(replace(p, look=rougher) for p in model.parts))
    assert not compare(ours(wrong.to_viscache(), seeds=4), reference).same


def test_a_textured_floor_is_mitsubas(mi: Any, tmp_path: Path) -> None:
    """Asymmetric pattern: a swapped or turned axis shows."""
    rng = np.random.default_rng(3)
    texture = rng.uniform(0.1, 0.9, (5, 7, 3)).astype(np.float32)
    look = Look(base_color=(1, 0.8, 0.6), texture=texture)
    model = Model((replace(FLOOR, look=look), BLOCK), points=(((0.5, 2.5, 1.5), (8, 8, 8)),))
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), **FEW)
    assert_same(ours(model.to_viscache(), **FEW), reference)
    upside_down = replace(look, texture=np.ascontiguousarray(texture[::-1]))
    wrong = replace(model, parts=(replace(FLOOR, look=upside_down), BLOCK))
    assert not compare(ours(wrong.to_viscache(), seeds=4), reference).same


@pytest.mark.parametrize("two_sided", [True, False])
def test_back_sides_are_mitsubas(two_sided: bool, mi: Any, tmp_path: Path) -> None:
    look = Look(base_color=(0.7, 0.6, 0.5), two_sided=two_sided)
    front = quad((-1.5, 0.2, 0), (1.2, 0, 0), (0, 1.2, 0), look=look)
    back = quad((0.3, 0.2, 0), (1.2, 0, 0), (0, 1.2, 0), look=look).reversed()
    model = Model((FLOOR, front, back), points=(((0, 2.0, 2.0), (8, 8, 8)),), env=(0.2, 0.2, 0.2))
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), **FEW)
    assert_same(ours(model.to_viscache(), **FEW), reference)


def test_interpolated_normals_shade_as_mitsubas(mi: Any, tmp_path: Path) -> None:
    """Finely divided: a normal that looks away from the eye is bent by us, black in Mitsuba."""
    globe = ball((0, 0.7, 0), 0.7, 40, smooth=True, look=GREY)
    model = Model((FLOOR, globe), points=(((1.5, 2.5, 2.5), (9, 9, 9)),), target=(0, 0.5, 0))
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), **FEW)
    faceted = replace(model, parts=(FLOOR, ball((0, 0.7, 0), 0.7, 12, look=GREY)))
    image = ours(model.to_viscache(), **FEW)
    assert_same(image, reference)
    assert not compare(ours(faceted.to_viscache(), seeds=4), reference).same


# Eye paths through mirrors and glass, without virtual lights. Albedos of 1/1000 leave little
# between diffuse surfaces for Mitsuba to find: 1/2000 is tolerated.

SPECULAR_TOLERANCE = 5e-4
DIM = Look(base_color=(1e-3, 1e-3, 8e-4))
BARE = vc.Whitted(n_vpls=0, n_area=32)


@pytest.mark.slow
def test_mirrors_show_what_mitsuba_sees_in_them(mi: Any, tmp_path: Path) -> None:
    mirror = Look(kind="mirror", specular=(0.9, 0.7, 0.5))
    model = Model(
        (
            replace(FLOOR, look=DIM),
            box((-1.2, 0, -0.2), (-0.5, 0.8, 0.4), look=DIM),
            quad((-1.5, 0, -0.8), (3, 0, 0.4), (0, 1.8, 0), look=mirror),
            quad((1.4, 0, 1.4), (0, 1.5, 0), (-0.3, 0, -2.0), look=mirror),
        ),
        points=(((0.3, 2.0, 1.0), (8e3, 8e3, 8e3)),),
        env=(0.3, 0.4, 0.5),
    )
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), depth=6, spp=24)
    image = ours(model.to_viscache(), replace(BARE, max_depth=4))
    assert_same(image, reference, SPECULAR_TOLERANCE)
    shallow = ours(model.to_viscache(), replace(BARE, max_depth=1), spp=16, seeds=4)
    assert not compare(shallow, reference, tolerance=SPECULAR_TOLERANCE).same, (
        "mirrors in mirrors are not seen"
    )


@pytest.mark.parametrize("eta", [1.5, pytest.param(1 / 1.3, marks=pytest.mark.slow)])
def test_glass_shows_what_mitsuba_sees_through_it(eta: float, mi: Any, tmp_path: Path) -> None:
    glass = Look(kind="dielectric", eta=eta)
    model = Model(
        (
            replace(FLOOR, look=DIM),
            box((-0.4, 0.05, -0.4), (0.5, 0.9, 0.3), look=glass),
            ball((-0.9, 0.5, -0.1), 0.4, 20, smooth=True, look=glass),
        ),
        points=(((0.3, 2.0, 1.5), (8e3, 8e3, 8e3)),),
        env=(0.3, 0.6, 0.9),
    )
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), depth=14, spp=24)
    image = ours(model.to_viscache(), replace(BARE, max_depth=12))
    assert_same(image, reference, SPECULAR_TOLERANCE)
    denser = replace(glass, eta=eta * 1.1)
    wrong = replace(
        model, parts=(model.parts[0], *(replace(p, look=denser) for p in model.parts[1:]))
    )
    image = ours(wrong.to_viscache(), replace(BARE, max_depth=12), seeds=4)
    assert not compare(image, reference, tolerance=SPECULAR_TOLERANCE).same


@pytest.mark.slow
def test_thin_plates_show_what_mitsuba_sees_through_and_in_them(mi: Any, tmp_path: Path) -> None:
    """Two plates behind each other, and a box of them, from both sides."""
    plate = Look(kind="dielectric", eta=1.7, thin=True)
    model = Model(
        (
            replace(FLOOR, look=DIM),
            quad((-1.5, 0, -0.6), (3, 0, 0.4), (0, 1.6, 0), look=plate),
            quad((-1.2, 0, 0.6), (1.8, 0, 0.3), (0, 1.2, 0.1), look=plate),
            box((0.3, 0.05, 0.1), (0.9, 0.7, 0.6), look=plate),
        ),
        points=(((0.3, 2.0, 1.5), (8e3, 8e3, 8e3)),),
        env=(0.3, 0.6, 0.9),
    )
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), depth=14, spp=24)
    image = ours(model.to_viscache(), replace(BARE, max_depth=12))
    assert_same(image, reference, SPECULAR_TOLERANCE)
    for other in (replace(plate, eta=2.0), replace(plate, thin=False)):
        wrong = tuple(replace(p, look=other) for p in model.parts[1:])
        changed = replace(model, parts=(model.parts[0], *wrong)).to_viscache()
        image = ours(changed, replace(BARE, max_depth=12), seeds=4)
        assert not compare(image, reference, tolerance=SPECULAR_TOLERANCE).same


def test_parts_are_what_they_say() -> None:
    """The helper's own fronts look outwards; else two-sidedness above would prove nothing."""
    for part in (box((0, 0, 0), (1, 1, 1)), ball((0.5, 0.5, 0.5), 0.5)):
        assert isinstance(part, Part)
        a, b, c = (part.vertices[part.triangles[:, i]] for i in range(3))
        outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3 - 0.5)
        assert (outwards > 0).all()
