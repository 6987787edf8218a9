"""Scenes, settings and sizes as every call takes them: by object or by name, with one default."""

import inspect
import warnings

import numpy as np
import pytest

import viscache as vc
from viscache.settings.registry import NAMES

SPEC = "room?triangles=5000"
SIZE = (24, 16)


@pytest.fixture(scope="module")
def scene():
    return vc.scenes.build(SPEC)


def test_render_takes_names_for_everything(scene):
    named = vc.render(SPEC, "direct", visibility="aqvc", rays="bsp", size=SIZE)
    made = vc.render(scene, vc.Direct(), visibility=vc.Aqvc(), rays=vc.Bsp(), size=SIZE)
    assert named.sha256 == made.sha256
    assert named.parameters["rays"]["name"] == "Bsp"
    assert named.parameters["visibility"] == made.parameters["visibility"]
    maps = {"name": "shadow_map", "resolution": 64}, vc.ShadowMap(resolution=64)
    methods = {n: c() for n, c in NAMES["visibility"].items() if n != "vismap"}  # needs a sky
    assert {"exact", "aqvc", "unoccluded"} < methods.keys()
    for name, settings in (maps, *methods.items()):
        a, b = (vc.render(scene, "direct", visibility=v, size=SIZE) for v in (name, settings))
        assert a.sha256 == b.sha256
    for name, integrator in (
        ("whitted", vc.Whitted()),
        ("ao", vc.AmbientOcclusion()),
        ("bdpt", vc.Bdpt(max_depth=8)),
    ):
        shown = vc.render(scene, name, size=(8, 5)).sha256
        assert shown == vc.render(scene, integrator, size=(8, 5)).sha256


def test_scenes_are_files_too(tmp_path):
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for given in (tmp_path / "one.obj", str(tmp_path / "one.obj")):
        frame = vc.render(given, "direct", env=1.0, size=(8, 8))
        assert frame.image.any()
    with pytest.raises(ValueError, match="unknown scene 'romm'; did you mean 'room'"):
        vc.render("romm", "direct")
    with pytest.raises(ValueError, match="scene must be a Scene, a file or a built-in name, got 3"):
        vc.tune(3, "direct")


def test_queries_take_names_of_ray_casters(scene):
    rng = np.random.default_rng(1)
    low, high = scene.bounds
    x, y = rng.uniform(low, high, (2, 200, 3))
    exact = scene.visible(x, y)
    for name, rays in (("embree", vc.Embree()), ("bsp", vc.Bsp())):
        np.testing.assert_array_equal(scene.visible(x, y, rays=name), exact)
        assert scene.caster(name) is scene.caster(rays)
        found = scene.occluded(x, y - x, 1.0, rays=name)
        np.testing.assert_array_equal(found, scene.occluded(x, y - x, 1.0, rays=rays))
        assert np.isfinite(scene.intersect(x, y - x, rays=name).t).any()
    with pytest.raises(ValueError, match="unknown rays 'bps'; did you mean 'bsp'"):
        scene.visible(x, y, rays="bps")


def test_tune_and_sweep_take_names():
    named = vc.tune("slits", "direct", visibility="aqvc", rel_l1_reflected=0.05, size=(48, 30))
    scene = vc.scenes.slits()
    made = vc.tune(scene, vc.Direct(), visibility=vc.Aqvc(), rel_l1_reflected=0.05, size=(48, 30))
    assert (named.c_e, named.rel_l1) == (made.c_e, made.rel_l1)
    given = {"over": {"c_e": [4]}, "size": SIZE, "metrics": ["rel_l1"]}
    table = vc.sweep("slits", "direct", visibility="aqvc", rays="bsp", **given)
    other = vc.sweep(scene, vc.Direct(), visibility=vc.Aqvc(), rays=vc.Bsp(), **given)
    assert float(table.rel_l1[0, 0]) == float(other.rel_l1[0, 0])


def test_caches_and_fields_take_names():
    scene = vc.scenes.cube_on_plane()
    cache = vc.VisibilityMapCache("cube_on_plane", "high", rays="bsp")
    assert cache.settings == vc.MapSettings(preset="high") and cache.rays_by == vc.Bsp()
    assert cache.scene.content_hash == scene.content_hash
    with pytest.raises(ValueError, match="preset must be"):
        vc.VisibilityMapCache("cube_on_plane", "hihg")
    a, b = (
        vc.cached_ambient_occlusion(s, settings=m, size=SIZE)
        for s, m in (("cube_on_plane", "low"), (scene, vc.MapSettings(preset="low")))
    )
    assert a.sha256 == b.sha256
    field = vc.VisibilityField("cube_on_plane", 9, 4)
    assert field.scene.content_hash == scene.content_hash
    assert vc.vlf.DynamicField("cube_on_plane", vc.Vlf(n_directions=9, n_tiles=4)).stats["bytes"]
    with pytest.raises(ValueError, match=r"settings must be vc\.Vlf"):
        vc.VisibilityField(scene, settings="bsp")
    at = vc.correlation.surface_points("cube_on_plane", 100)
    rows = vc.aligned_occlusion("cube_on_plane", at.positions, at.normals, 33)
    np.testing.assert_array_equal(rows, vc.aligned_occlusion(scene, at.positions, at.normals, 33))


def test_settings_of_a_field_win_where_they_are_given():
    scene = vc.scenes.cube_on_plane()
    field = vc.VisibilityField(scene, settings=vc.Vlf(n_directions=33, n_tiles=8, lazy=True))
    assert (field.n_directions, field.n_tiles, field.settings.lazy) == (33, 8, True)
    same = vc.VisibilityField(scene, 33, settings=vc.Vlf(n_directions=33, n_tiles=8))
    assert same.n_tiles == 8
    usual = vc.VisibilityField(scene, 9, 4).settings
    assert usual == vc.Vlf(n_directions=9, n_tiles=4)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"n_directions": 9}, "n_directions must be left out beside settings, or be their 33"),
        ({"n_tiles": 16}, "n_tiles must be left out beside settings, or be their 8, got 16"),
        ({"bsp_depth": 2}, "bsp_depth must be left out beside settings, or be their 'auto'"),
        ({"max_bytes": 1 << 20}, "max_bytes must be left out beside settings"),
    ],
)
def test_a_keyword_that_contradicts_the_settings_is_refused_by_name(given, says):
    settings = vc.Vlf(n_directions=33, n_tiles=8)
    with pytest.raises(ValueError, match=says):
        vc.VisibilityField("cube_on_plane", settings=settings, **given)


SIZED = (
    "viscache.render",
    "viscache.tune",
    "viscache.sweep",
    "viscache.cached_ambient_occlusion",
    "viscache.Relighting",
    "viscache.VisibilityMapCache.update",
    "viscache.shot.tiles.render",
)


@pytest.mark.parametrize("name", SIZED)
def test_the_size_is_the_cameras_own_everywhere(name):
    value = vc
    for part in name.split(".")[1:]:
        value = getattr(value, part)
    assert inspect.signature(value).parameters["size"].default is None


def test_the_cameras_own_size_is_what_is_rendered_tuned_and_swept():
    d = vc.SceneDescription()
    grey = d.add_material()
    corners = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
    d.add_mesh(corners, np.array([[0, 2, 1], [0, 3, 2]], np.uint32), material=grey)
    d.add_point_light((0.0, 1.0, 0.0), (1.0, 1.0, 1.0))
    d.add_camera((0.0, 1.0, 2.0), (0.0, 0.0, 0.0), width=20, height=12)
    scene = vc.Scene.from_description(d)
    assert vc.render(scene, "direct").size == (20, 12)
    assert vc.tiles.render(scene, "direct", parts=2).size == (20, 12)
    assert vc.cached_ambient_occlusion(scene).size == (20, 12)
    table = vc.sweep(scene, "direct", over={"c_e": [4]}, metrics=["rel_l1"])
    given = vc.sweep(scene, "direct", over={"c_e": [4]}, metrics=["rel_l1"], size=(20, 12))
    assert table.queries.values == given.queries.values
    own, same = (
        vc.tune(scene, "direct", rel_l1_reflected=0.1, **s) for s in ({}, {"size": (20, 12)})
    )
    assert own.pilots == same.pilots


def test_dir_is_what_is_public():
    assert dir(vc) == sorted(vc.__all__)
    assert {"vlf", "vismap", "correlation", "metrics"} <= set(dir(vc))
    assert not {"scene", "frame", "provenance", "settings", "cameras"} & set(dir(vc))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert all(hasattr(vc, name) for name in dir(vc))


def test_what_saves_loads_and_the_reverse():
    classes = [v for v in (getattr(vc, n) for n in vc.__all__) if inspect.isclass(v)]
    uneven = [c.__name__ for c in classes if hasattr(c, "save") != hasattr(c, "load")]
    assert uneven == [] and hasattr(vc.Frame, "save") and hasattr(vc.VisibilityMapCache, "load")
    functions = set(vc.correlation.__all__)
    assert {n for n in functions if n.startswith("load_")} == {"load_dataset"}
    assert {n for n in functions if n.startswith("save_")} == {"save_dataset"}
