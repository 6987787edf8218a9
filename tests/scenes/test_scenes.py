"""The built-in scenes: deterministic, in budget, made of shape, seen from free space."""

from functools import cache

import numpy as np
import pytest

from viscache import scenes
from viscache.scene.coplanar import coplanar_share
from viscache.scenes.room import light_spots

SCALED = {
    "apartment": 750_000,
    "bumpy_spheres": 15_000,
    "church": 16_000,
    "classroom_like": 51_208,
    "conference": 280_000,
    "courtyard": 2_200_000,
    "garage": 350_000,
    "garden": 2_000_000,
    "hairball": 3_000_000,
    "mushrooms": 300_000,
    "random_triangles": 100_000,
    "room": 200_000,
}
EXACT = ("classroom_like", "random_triangles")
SMALL = {name: {"triangles": 30_000} if name in SCALED else {} for name in scenes.SCENES}


@cache
def built(name, triangles=0):
    make = scenes.SCENES[name].function
    return make(triangles=triangles) if triangles else make()


def small(name):
    return built(name, 30_000 if name in SCALED else 0)


def point_lights(scene):
    """Positions (N, 3) of the point lights."""
    found = [light["position"] for light in scene.lights if light["kind"] == "point"]
    return np.array(found).reshape(-1, 3)


def world(scene):
    """All placed triangles as one mesh."""
    meshes = scene.meshes()
    parts = [(m["vertices"].astype(float), m["triangles"].astype(np.int64)) for m in meshes]
    placed = [p for p, m in zip(parts, meshes, strict=True) if m["in_world"]]
    for i in scene.description().instances:
        t = np.array(i["to_world"])
        placed += [(parts[k][0] @ t[:3, :3].T + t[:3, 3], parts[k][1]) for k in i["meshes"]]
    starts = np.cumsum([0] + [len(v) for v, _ in placed[:-1]])
    faces = [f + s for (_, f), s in zip(placed, starts, strict=True)]
    return np.concatenate([v for v, _ in placed]), np.concatenate(faces)


def distances(points, scene):
    """Distance of each point to the nearest triangle."""
    vertices, faces = world(scene)
    triangles = vertices[faces]
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    out = []
    for p in points:
        gap = np.linalg.norm(np.maximum(np.maximum(low - p, p - high), 0), axis=1)
        out.append(min(_distance(p, triangles[gap < 0.3]), 0.3))
    return np.array(out)


def _distance(p, triangles):
    """Of a point to the nearest of some triangles (n, 3, 3)."""
    to = p - triangles
    edges = np.roll(triangles, -1, axis=1) - triangles
    s = np.clip((to * edges).sum(2) / np.maximum((edges**2).sum(2), 1e-30), 0, 1)
    to_edges = np.linalg.norm(to - s[..., None] * edges, axis=2).min(initial=np.inf)
    normal = np.cross(edges[:, 0], edges[:, 1])
    size = np.linalg.norm(normal, axis=1)
    inside = (np.einsum("nkc,nc->nk", np.cross(edges, to), normal) >= 0).all(1) & (size > 1e-12)
    to_planes = np.abs((to[inside, 0] * normal[inside]).sum(1)) / size[inside]
    return float(min(to_edges, to_planes.min(initial=np.inf)))


@pytest.mark.slow
@pytest.mark.parametrize("name", scenes.SCENES)
def test_two_builds_have_the_same_bytes(name):
    again = scenes.SCENES[name].function(**SMALL[name])
    assert again.content_hash == small(name).content_hash


@pytest.mark.parametrize("name", scenes.SCENES)
def test_meshes_are_finite_in_range_and_of_sane_size(name):
    scene = small(name)
    for m in scene.meshes():
        assert np.isfinite(m["vertices"]).all()
        assert m["triangles"].max() < len(m["vertices"])
        assert 0 <= m["material"] < len(scene.materials)
    vertices, _ = world(scene)
    extent = np.ptp(vertices, axis=0)
    assert (extent > 0.1).all()
    assert (extent < 40).all()


@pytest.mark.parametrize("name", scenes.SCENES)
def test_a_scene_has_cameras_and_lights(name):
    assert small(name).cameras
    assert small(name).lights


@pytest.mark.slow
@pytest.mark.parametrize("name", SCALED)
@pytest.mark.parametrize("triangles", [5_000, 61_003, 400_000])
def test_the_placed_count_is_within_the_budget(name, triangles):
    n = built(name, triangles).triangles
    assert triangles <= n <= (triangles if name in EXACT else 1.25 * triangles)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.slow if n in ("hairball", "garden") else ())
        for n in SCALED
    ],
)
def test_at_the_default_size_few_triangles_are_coplanar_with_a_neighbour(name):
    scene = built(name)
    assert SCALED[name] <= scene.triangles <= 1.25 * SCALED[name]
    meshes = scene.meshes()
    times = np.array([m["in_world"] for m in meshes], float)
    for i in scene.description().instances:
        times[i["meshes"]] += 1
    counts = np.array([len(m["triangles"]) for m in meshes])
    shares = np.array([coplanar_share(m["vertices"], m["triangles"]) for m in meshes])
    assert (times * counts * shares).sum() / (times * counts).sum() <= 0.2


@pytest.mark.parametrize("name", scenes.SCENES)
def test_cameras_stand_in_free_space_and_see_the_scene(name):
    origins = np.array([c.origin for c in small(name).cameras])
    assert (distances(origins, small(name)) > 0.12).all()


@pytest.mark.slow
def test_point_lights_are_five_centimetres_from_any_surface():
    for scene in (scenes.room(lights=60), built("apartment", 300_000)):
        assert distances(point_lights(scene), scene).min() >= 0.05


def test_the_apartment_has_24_lamps_and_the_room_24_lights_unless_told():
    assert len(point_lights(small("apartment"))) == 24
    assert len(point_lights(small("room"))) == 24
    assert len(point_lights(scenes.room(triangles=5000, lights=300))) == 300
    with_panels = scenes.room(triangles=5000, panels=True)
    assert len(point_lights(with_panels)) == 0
    assert any(np.any(m["emission"]) for m in with_panels.meshes())
    assert len(point_lights(scenes.room(triangles=5000, panels=True, lights=5))) == 5


def test_light_spots_do_not_move_when_more_are_asked_for():
    np.testing.assert_array_equal(light_spots(200)[:24], light_spots(24))


def test_the_room_is_the_size_of_the_measured_trial():
    vertices, _ = world(built("room"))
    np.testing.assert_allclose(vertices.min(axis=0), [-5, 0, -5], atol=0.03)
    np.testing.assert_allclose(vertices.max(axis=0), [5, 4, 5], atol=0.06)


def test_the_window_room_is_closed_but_for_one_square_metre():
    vertices, faces = world(built("window_room"))
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(2 * (8 * 8 + 8 * 4 + 8 * 4) - 1)
    np.testing.assert_array_equal(vertices.max(axis=0), [8, 8, 4])


def test_the_courtyards_leaves_are_instanced():
    scene = built("courtyard")
    assert sum(len(m["triangles"]) for m in scene.meshes()) < 0.2 * scene.triangles


def test_the_classroom_has_the_papers_triangles_and_lights():
    scene = built("classroom_like")
    assert scene.triangles == 51_208 and len(point_lights(scene)) == 4
    scraps = next((m for m in scene.meshes() if m["name"] == "paper"), None)
    assert scraps is None or len(scraps["triangles"]) < 0.03 * 51_208


def test_the_walk_through_the_classroom_is_smooth_and_meets_nothing():
    cameras = [scenes.classroom_camera(k) for k in range(420)]
    origins = np.array([c.origin for c in cameras])
    steps = np.linalg.norm(np.diff(origins, axis=0), axis=1)
    assert steps.min() > 0 and steps.max() < 0.1
    turns = np.einsum(
        "nk,nk->n", *(np.array([c.forward for c in part]) for part in (cameras[1:], cameras[:-1]))
    )
    assert turns.min() > np.cos(np.radians(3))
    assert (distances(origins[::7], built("classroom_like")) > 0.12).all()
    with pytest.raises(ValueError, match=r"frame must be in \[0, 420\), got 420"):
        scenes.classroom_camera(420)


def test_spheres_have_the_counts_of_table_1():
    for n in (5_800, 10_000, 11_000, 16_000, 34_000):
        assert n <= built("bumpy_spheres", n).triangles <= 1.02 * n


def test_an_edge_factor_keeps_random_triangles_as_dense_at_any_number():
    make = scenes.random_triangles
    for n in (1000, 8000):
        corners = make(triangles=n, edge_factor=1.5).meshes()[0]["vertices"]
        edge = np.linalg.norm(corners[1] - corners[0])
        assert edge == pytest.approx(1.5 * n ** (-1 / 3), rel=1e-4)
    with pytest.raises(ValueError, match="edge must be left out with edge_factor"):
        make(triangles=10, edge=0.1, edge_factor=1.0)
