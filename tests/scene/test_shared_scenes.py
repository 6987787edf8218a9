"""Every folder of the shared scenes loads with the triangle counts and boxes of its README."""

import numpy as np
import pytest
import trimesh

from viscache import _core as core

# file, placed triangles, sphere lights, box as the README rounds it, half a unit of its last digit
SCENES = [
    ("cornell-box/scene.xml", 36, 0, [(-1, 0, -1), (1, 2, 1)], 1e-4),
    ("cornell-box-obj/cbox.xml", 38, 0, [(0, 0, 0), (556, 548.8, 559.2)], 1e-4),
    ("sponza-dabrovic/scene.xml", 66445, 1, [(-17.4, -0.9, -7.8), (17.4, 17.1, 7.8)], 0.05),
    ("classroom/scene.xml", 103832, 0, [(-110.8, -0.166, -110.8), (110.8, 3.056, 110.8)], 0.05),
    ("living-room/scene.xml", 143163, 0, [(-0.51, 0, -3.64), (5.12, 2.88, 0.59)], 0.006),
    ("veach-ajar/scene.pbrt", 382690, 0, [(-9.65, -0.02, -7.6), (7.43, 3.8, 0.6)], 0.006),
    ("sanmiguel-part/scene.xml", 2162246, 0, [(-38, -36.9, -0.38), (46.8, 37, 53.5)], 0.06),
    ("sanmiguel-part/scene.pbrt", 2162246, 0, [(-38, -36.9, -0.38), (46.8, 37, 53.5)], 0.06),
    ("gltf-pine/scene.gltf", 1650, 0, [(-29.2, 0, -29.1), (29.1, 75.0, 28.2)], 0.05),
    ("gltf-balloon/scene.gltf", 35698, 0, [(-0.14, 0.21, -0.29), (0.44, 0.91, 0.29)], 0.006),
    ("scans/stanford_bunny.ply", 69451, 0, [(-0.095, 0.033, -0.062), (0.061, 0.187, 0.059)], 5e-4),
    ("scans/happy_buddha_30k.ply", 29890, 0, [(-0.098, -0.099, 0), (0.099, 0.099, 0.487)], 6e-4),
]


@pytest.mark.parametrize(("name", "triangles", "spheres", "box", "tolerance"), SCENES)
def test_a_shared_scene_has_the_triangles_and_the_box_of_the_readme(
    shared_scenes, name, triangles, spheres, box, tolerance
):
    scene = core.load_scene_file(str(shared_scenes / name))
    assert scene.triangle_count == triangles
    assert sum(light["kind"] == "sphere" for light in scene.lights) == spheres
    np.testing.assert_allclose(scene.bounds(), box, rtol=0, atol=tolerance)


@pytest.mark.parametrize(
    "name",
    [
        "scans/stanford_bunny.ply",
        "scans/happy_buddha_30k.ply",
        "gltf-pine/scene.gltf",
        "gltf-balloon/scene.gltf",
        "cornell-box-obj/meshes/cbox_largebox.obj",
    ],
)
def test_a_shared_model_has_the_box_that_trimesh_reads(shared_scenes, name):
    path = shared_scenes / name
    oracle = trimesh.load(path, process=False, force="scene")
    scene = core.load_scene_file(str(path))
    np.testing.assert_allclose(scene.bounds(), oracle.bounds, rtol=1e-6, atol=1e-4)
    assert scene.triangle_count == sum(
        len(oracle.geometry[g].faces)
        for _, g in (oracle.graph[n] for n in oracle.graph.nodes_geometry)
    )


def test_what_a_shared_scene_asks_for_in_vain_is_named_with_its_line(shared_scenes):
    path = shared_scenes / "classroom" / "scene.xml"
    warnings = core.load_scene_file(str(path)).warnings
    line = 1 + next(i for i, t in enumerate(path.read_text().splitlines()) if "sunsky" in t)
    assert f"{path}:{line}" in [where for where, text in warnings if "sun of Mitsuba 0.6" in text]
    with pytest.raises(core.SceneError, match=r"scene.xml:\d+: the sun of Mitsuba 0.6"):
        core.load_scene_file(str(path), strict=True)


def test_zero_area_triangles_of_the_shared_scenes_are_kept(shared_scenes):
    scene = core.load_scene_file(str(shared_scenes / "living-room" / "scene.xml"))
    zero = 0
    for i in range(len(scene.meshes)):
        mesh = scene.mesh_arrays(i)
        p = mesh["vertices"].astype(np.float64)[mesh["triangles"]]
        zero += int((np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) == 0).all(1).sum())
    assert zero == 190


def test_exr_images_stay_pending_and_others_are_decoded(shared_scenes):
    scene = core.load_scene_file(str(shared_scenes / "living-room" / "scene.xml"))
    for image in scene.images:
        assert (image["width"] == 0) == image["path"].endswith(".exr")
    pending = [i for i, image in enumerate(scene.images) if image["width"] == 0]
    assert len(pending) == 1
    scene.set_image(pending[0], np.ones((2, 4, 3), np.float32))
    assert scene.images[pending[0]]["width"] == 4


def test_the_same_courtyard_comes_from_mitsuba_and_from_pbrt(shared_scenes):
    a = core.load_scene_file(str(shared_scenes / "sanmiguel-part" / "scene.xml"))
    b = core.load_scene_file(str(shared_scenes / "sanmiguel-part" / "scene.pbrt"))
    for i in range(len(a.meshes)):
        left, right = a.mesh_arrays(i), b.mesh_arrays(i)
        assert np.array_equal(left["vertices"], right["vertices"])
        assert np.array_equal(left["triangles"], right["triangles"])
    # The mirrored pbrt camera: its right and up cross to backwards, as in any right-handed one.
    camera = b.cameras[0]
    np.testing.assert_allclose(
        np.cross(camera["right"], camera["up"]), -np.array(camera["forward"]), atol=1e-6
    )


def test_the_door_is_seen_by_an_unmirrored_camera(shared_scenes):
    camera = core.load_scene_file(str(shared_scenes / "veach-ajar" / "scene.pbrt")).cameras[0]
    # pbrt is left-handed: this file's matrix is a rotation there, hence a mirrored frame here.
    sign = np.dot(np.cross(camera["right"], camera["up"]), camera["forward"])
    assert abs(sign) == pytest.approx(1, abs=1e-5)
    assert camera["fov_deg"] == pytest.approx(35.983398) and not camera["horizontal"]
    assert (camera["width"], camera["height"]) == (512, 288)
