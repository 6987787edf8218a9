"""garden, mushrooms, dynamics: the sizes that the visibility-map paper gives, and what is seen."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import viscache as vc
from viscache import _core, scenes
from viscache.scenes.dynamics import EDGE, cubes
from viscache.scenes.garden import PETAL, height
from viscache.scenes.sky import sky

SIZES = {"garden": 100_000, "mushrooms": 60_000}


@cache
def scene(name):
    make = scenes.SCENES[name].function
    return make(triangles=SIZES[name]) if name in SIZES else make()


def boxes(name, *meshes):
    """Lowest and highest corners (K, 3) of the connected parts of meshes."""
    low, high = [], []
    for m in (m for m in scene(name).meshes() if m["name"] in meshes):
        a, b = m["triangles"].ravel(), np.roll(m["triangles"], 1, axis=1).ravel()
        graph = coo_matrix((np.ones(len(a), bool), (a, b)), shape=(len(m["vertices"]),) * 2)
        _, part = connected_components(graph, directed=False)
        vertices = m["vertices"][np.argsort(part, kind="stable")]
        first = np.flatnonzero(np.diff(np.sort(part), prepend=-1))
        low.append(np.minimum.reduceat(vertices, first))
        high.append(np.maximum.reduceat(vertices, first))
    return np.concatenate(low), np.concatenate(high)


def test_the_grass_is_3_8_units_high():
    low, high = boxes("garden", "grass", "light grass")
    assert len(low) > 1500
    tall = (high - low)[:, 1]
    assert tall.mean() == pytest.approx(3.8, rel=0.02)
    assert tall.min() > 2.2 and tall.max() < 5.5
    middle = (low + high) / 2
    assert abs(low[:, 1] - height(middle[:, 0], middle[:, 2])).max() < 0.4  # rooted in the ground


def test_tulips_are_0_8_units_wide_and_look_out_of_the_grass():
    vertices, _ = PETAL.mesh(6.0)
    assert 2 * np.hypot(vertices[:, 0], vertices[:, 2]).max() == pytest.approx(0.8, rel=0.01)
    low, high = boxes("garden", *(f"tulips {k}" for k in range(4)))
    assert len(low) == 6 * 25
    assert (high - low)[:, 1].mean() == pytest.approx(1.0, rel=0.05)
    assert np.median(high[:, 1]) > 3.8


def test_mushrooms_are_1_3_units_high_and_wide():
    from viscache.scenes.mushrooms import height as ground

    low, high = boxes("mushrooms", "red caps", "brown caps")
    assert len(low) == 44
    assert (high - low)[:, [0, 2]].mean() == pytest.approx(1.3, rel=0.05)
    middle = (low + high) / 2
    tall = high[:, 1] - ground(middle[:, 0], middle[:, 2])
    assert tall.mean() == pytest.approx(1.3, rel=0.05)
    assert tall.min() > 0.8 and tall.max() < 1.8


def test_cubes_have_edges_of_5_units_and_are_all_coplanar():
    """Flat faces are what the scene is for: the limit on coplanar triangles is not for it."""
    meshes = {m["name"]: m for m in scene("dynamics").meshes()}
    corners = np.concatenate(
        [m["vertices"].reshape(-1, 8, 3) for name, m in meshes.items() if "cubes" in name]
    ).astype(float)
    assert len(corners) == len(cubes()) == 9
    for c in corners:
        gaps = np.linalg.norm(c[:, None] - c[None], axis=2)
        np.testing.assert_allclose(np.sort(gaps, 1)[:, 1:4], 5.0, rtol=1e-6)
    assert corners[..., 1].min() > -1e-6
    assert scene("dynamics").coplanar_share == 1.0


def test_cubes_touch_but_do_not_overlap():
    """Two boxes are apart if they are along a face normal of one or a product of two edges."""
    for a, b in combinations(cubes(), 2):
        edges = [*a[:3, :3].T, *b[:3, :3].T]
        axes = edges + [np.cross(p, q) for p in edges[:3] for q in edges[3:]]
        units = [x / np.linalg.norm(x) for x in axes if np.linalg.norm(x) > 1e-9]
        reach = [
            sum(EDGE / 2 * abs(c[:3, :3].T @ u).sum() for c in (a, b))
            - abs((a[:3, 3] - b[:3, 3]) @ u)
            for u in units
        ]
        assert min(reach) < 1e-9


CAMERAS = {"garden": ["garden1", "garden2"], "mushrooms": ["camera"], "dynamics": ["camera"]}


@pytest.mark.parametrize(("name", "cameras"), CAMERAS.items())
def test_cameras_see_much_of_the_scene(name, cameras):
    opened = scene(name)
    assert [c.name for c in opened.cameras] == cameras
    ends = np.cumsum([len(m["triangles"]) for m in opened.meshes()])
    for view in opened.cameras:
        found = vc.correlation.surface_points(opened, 2000, camera=view)
        assert found.n_misses < 0.5 * found.width * found.height, "half the picture shows surfaces"
        from_camera = found.positions - np.array(view.origin)
        hit = opened.intersect(np.broadcast_to(np.array(view.origin), (2000, 3)), from_camera)
        share = np.bincount(np.searchsorted(ends, hit.triangle, side="right"), minlength=len(ends))
        assert (share > 20).sum() >= 3, "at least three kinds of things"
        distance = np.linalg.norm(from_camera, axis=1)
        assert np.quantile(distance, 0.9) > 1.5 * np.quantile(distance, 0.1)


@pytest.mark.parametrize("name", CAMERAS)
def test_the_sky_is_their_light(name):
    opened = scene(name)
    assert [light["kind"] for light in opened.lights] == ["environment"]
    frame = vc.render(opened, vc.Direct(n_environment=4), size=(48, 36))
    assert frame.image.mean() > 0.05 and frame.warnings == []


def test_the_suns_glow_is_where_it_was_put_and_gives_about_half_the_light():
    sun = np.array([0.5, 0.62, 0.6])
    pixels = sky((0.5, 0.62, 0.6))
    env = _core.sampling.EnvironmentMap.from_latlong(pixels)
    d = np.random.default_rng(0).normal(size=(200_000, 3)).astype(np.float32)
    d /= np.linalg.norm(d, axis=1)[:, None]
    light = env.eval(d).mean(1)
    brightest = d[light > 0.9 * light.max()].mean(0)
    assert brightest @ sun / np.linalg.norm(brightest) / np.linalg.norm(sun) > np.cos(0.02)
    near = d @ sun / np.linalg.norm(sun) > np.cos(np.radians(15))
    assert 0.4 < light[near].sum() / light.sum() < 0.6
    assert light[d[:, 1] < -0.1].max() < light[(d[:, 1] > 0.1) & ~near].min()
