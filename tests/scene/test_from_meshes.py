"""Scenes from lists of meshes and from trimesh."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core

CORNERS = np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], dtype=float)
QUAD = np.array([[0, 2, 1], [0, 3, 2]])


def raised(height):
    return CORNERS + np.array([0.0, height, 0.0])


def test_a_list_of_meshes_keeps_each_ones_material():
    scene = vc.Scene.from_arrays(
        [
            (CORNERS, QUAD),
            (raised(1), QUAD, (1.0, 0.0, 0.0)),
            [raised(2), QUAD, {"kind": "glossy", "roughness": 0.25}],
        ],
        base_color=(0.1, 0.2, 0.3),
        env=1.0,
    )
    assert scene.triangles == 6
    one, listed = (
        vc.Scene.from_arrays(*given) for given in ((CORNERS, QUAD), ([(CORNERS, QUAD)],))
    )
    assert one.content_hash == listed.content_hash
    materials = [_core.scene_materials(scene._core)[m["material"]] for m in scene.meshes()]
    assert materials[0]["base_color"] == pytest.approx((0.1, 0.2, 0.3))
    assert materials[1]["base_color"] == [1, 0, 0]
    assert materials[2]["kind"] == _core.MaterialKind.GLOSSY and materials[2]["roughness"] == 0.25
    for height, mesh in enumerate(scene.meshes()):
        np.testing.assert_array_equal(mesh["vertices"], raised(height).astype("f4"))


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((CORNERS,), "meshes must be a list of"),
        (([(CORNERS,)],), "meshes must be a list of"),
        (([(CORNERS, QUAD, {"kind": "gold"})],), "kind of a material must be one of"),
        (([(CORNERS, QUAD, (1.0,))],), "base_color must have 3 values, got 1"),
        (([(CORNERS, QUAD + 9)],), "triangle"),
        (([(CORNERS, QUAD * 0.5)],), "triangles must be integers"),
    ],
    ids=str,
)
def test_lists_that_are_none_are_refused(given, says):
    with pytest.raises(ValueError, match=says):
        vc.Scene.from_arrays(*given)


def test_trimesh_objects_become_scenes():
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box(extents=(1, 2, 3))
    box.visual.face_colors = [255, 0, 51, 255]
    one = vc.Scene.from_trimesh(box, env=1.0)
    assert one.triangles == 12
    np.testing.assert_allclose(one.bounds, [[-0.5, -1, -1.5], [0.5, 1, 1.5]])
    (mesh,) = one.meshes()
    np.testing.assert_allclose(
        mesh["colors"], [[1, 0, ((0.2 + 0.055) / 1.055) ** 2.4, 1]] * 8, rtol=1e-6
    )

    placed = trimesh.Scene()
    placed.add_geometry(
        box, node_name="a", transform=trimesh.transformations.translation_matrix([5, 0, 0])
    )
    placed.add_geometry(box, node_name="b", transform=np.diag([1.0, 1.0, -1.0, 1.0]))
    both = vc.Scene.from_trimesh(placed)
    np.testing.assert_allclose(both.bounds, [[-0.5, -1, -1.5], [5.5, 1, 1.5]])
    listed = vc.Scene.from_trimesh([placed, box])
    assert (both.triangles, listed.triangles) == (24, 36)
    assert {m["name"] for m in both.meshes()} == {"a", "b"}
    for mesh in both.meshes():  # outsides stay outsides, also of what is mirrored
        a, b, c = np.moveaxis(mesh["vertices"][mesh["triangles"]], 1, 0)
        middle = mesh["vertices"].mean(axis=0)
        assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a - middle) > 0).all()


def test_what_has_no_triangles_is_refused_by_name():
    trimesh = pytest.importorskip("trimesh")
    cloud = trimesh.PointCloud(np.zeros((4, 3)))
    with pytest.raises(
        vc.SceneError, match="meshes must be triangle meshes of trimesh, got PointCloud"
    ):
        vc.Scene.from_trimesh([cloud])
    with pytest.raises(vc.SceneError, match="got ndarray: ndarray"):
        vc.Scene.from_trimesh(np.zeros((4, 3)))


def test_a_scene_without_triangles_warns():
    empty = vc.Scene.from_arrays(np.zeros((0, 3)), np.zeros((0, 3), int), env=1.0)
    assert empty.warnings == ["the scene has no triangles; rays hit nothing"]
    assert "no triangles" in vc.render(empty, "direct", size=(4, 4)).warnings[0]
    assert not any("triangles" in w for w in vc.scenes.cube_on_plane().warnings)
