"""All placed triangles in one list: corners, names, and what is left out."""

import numpy as np

import viscache as vc
from core import testing


def placed_scene():
    """Two meshes, one seen through two instances, with degenerate triangles, and a sphere light."""
    r = np.random.default_rng(0)
    d = vc.SceneDescription()
    d.add_mesh(r.normal(size=(6, 3)), [[0, 1, 2], [3, 3, 4], [3, 4, 5]])
    d.add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], [[0, 1, 2], [0, 1, 3]], in_world=False)
    for m in (np.diag([2.0, 3, -1]), np.eye(3)):
        d.add_instance([1], np.concatenate([m, [[1.0], [2], [3]]], axis=1))
    d.add_sphere_light((0, 5, 0), 0.5, (1, 1, 1))
    return vc.Scene.from_description(d)


def test_every_placed_triangle_with_area_is_listed_once_with_its_corners():
    scene = placed_scene()
    flat = testing.flat_triangles(scene._core)
    sphere = len(scene.meshes())  # its tessellation: 24 rings of 48 sectors
    expected = [(0, 0, -1), (0, 2, -1)]
    expected += [(sphere, i, -1) for i in range(2 * 23 * 48)]
    expected += [(1, 0, 0), (1, 0, 1)]
    names = (flat[name].tolist() for name in ("mesh", "triangle", "instance"))
    assert list(zip(*names, strict=True)) == expected
    assert flat["degenerate"] == 3
    mesh, corners = scene.meshes()[0], flat["corners"]
    np.testing.assert_array_equal(corners[1], mesh["vertices"][mesh["triangles"][2]])
    np.testing.assert_array_equal(corners[-2], [[1, 2, 3], [3, 2, 3], [1, 5, 3]])
    np.testing.assert_array_equal(corners[-1], [[1, 2, 3], [2, 2, 3], [1, 3, 3]])


def test_thin_triangles_are_kept_and_no_triangles_are_an_empty_list():
    """Area is judged in double: its square would vanish in single precision."""
    corners = [[0, 0, 0], [1, 0, 0], [0.5, 1e-20, 0]]
    for faces in ([[0, 1, 2]], np.zeros((0, 3), int)):
        flat = testing.flat_triangles(vc.Scene.from_arrays(corners, faces)._core)
        assert flat["corners"].shape == (len(faces), 3, 3) and flat["degenerate"] == 0
