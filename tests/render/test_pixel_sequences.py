"""The eye points of a pixel share the sequences of their samples and picks, over all passes."""

from functools import cache

import numpy as np
import pytest

import viscache as vc
from render.skies import gradient, with_sets
from render.test_sky_lobes import PLASTIC, shared
from render.test_sky_lobes import scene as lobes_on

SIZE = (40, 30)
#: Of frames whose samples are dear.
SMALL = (16, 12)
SPP = 8


def lamps():
    """The cube on its plane under 200 point lights."""
    description = vc.SceneDescription()
    grey = description.add_material(base_color=(0.6,) * 3)
    for mesh in vc.scenes.cube_on_plane().meshes():
        description.add_mesh(mesh["vertices"], mesh["triangles"], material=grey)
    places = np.random.Generator(np.random.PCG64(3)).random((200, 3)) * (6, 2, 6) + (-3, 2, -3)
    for place in places:
        description.add_point_light(place.tolist(), (0.1,) * 3)
    return vc.Scene.from_description(description)


@cache
def made(kind):
    """A scene, its camera, and an integrator with samples of each eye point's own."""
    if kind == "lobes":
        scene = lobes_on(PLASTIC)
        return scene, scene.cameras[0], shared(1)
    if kind == "area":
        scene = vc.scenes.cornell_box()
        return scene, scene.cameras[0], vc.Direct(n_area=4)
    scene = vc.scenes.cube_on_plane()
    camera = scene.cameras[0]
    sky = np.full((16, 32, 3), 0.2, np.float32)
    sky[3:5, 6:9] = 20
    none = {"n_area": 0, "n_brdf": 0, "n_environment": 4}
    lit, integrator = {
        "ambient": (scene, vc.AmbientOcclusion(n_samples=4, max_distance=None)),
        "sky": (sky, vc.Direct(n_area=0, n_environment=2, n_brdf=2)),
        "even sky": (1.0, vc.Direct(**none)),
        "product": (sky, vc.Direct(environment="product", passes=2, **none)),
        "sets": (gradient(), with_sets(128, SPP)),
        "picks": (lamps(), vc.Direct(pick=8)),
    }[kind]
    return lit if isinstance(lit, vc.Scene) else scene.with_environment(lit), camera, integrator


KINDS = ("ambient", "sky", "even sky", "product", "area", "picks")


def picture(kind, spp, seed, first_sample=0):
    scene, camera, integrator = made(kind)
    options = {"size": SMALL if kind == "product" else SIZE, "spp": spp, "camera": camera}
    frame = vc.render(scene, integrator, seed=seed, first_sample=first_sample, **options)
    return np.asarray(frame.image, np.float64)


def passes(kind, seed):
    """The mean of SPP frames of one sample that go on from each other."""
    return np.mean([picture(kind, 1, seed, first) for first in range(SPP)], axis=0)


@pytest.mark.parametrize("kind", [*KINDS, "sets", "lobes"])
def test_frames_that_go_on_have_the_samples_of_one_frame(kind):
    together, apart = picture(kind, SPP, 5), passes(kind, 5)
    np.testing.assert_allclose(apart, together, rtol=1e-5, atol=1e-6)
    assert np.abs(apart - passes(kind, 6)).max() > 0.01  # other samples would show


def test_where_maps_may_have_learnt_from_a_frame_the_next_one_is_independent_of_it():
    """Else what they learnt would tell something about samples that are still to come."""
    scene, camera, product = made("product")

    def frame(visibility, spp, first_sample=0):
        options = {"size": SIZE, "camera": camera, "spp": spp, "first_sample": first_sample}
        return vc.render(scene, product, visibility=visibility, **options).image

    for visibility, continues in ((vc.Exact(), True), (vc.VisMaps(), False)):
        apart = (frame(visibility, 1) + frame(visibility, 1, 1)) / 2
        away = np.abs(apart - frame(visibility, 2)).max()
        assert (away < 1e-5) == continues


@pytest.mark.parametrize("kind", KINDS)
def test_sequences_end_after_512_samples(kind):
    """Sample 512 is not the sequence's next one: it begins a sequence of its own."""
    first, next_one, other = (picture(kind, 1, 5, n) for n in (0, 511, 512))
    assert np.abs(other - first).max() > 0.01
    assert np.abs(other - next_one).max() > 0.01


def test_picks_of_a_pixel_are_spread_better_than_independent_ones():
    """Beside all lights at the same eye points."""
    scene, camera, _ = made("picks")

    def noise(spp, seed):
        options = {"size": SIZE, "spp": spp, "seed": seed, "camera": camera}
        return picture("picks", spp, seed) - vc.render(scene, vc.Direct(), **options).image

    together = noise(SPP, 5)
    independent = np.mean([noise(1, seed) for seed in range(SPP)], axis=0)
    assert 0 < np.mean(together**2) < 0.85 * np.mean(independent**2)


@pytest.mark.parametrize("kind", ["ambient", "sky", "even sky", "product"])
def test_samples_of_a_pixel_are_spread_better_than_independent_ones(kind):
    truth = np.mean([picture(kind, 64, 100 + i) for i in range(2)], axis=0)
    together = [np.mean((picture(kind, SPP, seed) - truth) ** 2) for seed in range(4)]
    independent = [
        np.mean(
            (np.mean([picture(kind, 1, 1000 * seed + k) for k in range(SPP)], axis=0) - truth) ** 2
        )
        for seed in range(4)
    ]
    assert np.mean(together) < 0.45 * np.mean(independent)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "product"])
def test_the_mean_over_seeds_is_that_of_independent_samples(kind):
    """Energies of 64 seeds each: within 4 standard errors, unless one is a tenth darker."""
    together = np.array([picture(kind, SPP, seed).mean() for seed in range(64)])
    alone = np.array([picture(kind, 1, 5000 + seed).mean() for seed in range(64)])

    def z(scale):
        error = np.sqrt(together.var(ddof=1) / 64 + alone.var(ddof=1) / 64)
        return float(abs(scale * together.mean() - alone.mean()) / error)

    assert z(1) < 4 < z(0.9)
