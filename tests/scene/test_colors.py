"""Colours of vertices and faces: in shading, in holes, in hashes and in memory."""

import pickle

import numpy as np
import pytest
import trimesh

import viscache as vc
from viscache import _core
from vlf.aligned_scenes import batch, embree, frames_of

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
QUAD = np.array([[0, 1, 2], [0, 2, 3]])
#: Largest error of a linear value in a byte of sRGB.
STEP = 0.0045


def linear(encoded):
    """IEC 61966-2-1."""
    c = np.asarray(encoded, float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def kept(colors):
    """What a scene keeps of colours of as many vertices."""
    n = len(np.asarray(colors))
    d = vc.SceneDescription()
    d.add_mesh(np.zeros((n, 3)), np.zeros((1, 3), np.uint32), colors=colors)
    return d.mesh_arrays(0)["colors"]


def test_bytes_stay_and_linear_values_are_off_by_half_a_step_of_srgb():
    bytes_ = np.arange(256, dtype=np.uint8)[:, None].repeat(4, 1)
    expected = np.column_stack([linear(bytes_[:, :3] / 255), bytes_[:, 3] / 255])
    np.testing.assert_allclose(kept(bytes_), expected, rtol=1e-5)
    np.testing.assert_array_equal(kept(kept(bytes_)), kept(bytes_))
    many = np.linspace(0, 1, 20_001)[:, None].repeat(4, 1)
    error = np.abs(kept(many) - many)
    assert error[:, 3].max() <= 1 / 510 + 1e-6
    assert 0.0044 < error[:, :3].max() <= STEP
    # Dark colours are closer than in bytes of linear values
    assert error[many[:, 0] <= 0.01, :3].max() < 3.5e-4


def test_a_vertex_takes_four_bytes_and_a_mesh_without_colors_none():
    vertices = np.random.default_rng(1).random((300, 3))
    triangles = np.arange(300).reshape(-1, 3)

    def memory(**more):
        bytes_ = vc.Scene.from_arrays(vertices, triangles, **more).info()["memory_bytes"]
        return bytes_

    assert memory(colors=np.ones((300, 3))) - memory() == 4 * 300
    assert vc.Scene.from_arrays(vertices, triangles).meshes()[0]["colors"].shape == (0, 4)


def test_vertices_of_faces_with_other_colors_become_several():
    faces = np.uint8([[255, 0, 0, 255], [0, 255, 0, 128]])
    (mesh,) = vc.Scene.from_arrays(CORNERS, QUAD, normals=CORNERS, colors=faces).meshes()
    assert len(mesh["vertices"]) == 6
    np.testing.assert_array_equal(mesh["vertices"][mesh["triangles"]], CORNERS[QUAD])
    np.testing.assert_array_equal(mesh["normals"][mesh["triangles"]], CORNERS[QUAD].astype("f4"))
    shown = mesh["colors"][mesh["triangles"]]
    np.testing.assert_allclose(shown, (faces[:, None] / 255).repeat(3, 1), atol=1e-6)
    (same,) = vc.Scene.from_arrays(CORNERS, QUAD, colors=faces[[0, 0]]).meshes()
    assert len(same["vertices"]) == 4


def seen_from_above(scene, size=16, **more):
    camera = vc.orthographic((0.5, 0.5, 2), (0.5, 0.5, 0), up=(0, 1, 0), height=1)
    return vc.render(scene, **({"integrator": "direct"} | more), camera=camera, size=(size, size))


def test_the_albedo_is_interpolated_in_linear_light():
    colors = np.array([[1, 0, 0.2], [0, 1, 0.2], [0, 0, 0.9], [0.5, 0.5, 0]])
    base = np.array([0.8, 0.5, 0.25])
    scene = vc.Scene.from_arrays(CORNERS, QUAD, colors=colors, base_color=base, env=1.0)
    albedo = seen_from_above(scene, spp=64).layers["albedo"]
    middles = (np.arange(16) + 0.5) / 16
    x, y = np.meshgrid(middles, 1 - middles)
    # Barycentric coordinates of all four corners, below and above the diagonal
    weights = np.where(y < x, [1 - x, x - y, y, 0 * x], [1 - y, 0 * x, x, y - x])
    expected = base * np.einsum("khw,kc->hwc", weights, colors)
    # The mean of a pixel, up to its samples; across the diagonal there is a kink
    clear = np.abs(x - y) > 0.01
    np.testing.assert_allclose(albedo[clear], expected[clear], atol=STEP + 0.002)


def room(colored, kind):
    """A corner lit by a lamp: a colour of all vertices, or the same as the base colour."""
    bytes_ = np.uint8([200, 120, 40])
    color = kept(np.tile(bytes_, (3, 1)))[0, :3]
    d = vc.SceneDescription()
    base = {} if colored else {"base_color": color.tolist()}
    look = d.add_material(**(kind | ({"base_color": (1, 1, 1)} | base)))
    for wall in (CORNERS, CORNERS[:, [2, 0, 1]], CORNERS[:, [1, 2, 0]]):
        given = {"colors": np.tile(bytes_, (4, 1))} if colored else {}
        d.add_mesh(wall * 2 - 1, QUAD, material=look, **given)
    d.add_point_light((0.7, 0.6, 0.8), (3, 3, 3))
    d.add_camera((3, 3, 3), (0, 0, 0), width=24, height=24)
    return vc.Scene.from_description(d)


KINDS = {
    "diffuse": {},
    "glossy": {"kind": _core.MaterialKind.GLOSSY, "roughness": 0.3},
    "half metal": {"kind": _core.MaterialKind.GLOSSY, "roughness": 0.3, "metallic": 0.5},
    "plastic": {"kind": _core.MaterialKind.GLOSSY, "coat": _core.CoatKind.SMOOTH},
}


@pytest.mark.parametrize("integrator", ["direct", "whitted?n_vpls=100", "bdpt"])
@pytest.mark.parametrize("kind", KINDS)
def test_one_color_all_over_is_the_base_color_in_every_integrator(kind, integrator):
    colored, plain = (room(colored, KINDS[kind]) for colored in (True, False))
    a, b = (vc.render(scene, integrator, spp=1, seed=3) for scene in (colored, plain))
    assert set(a.layers) == set(b.layers) and a.image.mean() > 0.01
    for name, layer in a.layers.items():
        np.testing.assert_array_equal(layer, b.layers[name], err_msg=name)
    assert colored.content_hash != plain.content_hash
    assert colored.geometry_hash == plain.geometry_hash


N = 4000
LAMPS = np.float32([[0.3, 0.4, -1], [0.6, 0.5, -2], [0.5, 0.5, -1.5]])


def veil(cutoff, **more):
    """A plate that gets solid from left to right: its alpha is its x."""
    d = vc.SceneDescription()
    colors = np.ones((4, 4))
    colors[:, 3] = CORNERS[:, 0]
    look = d.add_material(alpha_cutoff=cutoff, **more)
    d.add_mesh(CORNERS, QUAD, material=look, colors=colors)
    return vc.Scene.from_description(d)


def rays():
    """Points above the plate, each lamp under it, and where x of the plate lies between them."""
    x = np.random.default_rng(2).random((N, 3)).astype(np.float32) * np.float32([1, 1, 0.5]) + [
        0,
        0,
        0.5,
    ]
    share = x[:, None, 2] / (x[:, None, 2] - LAMPS[None, :, 2])
    at = x[:, None] + (LAMPS[None] - x[:, None]) * share[..., None]
    return x.astype(np.float32), LAMPS, at


def by_rays(given):
    def stopped(scene):
        x, y, _ = rays()
        pairs = np.broadcast_arrays(x[:, None], y[None])
        nearest = np.isfinite(scene.intersect(pairs[0], pairs[1] - pairs[0], rays=given).t)
        seen = scene.visible(*pairs, rays=given)
        np.testing.assert_array_equal(seen, ~nearest)
        return ~seen

    return stopped


def by_matrix(engine):
    def stopped(scene):
        x, y, _ = rays()
        bits = scene.visible_matrix(x, y, engine=engine)
        return (bits >> np.arange(len(y), dtype=np.uint64)) & np.uint64(1) == 0

    return stopped


CASTERS = {
    "embree": by_rays(vc.Embree()),
    "embree, fast": by_rays(vc.Embree(robust=False)),
    "watertight": by_rays(vc.Embree(watertight=True)),
    "bsp": by_rays(vc.Bsp()),
    "bsp, wald": by_rays(vc.Bsp(kernel="wald")),
    "field": by_rays(vc.Vlf(n_directions=513)),
    "field, wald": by_rays(vc.Vlf(n_directions=513, kernel="wald")),
    "packets": by_matrix("packets"),
    "shafts": by_matrix("shafts"),
}


@pytest.mark.parametrize("caster", CASTERS)
def test_alpha_of_vertices_cuts_holes_for_every_caster(caster):
    _, _, at = rays()
    inside = (at[..., :2] > 0.002).all(-1) & (at[..., :2] < 0.998).all(-1)
    assert inside.mean() > 0.5
    clear = inside & (np.abs(at[..., 0] - 0.4) > 0.005)
    stopped = CASTERS[caster](veil(0.4))
    np.testing.assert_array_equal(stopped[clear], at[clear][:, 0] > 0.4)
    # A share of the surface, times that of the material
    for opacity in (1.0, 0.5):
        shares = CASTERS[caster](veil(-1, opacity=opacity))
        for low in (0.1, 0.4, 0.7):
            there = inside & (at[..., 0] > low) & (at[..., 0] < low + 0.1)
            expected, n = opacity * (low + 0.05), np.count_nonzero(there)
            sigma = np.sqrt(expected * (1 - expected) / n)
            assert abs(shares[there].mean() - expected) < 4 * sigma + 0.01
    exact = CASTERS["embree"](veil(-1))
    assert np.mean(CASTERS[caster](veil(-1)) != exact) < 0.003


def test_the_aligned_batch_sees_the_same_holes():
    random = np.random.default_rng(3)
    d = vc.SceneDescription()
    vertices = random.uniform(-1, 1, (300, 1, 3)) + random.normal(0, 0.2, (300, 3, 3))
    colors = np.ones((900, 4))
    colors[:, 3] = random.random(900)
    triangles = np.arange(900).reshape(-1, 3)
    d.add_mesh(vertices.reshape(-1, 3), triangles, colors=colors)
    scene, frames = vc.Scene.from_description(d), frames_of(513)
    points = random.uniform(-1, 1, (2000, 3)).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (2000, 1))
    ours, theirs = batch(scene, points, normals, frames), embree(scene, points, normals, frames)
    assert np.mean(ours != theirs) < 1e-4
    solid = vc.Scene.from_arrays(vertices.reshape(-1, 3), triangles)
    assert np.mean(batch(solid, points, normals, frames) != ours) > 0.1


def test_alpha_of_vertices_multiplies_that_of_an_image():
    d = vc.SceneDescription()
    greys = d.add_image(np.float32([[[0.5]]]))
    look = d.add_material(alpha_texture=greys, alpha_cutoff=0.3)
    colors = np.ones((4, 4))
    colors[:, 3] = CORNERS[:, 0]
    d.add_mesh(CORNERS, QUAD, material=look, uvs=CORNERS[:, :2], colors=colors)
    scene = vc.Scene.from_description(d)
    at = np.array([[0.3, 0.5, 1], [0.55, 0.4, 1], [0.65, 0.4, 1], [0.9, 0.5, 1]])
    assert scene.visible(at, at * [1, 1, -1]).tolist() == [True, True, False, False]


def test_equal_corners_are_their_value_everywhere():
    """No point of an even triangle falls below a cut-off at its own alpha."""
    d = vc.SceneDescription()
    colors = np.full((4, 4), 51, np.uint8)
    d.add_mesh(CORNERS, QUAD, material=d.add_material(alpha_cutoff=0.2), colors=colors)
    at = np.random.default_rng(1).random((20_000, 3)) * [1, 1, 0] + [0, 0, 1]
    assert not vc.Scene.from_description(d).visible(at, at * [1, 1, -1]).any()


def test_a_color_changes_the_hash_and_alpha_that_of_the_geometry():
    white = np.full((4, 4), 255, np.uint8)
    red, clear = white.copy(), white.copy()
    red[2] = [255, 0, 0, 255]
    clear[2] = [255, 255, 255, 0]
    scenes = [vc.Scene.from_arrays(CORNERS, QUAD, colors=c) for c in (white, red, clear)]
    assert len({s.content_hash for s in scenes}) == 3
    assert [s.geometry_hash == scenes[0].geometry_hash for s in scenes] == [True, True, False]


def test_colors_travel_with_a_scene():
    scene = vc.Scene.from_arrays(CORNERS, QUAD, colors=np.random.default_rng(1).random((4, 4)))
    back = pickle.loads(pickle.dumps(scene))
    assert back.content_hash == scene.content_hash
    np.testing.assert_array_equal(back.meshes()[0]["colors"], scene.meshes()[0]["colors"])
    again = vc.Scene.from_description(scene.description())
    assert again.content_hash == scene.content_hash


WRONG = {
    "rows": (np.ones((3, 3)), r"colors must have shape \(4, 3 or 4\), for vertices, or \(2, 3 or"),
    "columns": (np.ones((4, 2)), r"colors must have shape \(4, 3 or 4\).*got \(4, 2\)"),
    "too bright": (np.full((4, 3), 1.5), r"colors must be in \[0, 1\].*got 1.5.* in row 0"),
    "negative": (-np.ones((4, 3)), r"colors must be in \[0, 1\]"),
    "nan": (np.full((4, 3), np.nan), r"colors must be in \[0, 1\].*got nan"),
    "integers": (np.full((4, 3), 255), "floats in .* or bytes of dtype uint8, got .*int64"),
    "words": ([["a", "b", "c"]] * 4, "colors must be real numbers"),
    "complex": (np.ones((4, 3)) * 1j, "colors must be real numbers"),
}


@pytest.mark.parametrize("case", WRONG)
def test_colors_that_are_none_are_refused(case):
    given, says = WRONG[case]
    with pytest.raises(ValueError, match=says):
        vc.Scene.from_arrays(CORNERS, QUAD, colors=given)


def test_descriptions_refuse_colors_that_are_none():
    d = vc.SceneDescription()
    with pytest.raises(
        ValueError, match=r"face_colors must have shape \(2, 3 or 4\), got \(4, 3\)"
    ):
        d.add_mesh(CORNERS, QUAD, face_colors=np.ones((4, 3)))
    with pytest.raises(ValueError, match="colors and face_colors exclude each other"):
        d.add_mesh(CORNERS, QUAD, colors=np.ones((4, 3)), face_colors=np.ones((2, 3)))
    with pytest.raises(vc.SceneError, match="triangle 1 names vertex 9, but there are 4 vertices"):
        d.add_mesh(CORNERS, [[0, 1, 2], [0, 2, 9]], face_colors=np.uint8([[1, 1, 1], [2, 2, 2]]))


def test_each_mesh_of_a_list_has_its_own_colors():
    colors = np.uint8([[255, 0, 0]] * 4)
    scene = vc.Scene.from_arrays(
        [(CORNERS, QUAD, None, colors), (CORNERS, QUAD), (CORNERS, QUAD, (0.5, 1, 1), colors)]
    )
    assert [m["base_color"] for m in scene.materials] == [[1] * 3, [0.5] * 3, [0.5, 1, 1]]
    assert [len(m["colors"]) for m in scene.meshes()] == [4, 0, 4]
    with pytest.raises(ValueError, match="colors must be left out with a list of meshes"):
        vc.Scene.from_arrays([(CORNERS, QUAD)], colors=colors)


def test_alpha_is_a_share_unless_the_material_says_where_it_cuts():
    colors = np.ones((4, 4))
    share = vc.Scene.from_arrays(CORNERS, QUAD, colors=colors)
    cut = vc.Scene.from_arrays([(CORNERS, QUAD, {"alpha_cutoff": 0.25}, colors)])
    assert [s.materials[0]["alpha_cutoff"] for s in (share, cut)] == [-1, 0.25]


@pytest.mark.parametrize("kind", ["vertex", "face"])
def test_trimesh_keeps_colors_of_vertices_and_faces(kind):
    """A tetrahedron has as many faces as vertices."""
    shape = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        process=False,
    )
    bytes_ = np.random.default_rng(1).integers(0, 256, (4, 4)).astype(np.uint8)
    setattr(shape.visual, f"{kind}_colors", bytes_)
    scene = vc.Scene.from_trimesh(shape)
    (mesh,) = scene.meshes()
    shown = mesh["colors"][mesh["triangles"]]
    given = bytes_[shape.faces] if kind == "vertex" else bytes_[:, None].repeat(3, 1)
    np.testing.assert_allclose(shown[..., :3], linear(given[..., :3] / 255), rtol=1e-5)
    np.testing.assert_allclose(shown[..., 3], given[..., 3] / 255, rtol=1e-5)
    assert scene.materials[0]["base_color"] == [1, 1, 1]
