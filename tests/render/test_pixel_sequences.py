"""The eye points of a pixel in a frame share the sequences of their light samples and picks."""

from typing import Any

import numpy as np
import pytest

import viscache as vc

SIZE = (40, 30)
SPP = 8


def lamps() -> vc.Scene:
    """The cube on its plane under 200 point lights."""
    description = vc.SceneDescription()
    grey = description.add_material(base_color=(0.6,) * 3)
    for mesh in vc.scenes.cube_on_plane().meshes():
        description.add_mesh(mesh["vertices"], mesh["triangles"], material=grey)
    places = np.random.Generator(np.random.PCG64(3)).random((200, 3)) * (6, 2, 6) + (-3, 2, -3)
    for place in places:
        description.add_point_light(place.tolist(), (0.1,) * 3)
    return vc.Scene.from_description(description)


def made(kind: str) -> tuple[vc.Scene, Any, Any]:
    """A scene, its camera, and an integrator with samples of each eye point's own."""
    scene = vc.scenes.cube_on_plane()
    camera = scene.cameras[0]
    sky = np.full((16, 32, 3), 0.2, np.float32)
    sky[3:5, 6:9] = 20
    return {
        "ambient": (scene, camera, vc.AmbientOcclusion(n_samples=4, max_distance=None)),
        "sky": (
            scene.with_environment(sky),
            camera,
            vc.Direct(n_area=0, n_environment=2, n_brdf=2),
        ),
        "even sky": (
            scene.with_environment(1.0),
            camera,
            vc.Direct(n_area=0, n_environment=4, n_brdf=0),
        ),
        "area": (vc.scenes.cornell_box(), vc.scenes.cornell_box().cameras[0], vc.Direct(n_area=4)),
        "picks": (lamps(), camera, vc.Direct(pick=8)),
    }[kind]


KINDS = ("ambient", "sky", "even sky", "area", "picks")


def picture(kind: str, spp: int, seed: int, first_sample: int = 0) -> Any:
    scene, camera, integrator = made(kind)
    frame = vc.render(
        scene, integrator, size=SIZE, spp=spp, seed=seed, first_sample=first_sample, camera=camera
    )
    return np.asarray(frame.image, np.float64)


def without_picks(spp: int, seed: int, first_sample: int) -> Any:
    """All lights at the eye points of `picture("picks", …)`."""
    scene, camera, _ = made("picks")
    frame = vc.render(
        scene,
        vc.Direct(),
        size=SIZE,
        spp=spp,
        seed=seed,
        first_sample=first_sample,
        camera=camera,
    )
    return np.asarray(frame.image, np.float64)


def test_picks_of_a_pixel_are_spread_better_than_those_of_passes() -> None:
    def error(spp: int) -> float:
        noise = np.zeros((*SIZE[::-1], 3))
        for first in range(0, SPP, spp):
            noise += picture("picks", spp, 5, first)
            noise -= without_picks(spp, 5, first)
        return float(np.mean((noise * spp / SPP) ** 2))

    assert 0 < error(SPP) < 0.85 * error(1)


@pytest.mark.parametrize("kind", ["ambient", "sky", "even sky"])
def test_samples_of_a_pixel_are_spread_better_than_independent_ones(kind: str) -> None:
    truth = np.mean([picture(kind, 256, 100 + i) for i in range(4)], axis=0)
    together = [np.mean((picture(kind, SPP, seed) - truth) ** 2) for seed in range(4)]
    independent = [
        np.mean(
            (np.mean([picture(kind, 1, 1000 * seed + k) for k in range(SPP)], axis=0) - truth) ** 2
        )
        for seed in range(4)
    ]
    assert np.mean(together) < 0.45 * np.mean(independent)


@pytest.mark.parametrize("kind", KINDS)
def test_the_mean_over_seeds_is_that_of_independent_samples(kind: str) -> None:
    """Energies of 64 seeds each: within 4 standard errors, unless one is a tenth darker."""
    together = np.array([picture(kind, SPP, seed).mean() for seed in range(64)])
    alone = np.array([picture(kind, 1, 5000 + seed).mean() for seed in range(64)])

    def z(scale: float) -> float:
        error = np.sqrt(together.var(ddof=1) / 64 + alone.var(ddof=1) / 64)
        return float(abs(scale * together.mean() - alone.mean()) / error)

    assert z(1) < 4 < z(0.9)
