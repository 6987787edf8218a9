"""coplanar_share against meshes whose share is known."""

import numpy as np

from viscache.scenes import coplanar_share
from viscache.scenes.shapes import box, bumpy_sphere, cylinder, quad, sphere


def test_a_box_and_a_quad_are_all_coplanar():
    for shape in (box([0, 0, 0], [1, 2, 3]), quad([0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0])):
        assert coplanar_share(*shape.mesh(1.0)) == 1.0


def test_a_subdivided_wall_is_all_coplanar_even_with_duplicated_vertices():
    x, y = np.meshgrid(np.arange(9.0), np.arange(7.0))
    points = np.stack([x.ravel(), y.ravel(), 0.3 * x.ravel()], axis=1)
    a = (np.arange(6)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.stack(t, 1) for t in ((a, a + 1, a + 10), (a, a + 10, a + 9))])
    assert coplanar_share(points, faces) == 1.0
    soup = points[faces].reshape(-1, 3)
    assert coplanar_share(soup, np.arange(len(soup)).reshape(-1, 3)) == 1.0


def test_a_tetrahedron_and_lone_triangles_have_none():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    assert coplanar_share(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) == 0.0
    # In one plane, but they share no edge.
    far = np.concatenate([corners[:3], np.add(corners[:3], [5, 0, 0])])
    assert coplanar_share(far, [[0, 1, 2], [3, 4, 5]]) == 0.0
    assert coplanar_share(corners, np.zeros((0, 3), int)) == 0.0


def test_a_fold_counts_below_the_tolerance_and_not_above():
    for angle, share in ((5e-5, 1.0), (4e-4, 0.0)):
        points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, np.sin(angle) / np.sqrt(2)]]
        assert coplanar_share(points, [[0, 1, 2], [1, 3, 2]]) == share


def test_half_of_a_roof_on_a_wall_counts():
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 2, 1], [0.5, -1, 1]]
    assert coplanar_share(points, [[0, 1, 2], [0, 2, 3], [3, 2, 4], [0, 5, 1]]) == 0.5


def test_curved_shapes_have_hardly_any():
    for shape in (cylinder(0.2, 1.0), sphere(0.5, 8), bumpy_sphere(0.5, 8)):
        assert coplanar_share(*shape.mesh(1.0)) <= 0.02
