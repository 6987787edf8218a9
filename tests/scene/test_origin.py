"""Scenes far from the origin keep their digits where they say where they are."""

import json
import pickle

import numpy as np
import pytest

import viscache as vc
from viscache_lab.extremes.pictures import rel_l1
from viscache_lab.parity.exporters.formats import gltf

CORNERS, ONE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), [[0, 1, 2]]
FAR = (5e7 + 0.125, -3e7, 7e6 + 0.5)


def test_all_that_is_placed_is_relative_to_the_origin():
    description = vc.SceneDescription(FAR)
    assert description.origin == list(FAR)
    mesh = description.add_mesh(CORNERS, ONE, in_world=False)
    description.add_mesh(CORNERS + FAR, ONE)
    place = np.eye(4)
    place[:3, 3] = np.add(FAR, [0, 0, 0.25])
    description.add_instance([mesh], place)
    description.add_point_light(np.add(FAR, 1.5), (1, 1, 1))
    description.add_point_lights([np.add(FAR, 0.5)], [(1, 1, 1)])
    description.add_sphere_light(np.add(FAR, 2.5), 0.1, (1, 1, 1))
    description.add_camera(np.add(FAR, [0, 0, 4.5]), FAR)
    for made in (description, pickle.loads(pickle.dumps(description))):
        scene = vc.Scene.from_description(made)
        assert scene.origin.tolist() == list(FAR)
        np.testing.assert_array_equal(scene.meshes()[1]["vertices"], CORNERS.astype(np.float32))
        np.testing.assert_array_equal(scene.meshes()[0]["vertices"], CORNERS.astype(np.float32))
        lights = {tuple(x.get("position", x.get("center"))) for x in scene.lights}
        assert lights == {(1.5,) * 3, (0.5,) * 3, (2.5,) * 3}
        assert tuple(scene.cameras[0].origin) == (0, 0, 4.5)
        hit = scene.intersect([[0.2, 0.2, 1.0]], [[0, 0, -1]])
        assert hit.instance[0] == 0
        assert hit.t[0] == pytest.approx(0.75, rel=1e-6)  # Embree rounds otherwise without AVX-512


def test_the_origin_stays_with_the_scene():
    scene = vc.Scene.from_arrays(CORNERS + FAR, ONE, origin=FAR)
    for same in (scene.with_environment(1.0), pickle.loads(pickle.dumps(scene))):
        assert same.origin.tolist() == list(FAR)
    np.testing.assert_array_equal(scene.local(CORNERS + FAR), CORNERS)
    assert vc.Scene.from_arrays(CORNERS, ONE).origin.tolist() == [0, 0, 0]
    near = vc.Scene.from_arrays(CORNERS, ONE)
    assert scene.content_hash == near.content_hash  # the look is the same


@pytest.mark.parametrize("share", [1, 1e-3], ids=["one point", "few steps"])
def test_the_warning_names_an_origin_that_ends_it(share):
    corners = CORNERS + np.multiply(FAR, share)
    (warning,) = vc.Scene.from_arrays(corners, ONE, env=1.0).warnings
    assert ("one point" if share == 1 else "times its size from the origin") in warning
    given = warning.partition("origin=(")[2].partition(")")[0]
    point = [float(v) for v in given.split(",")]
    assert vc.Scene.from_arrays(corners, ONE, env=1.0, origin=point).warnings == []


def far_file(folder):
    """A triangle, and a camera, under nodes that are far away."""
    place = {"translation": list(FAR)}
    change = {
        "attr": {"POSITION": "f4x3 0 0 0 1 0 0 0 1 0", "TEXCOORD_0": ""},
        "idx": "",
        "node": place,
        "camera": {"perspective": {"yfov": 0.7, "znear": 0.1}},
        "eye": place,
    }
    path = folder / "a.gltf"
    path.write_bytes(gltf("a", json.dumps(change))["a.gltf"])
    return path


def test_gltf_files_lose_nothing(tmp_path):
    scene = vc.load_scene(far_file(tmp_path), origin=np.subtract(FAR, 0.25))
    np.testing.assert_array_equal(scene.meshes()[0]["vertices"], CORNERS.astype(np.float32) + 0.25)
    assert tuple(scene.cameras[0].origin) == (0.25, 0.25, 0.25)
    lost = vc.load_scene(far_file(tmp_path)).meshes()[0]["vertices"]
    assert np.abs(lost - FAR - CORNERS).max() > 0.1


def test_other_files_are_moved_as_they_are(tmp_path):
    path = tmp_path / "a.pbrt"
    path.write_text(
        """
        LookAt 4099 8192 5 4099 8192 0 0 1 0
        Camera "perspective" "float fov" 40
        WorldBegin
        LightSource "point" "point from" [4097.5 8193 2] "rgb I" [1 1 1]
        Translate 4096 8192 0
        Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0.25 0 0 1 0 0 0 1 0]
        ObjectBegin "o"
        Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 0 0 1 0 0 0 1 0]
        ObjectEnd
        Translate 0 0 0.5
        ObjectInstance "o"
        WorldEnd
        """
    )
    here, moved_to = vc.load_scene(path), vc.load_scene(path, origin=(4096, 8192, 1))
    by = np.float32([4096, 8192, 1])
    np.testing.assert_array_equal(moved_to.bounds, here.bounds - by)
    np.testing.assert_array_equal(moved_to.cameras[0].origin, here.cameras[0].origin - by)
    np.testing.assert_array_equal(moved_to.lights[0]["position"], here.lights[0]["position"] - by)
    assert moved_to.origin.tolist() == [4096, 8192, 1]
    size = {"size": (24, 16), "threads": 1}
    assert rel_l1(*(vc.render(s, "direct", **size) for s in (moved_to, here))) < 1e-2
    assert pickle.loads(pickle.dumps(moved_to)).origin.tolist() == [4096, 8192, 1]


def test_trimesh_objects_keep_their_digits():
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(CORNERS + FAR, ONE, process=False)
    scene = vc.Scene.from_trimesh(mesh, origin=FAR)
    np.testing.assert_array_equal(scene.meshes()[0]["vertices"], CORNERS.astype(np.float32))


@pytest.mark.parametrize("bad", [(0, 0), (0, 0, np.nan), (0, np.inf, 0), "x", (0, 0, 1j), None])
def test_bad_origins_are_refused(bad, tmp_path):
    with pytest.raises(ValueError, match="origin must be"):
        vc.Scene.from_arrays(CORNERS, ONE, origin=bad)
    with pytest.raises(ValueError, match="origin must be"):
        vc.load_scene(far_file(tmp_path), origin=bad)
    with pytest.raises((ValueError, TypeError)):
        vc.SceneDescription(bad)
