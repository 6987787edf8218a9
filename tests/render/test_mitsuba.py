"""Exact frames against Mitsuba 3, an independent renderer: z-tests over seeds, each with its power.

Mitsuba renders with `path`: its `direct` counts a delta light `emitter_samples` times. max_depth 2
is direct light. Both sides use a box filter of one pixel.
"""

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import viscache as vc
from render.bdpt_scenes import LAMPS
from render.mitsuba_frames import SIZE, assert_same, ours, theirs
from render.mitsuba_scene import Look, Model, ball, box, quad, sensor
from render.ztest import ROUNDING, compare
from viscache import _core

pytestmark = [pytest.mark.mitsuba, pytest.mark.stat]


def test_the_cornell_box_has_mitsubas_direct_light(mi):
    path = Path(os.environ.get("VISCACHE_SCENES", "../shared/scenes")) / "cornell-box" / "scene.xml"
    if not path.exists():
        pytest.skip(f"there is no {path}")
    to_world = mi.ScalarTransform4f([[-1, 0, 0, 0], [0, 1, 0, 1], [0, 0, -1, 6.8], [0, 0, 0, 1]])
    view = mi.load_dict(sensor(to_world, SIZE, fov=19.5, fov_axis="x"))
    reference = theirs(mi, mi.load_file(str(path)), sensor=view, seeds=40)
    scene = vc.load_scene(path)
    assert_same(ours(scene, seeds=40), reference)
    # Its light turned around, as by a cosine with the wrong sign: it shines at the ceiling
    d, materials = vc.SceneDescription(), _core.scene_materials(scene._core)
    for mesh in scene.meshes():
        d.add_mesh(
            mesh["vertices"],
            mesh["triangles"][:, [2, 1, 0] if max(mesh["emission"]) > 0 else [0, 1, 2]],
            material=d.add_material(base_color=materials[mesh["material"]]["base_color"]),
            emission=mesh["emission"],
        )
    camera = scene.cameras[0]
    view = {"up": camera.up, "fov_deg": np.degrees(camera.fov_rad)}
    target = np.add(camera.origin, camera.forward)
    d.add_camera(camera.origin, target, horizontal=camera.fov_is_horizontal, **view)
    assert not compare(ours(vc.Scene.from_description(d), seeds=4), reference).same


GREY = Look(base_color=(0.6, 0.5, 0.4))
FLOOR = quad((-3, 0, -3), (0, 0, 6), (6, 0, 0), look=GREY)
BLOCK = box((-0.9, 0, -0.5), (-0.3, 0.9, 0.2), look=Look(base_color=(0.2, 0.5, 0.7)))
GLOBE = ball((0.6, 0.5, 0.2), 0.5, look=Look(base_color=(0.8, 0.3, 0.2)))
BODIES = (FLOOR, BLOCK, GLOBE)


def smooth_map(width=1024):
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


@dataclass(frozen=True)
class Case:
    """A model, integrators that give it Mitsuba's light, and models and integrators that do not."""

    model: Model
    wrong: tuple[Any, ...] = ()
    right: tuple[Any, ...] = (vc.Direct(),)
    theirs: dict[str, Any] = field(default_factory=dict)
    ours: dict[str, Any] = field(default_factory=dict)
    edge: int = 1
    tolerance: float = ROUNDING
    slow: bool = False


#: Of seeds, on both sides, where one percent of the light shows in single blocks and pixels.
FEW = {"seeds": 24}
BOTH = {"theirs": FEW, "ours": FEW}
POINTS = Model(
    BODIES,
    points=(
        ((1.5, 2.0, 1.5), (8, 6, 4)),
        ((-2, 2.5, 0.5), (2, 4, 9)),
        ((0, 1.2, 1.0), (0.5, 0.5, 0.5)),
    ),
    directions=(((0.48, 0.6, 0.64), (0.4, 0.5, 0.3)),),
)
FLIPPED = replace(GLOBE, look=replace(GLOBE.look, two_sided=False)).reversed()
SKY = Model(BODIES, env=(0.5, 0.8, 1.3))
#: The camera looks down: the map's texels, which we resample, are seen by their light alone.
MAP = replace(SKY, env=smooth_map(), origin=(0.5, 3.5, 2.0), target=(0, 0, 0), fov_deg=30)
#: Out of sight: seen directly, a tessellated silhouette differs.
SPHERES = Model(
    BODIES,
    spheres=(((0.5, 2.6, 0.5), 0.3, (9, 8, 7)), ((-2.6, 0.4, 1.8), 0.2, (3, 6, 9))),
    origin=(0.3, 1.6, 3.0),
    target=(0, 0.2, 0),
)
AREA = vc.Direct(n_area=32)


def metal(roughness):
    look = Look(kind="glossy", base_color=(0, 0, 0), roughness=roughness)
    parts = tuple(replace(part, look=look) for part in (FLOOR, GLOBE))
    return Model(parts, points=(((0.5, 2.5, 0.5), (4, 4, 4)),), env=(0.4, 0.5, 0.6))


#: Asymmetric: a swapped or turned axis shows.
PATTERN = np.random.default_rng(3).uniform(0.1, 0.9, (5, 7, 3)).astype(np.float32)


def textured(pattern):
    look = Look(base_color=(1, 0.8, 0.6), texture=np.ascontiguousarray(pattern))
    floor = replace(FLOOR, look=look)
    return Model((floor, BLOCK), points=(((0.5, 2.5, 1.5), (8, 8, 8)),))


def cards(two_sided):
    look = Look(base_color=(0.7, 0.6, 0.5), two_sided=two_sided)
    front = quad((-1.5, 0.2, 0), (1.2, 0, 0), (0, 1.2, 0), look=look)
    back = quad((0.3, 0.2, 0), (1.2, 0, 0), (0, 1.2, 0), look=look).reversed()
    return Model((FLOOR, front, back), points=(((0, 2.0, 2.0), (8, 8, 8)),), env=(0.2, 0.2, 0.2))


def bulb(rings, smooth):
    """Finely divided: a normal that looks away from the eye is bent by us, black in Mitsuba."""
    globe = ball((0, 0.7, 0), 0.7, rings, smooth=smooth, look=GREY)
    return Model((FLOOR, globe), points=(((1.5, 2.5, 2.5), (9, 9, 9)),), target=(0, 0.5, 0))


# Eye paths through mirrors and glass, without virtual lights. Albedos of 1/1000 leave little
# between diffuse surfaces for Mitsuba to find: 1/2000 is tolerated.
DIM = Look(base_color=(1e-3, 1e-3, 8e-4))
DARK = replace(FLOOR, look=DIM)
BARE = vc.Whitted(n_vpls=0, n_area=32)
MIRROR = Look(kind="mirror", specular=(0.9, 0.7, 0.5))
LIT = {"points": (((0.3, 2.0, 1.5), (8e3, 8e3, 8e3)),), "env": (0.3, 0.6, 0.9)}
MIRRORS = Model(
    (
        DARK,
        box((-1.2, 0, -0.2), (-0.5, 0.8, 0.4), look=DIM),
        quad((-1.5, 0, -0.8), (3, 0, 0.4), (0, 1.8, 0), look=MIRROR),
        quad((1.4, 0, 1.4), (0, 1.5, 0), (-0.3, 0, -2.0), look=MIRROR),
    ),
    points=(((0.3, 2.0, 1.0), (8e3, 8e3, 8e3)),),
    env=(0.3, 0.4, 0.5),
)


def glass(eta):
    look = Look(kind="dielectric", eta=eta)
    block = box((-0.4, 0.05, -0.4), (0.5, 0.9, 0.3), look=look)
    return Model((DARK, block, ball((-0.9, 0.5, -0.1), 0.4, 20, smooth=True, look=look)), **LIT)


def plates(eta=1.7, thin=True):
    """Two plates behind each other, and a box of them, from both sides."""
    look = Look(kind="dielectric", eta=eta, thin=thin)
    first = quad((-1.5, 0, -0.6), (3, 0, 0.4), (0, 1.6, 0), look=look)
    second = quad((-1.2, 0, 0.6), (1.8, 0, 0.3), (0, 1.2, 0.1), look=look)
    return Model((DARK, first, second, box((0.3, 0.05, 0.1), (0.9, 0.7, 0.6), look=look)), **LIT)


#: Depth of eye paths, ours and Mitsuba's.
SHORT = {"right": (replace(BARE, max_depth=4),), "theirs": {"depth": 6, "spp": 24}}
LONG = {"right": (replace(BARE, max_depth=12),), "theirs": {"depth": 14, "spp": 24}}
SHORT["tolerance"] = LONG["tolerance"] = 5e-4
#: The weakest light is dropped, or the sun; a part is black from outside, or absent.
FEWER = (replace(POINTS, points=POINTS.points[:2]), replace(POINTS, directions=()))
OTHERS = tuple(replace(POINTS, parts=(FLOOR, BLOCK, *more)) for more in ((FLIPPED,), ()))
SPLITS = tuple(vc.Direct(n_environment=e, n_brdf=b) for e, b in ((16, 16), (32, 0), (0, 32)))
TURNED = tuple(Model((*BODIES, *w)) for w in (LAMPS[:1], (LAMPS[0], LAMPS[1].reversed())))
ONE_SPHERE = replace(SPHERES, spheres=SPHERES.spheres[:1])
CASES = {
    "points and a sun": Case(POINTS, FEWER + OTHERS),
    "a constant sky by every split of samples": Case(
        SKY, (replace(SKY, parts=(FLOOR, GLOBE)),), SPLITS, theirs=FEW | {"spp": 24}, ours=FEW
    ),
    "a smooth map": Case(MAP, (replace(MAP, env=np.roll(smooth_map(), 128, axis=1)),), slow=True),
    "area lights of two colours and sizes": Case(Model((*BODIES, *LAMPS)), TURNED, (AREA,), edge=4),
    "sphere lights": Case(SPHERES, (ONE_SPHERE,), (AREA,), ours={"spp": 8}, edge=4, slow=True),
    **{
        f"rough conductors, {r}": Case(
            metal(r),
            (metal(1.2 * r),),
            SPLITS[:1],
            theirs=FEW,
            ours=FEW | {"spp": 8},
            slow=r == 0.5,
        )
        for r in (0.15, 0.5)
    },
    "a textured floor": Case(textured(PATTERN), (textured(PATTERN[::-1]),), **BOTH),
    "cards of two sides": Case(cards(True), **BOTH),
    "cards of one side": Case(cards(False), **BOTH),
    "interpolated normals": Case(bulb(40, True), (bulb(12, False),), **BOTH),
    "mirrors in mirrors": Case(MIRRORS, (replace(BARE, max_depth=1),), slow=True, **SHORT),
    "glass": Case(glass(1.5), (glass(1.65),), **LONG),
    "thinner glass": Case(glass(1 / 1.3), (glass(1.1 / 1.3),), slow=True, **LONG),
    "thin plates": Case(plates(), (plates(2.0), plates(thin=False)), slow=True, **LONG),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if c.slow else n for n, c in CASES.items()]
)
def test_frames_are_mitsubas_and_wrong_ones_are_told_apart(name, mi, tmp_path):
    case = CASES[name]
    reference = theirs(mi, case.model.to_mitsuba(mi, SIZE, tmp_path), **case.theirs)
    scene = case.model.to_viscache()
    for integrator in case.right:
        made = ours(scene, integrator, **case.ours)
        assert_same(made, reference, case.tolerance, edge=case.edge)
    for wrong in case.wrong:
        other = (wrong.to_viscache(), case.right[0]) if isinstance(wrong, Model) else (scene, wrong)
        made = ours(*other, seeds=4)
        assert not compare(made, reference, tolerance=case.tolerance).same


def test_parts_are_what_they_say():
    """The helper's own fronts look outwards; else two-sidedness above would prove nothing."""
    for part in (box((0, 0, 0), (1, 1, 1)), ball((0.5, 0.5, 0.5), 0.5)):
        a, b, c = (part.vertices[part.triangles[:, i]] for i in range(3))
        outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), (a + b + c) / 3 - 0.5)
        assert (outwards > 0).all()
