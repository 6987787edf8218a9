"""The pictures that peers render too: what is handed over, and our own frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.experiment.amounts import build_scene

Array = npt.NDArray[Any]

#: Of every surface, in all pictures.
ALBEDO = 0.6
INTENSITY = 4.0
#: Of the quantized cache, where lights are many.
C_E = 8
#: Directions that all eye points share: of a sky, and around both sides of a surface.
SKY_DIRECTIONS, SPHERE_DIRECTIONS = 256, 513
#: Directions of the sky in sets, which the eye points of a pixel ask in turns; the time that this
#: saves goes into more eye points, one for each set.
DEALT_DIRECTIONS, SETS = 512, 16


@dataclass(frozen=True, kw_only=True, slots=True)
class Way:
    """Another way of ours to make the same picture; it takes turns with the others.

    If biased, its error is told beside our exact frame of the same seed. Otherwise its figure is
    the time to equal error.
    """

    label: str
    render: Callable[[int, int], vc.Frame]
    biased: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class PictureCase:
    """One square picture of grey surfaces, at equal samples on both sides."""

    name: str
    scene: vc.Scene
    render: Callable[[int, int], vc.Frame]  # of a number of samples per pixel and a seed
    job: dict[str, Any]  # the peers', without `spp` and `seed`
    arrays: dict[str, Array]  # given to the peers before the job
    spp: int
    reference_spp: int
    peer_reference_spp: int | None = None  # as many as of ours by default
    ways: tuple[Way, ...] = ()
    without: Mapping[str, str] = field(default_factory=dict)  # peers left out, and why


def picture_cases(quick: bool = False) -> list[PictureCase]:
    """Ambient occlusion, many lights in two sizes, a sky over five scenes, a room with a window."""
    triangles = 5_000 if quick else 200_000
    side = 32 if quick else 256
    room, camera = _grey(f"room?triangles={triangles}")
    sky = _sky()
    grown = 5_000 if quick else 100_000
    under = {
        "bumpy spheres": "bumpy_spheres",
        "stairs": "stairs",
        "dynamics": "dynamics",
        "mushrooms": f"mushrooms?triangles={grown}",
        "hairball": f"hairball?triangles={grown}",
    }
    open_air = ("bumpy spheres", "dynamics", "mushrooms")
    window = vc.Scene.from_arrays(_window_room(), base_color=(ALBEDO,) * 3, env=sky)
    return [
        _ambient(room, camera, side),
        *(_open_ambient(*_grey(under[name]), side, name) for name in open_air),
        _lights(room, camera, side if quick else side // 2, quick),
        _many_lights(room, camera, 2 * side, quick),
        *(
            _lit_by(sky, *_grey(spec, env=sky), side, quick, f"environment, {name}")
            for name, spec in under.items()
        ),
        _lit_by(sky, window, _window_camera(), side, quick, "environment, room with a window"),
    ]


def _grey(spec: str, env: Array | None = None) -> tuple[vc.Scene, vc.Camera]:
    """The triangles of a built-in scene as one grey mesh, and its camera."""
    scene = build_scene(spec)
    meshes = [
        (np.asarray(m["vertices"]), np.asarray(m["triangles"]))
        for m in scene.meshes()
        if m["in_world"]
    ]
    return vc.Scene.from_arrays(meshes, base_color=(ALBEDO,) * 3, env=env), scene.cameras[0]


def _ambient(room: vc.Scene, camera: vc.Camera, side: int) -> PictureCase:
    samples, reach = 16, 0.1 * float(np.linalg.norm(np.diff(room.bounds, axis=0)))
    light = vc.AmbientOcclusion(n_samples=samples, max_distance=reach)
    return _case(
        f"AO room {side}x{side}, {samples} rays",
        _shot(room, light, camera, side),
        {"job": "ao", "samples": samples, "reach": reach},
        spp=4,
        reference_spp=64,
    )


def _open_ambient(scene: vc.Scene, camera: vc.Camera, side: int, name: str) -> PictureCase:
    """Rays without end, as many per eye point as shared directions lie on its side."""
    samples = SPHERE_DIRECTIONS // 2
    own = vc.AmbientOcclusion(n_samples=samples, max_distance=None)
    shot = _shot(scene, own, camera, side)
    shared = shot.with_(integrator=replace(own, n_samples=SPHERE_DIRECTIONS, directions="shared"))
    return _case(
        f"AO {name} {side}x{side}, {samples} rays",
        shot,
        {"job": "ao", "samples": samples, "reach": np.inf},
        spp=4,
        reference_spp=32,
        ways=(Way(label="shared directions", render=_frames(shared)),),
    )


def _lights(room: vc.Scene, camera: vc.Camera, side: int, quick: bool) -> PictureCase:
    count = 20 if quick else 500
    rng = np.random.Generator(np.random.PCG64(5))
    low, high = np.asarray(room.bounds, np.float64)
    # Under the ceiling, away from the walls
    share = rng.random((count, 3)) * (0.8, 0.15, 0.8) + (0.1, 0.8, 0.1)
    positions = (low + share * (high - low)).astype(np.float32)
    description = vc.SceneDescription()
    grey = description.add_material(base_color=(ALBEDO,) * 3)
    for mesh in room.meshes():
        description.add_mesh(mesh["vertices"], mesh["triangles"], material=grey)
    for position in positions:
        description.add_point_light(position.tolist(), (INTENSITY / count,) * 3)
    shot = _shot(vc.Scene.from_description(description), vc.Direct(), camera, side)
    cached = _frames(shot.with_(visibility=vc.Aqvc(c_e=C_E)))
    return _case(
        f"{count} point lights, room {side}x{side}",
        shot,
        {"job": "points", "albedo": ALBEDO, "intensity": INTENSITY / count},
        {"lights": positions},
        spp=1,
        # Errors are far below that of one sample of ours where many eye points share the lights
        reference_spp=64 if quick else 256,
        peer_reference_spp=64 if quick else 16,
        ways=(Way(label=f"Aqvc(c_e={C_E})", render=cached, biased=True),),
    )


def _many_lights(room: vc.Scene, camera: vc.Camera, side: int, quick: bool) -> PictureCase:
    """The same in a larger picture, where eye points are dense."""
    case = _lights(room, camera, side, quick)
    if quick:
        return case
    # Sixteen times the pixels: fewer samples of each
    without = dict.fromkeys(("luxcore", "luxcore-cache"), "an estimated hour and more")
    return replace(case, reference_spp=16, peer_reference_spp=4, without=without)


def _lit_by(
    sky: Array, scene: vc.Scene, camera: vc.Camera, side: int, quick: bool, name: str
) -> PictureCase:
    samples = spp = 4
    own = vc.Direct(n_area=0, n_environment=samples, n_brdf=samples)
    shared = vc.Direct(n_area=0, n_environment=SKY_DIRECTIONS, environment="shared")
    dealt = replace(shared, n_environment=DEALT_DIRECTIONS, interleave=SETS)
    shot = _shot(scene, own, camera, side)
    by_sets = _frames(shot.with_(integrator=dealt), SETS // spp)
    return _case(
        f"{name} {side}x{side}, {samples} + {samples} samples",
        shot,
        {"job": "sky", "samples": samples, "albedo": ALBEDO},
        {"sky": sky},
        spp=spp,
        # Below the errors of all ways
        reference_spp=1024 if quick else 512,
        peer_reference_spp=1024 if quick else 256,
        ways=(
            Way(
                label=f"{SKY_DIRECTIONS} shared directions",
                render=_frames(shot.with_(integrator=shared)),
            ),
            Way(label=f"{DEALT_DIRECTIONS} shared directions in {SETS} sets", render=by_sets),
        ),
    )


def _shot(scene: vc.Scene, light: Any, camera: vc.Camera, side: int) -> vc.Shot:
    return vc.Shot(scene, light, size=(side, side), camera=camera)


def _frames(shot: vc.Shot, times: int = 1) -> Callable[[int, int], vc.Frame]:
    """Its frames of a number of samples, or so many times more, and a seed."""
    return lambda spp, seed: shot.with_(spp=times * spp, seed=seed).render()


def _case(
    name: str,
    shot: vc.Shot,
    job: dict[str, Any],
    arrays: Mapping[str, Array] = MappingProxyType({}),
    **more: Any,
) -> PictureCase:
    """What peers get: the job with the camera, and the arrays."""
    camera: Any = shot.camera
    size: Any = shot.size
    axes = np.array([camera.origin, camera.forward, camera.right, camera.up], np.float64)
    view = {"side": size[0], "fov_rad": float(camera.fov_rad)}
    return PictureCase(
        name=name,
        scene=shot.opened,
        render=_frames(shot),
        job=job | view,
        arrays={"camera": axes, **arrays},
        **more,
    )


def _sky() -> Array:
    """(64, 128, 3) grey radiance: brighter to one side and upwards, with one bright patch."""
    row, column = np.mgrid[0:64, 0:128] / np.array([64, 128]).reshape(2, 1, 1)
    value = 0.3 + 0.5 * (1 - row) + 0.4 * column
    value[20:24, 40:46] = 40.0
    return np.repeat(value[..., None], 3, axis=2).astype(np.float32)


def _window_room() -> list[tuple[Array, Array]]:
    """A room of 6 x 3 x 6 with a window of 1.6 x 1.2 in the wall at z = -3, and three boxes."""
    inside = _box((-3, 0, -3), (3, 3, 3))
    # The last face of a box is that at the lowest z: four strips around the window take its place
    strips = (((-3, 0), (3, 1)), ((-3, 2.2), (3, 3)), ((-3, 1), (-0.8, 2.2)), ((0.8, 1), (3, 2.2)))
    meshes = [(inside[0], inside[1][:-2])]
    for (x0, y0), (x1, y1) in strips:
        corners = np.array([(x0, y0, -3), (x1, y0, -3), (x1, y1, -3), (x0, y1, -3)], np.float32)
        meshes.append((corners, np.array([(0, 1, 2), (0, 2, 3)])))
    boxes = (
        ((-2, 0, -1), (-1, 1.4, 0)),
        ((0.5, 0, -0.5), (1.8, 0.7, 1)),
        ((-0.4, 0, 0.6), (0.1, 1.8, 1)),
    )
    return meshes + [_box(low, high) for low, high in boxes]


def _box(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[Array, Array]:
    """Twelve triangles; the last two have the lowest z."""
    corners = np.array(
        [[(low, high)[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)], np.float32
    )
    faces = ((0, 2, 6, 4), (1, 3, 7, 5), (0, 1, 5, 4), (2, 3, 7, 6), (4, 5, 7, 6), (0, 1, 3, 2))
    return corners, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def _window_camera() -> vc.Camera:
    description = vc.SceneDescription()
    description.add_mesh(*_box((0, 0, 0), (1, 1, 1)))
    description.add_camera((2.4, 1.7, 2.6), (-0.6, 1.0, -1.5), fov_deg=60, width=64, height=64)
    return vc.Scene.from_description(description).cameras[0]
