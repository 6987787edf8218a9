"""Hits name their triangle: those of the meshes in order, then those of the sphere lights."""

import numpy as np
import pytest

import viscache as vc
from fuzz.calls_geometry import check_hits, numbered
from fuzz.outcome import WrongError

OF_A_SPHERE = 2208  # as `Intersection` promises


@pytest.fixture(scope="module")
def scene():
    """A floor of two triangles that is placed twice, below two sphere lights."""
    d = vc.SceneDescription()
    floor = np.float64([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]])
    d.add_mesh(floor, np.uint32([[0, 1, 2], [0, 2, 3]]))
    d.add_instance([0], np.float64([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0]]))
    d.add_sphere_light((0, 3, 0), 1.0, (1, 1, 1))
    d.add_sphere_light((0, 13, 0), 1.0, (1, 1, 1))
    return vc.Scene.from_description(d)


@pytest.mark.parametrize("rays", ["embree", "bsp", "vlf"])
def test_sphere_lights_are_numbered_after_the_meshes(scene, rays):
    origins = [[0.1, 1, 0.1], [0.1, 1, 0.1], [0.1, 6, 0.1], [5.1, 1, 0.2]]
    up = [[0, -1, 0], [0, 1, 0], [0, 1, 0], [0, -1, 0]]
    hits = scene.intersect(origins, up, rays=rays)
    floor, first, second, placed = hits.triangle
    assert floor in (0, 1) and placed in (0, 1)  # instances share their triangles
    assert 2 <= first < 2 + OF_A_SPHERE
    assert second == first + OF_A_SPHERE  # the same place of the next sphere
    assert numbered(scene) == 2 + 2 * OF_A_SPHERE
    check_hits(hits, numbered(scene))
    with pytest.raises(WrongError, match="not there"):
        check_hits(hits, int(second))


def test_the_last_number_is_a_triangle_of_the_last_sphere(scene):
    rng = np.random.default_rng(1)
    toward = rng.normal(size=(100_000, 3))
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    found = scene.intersect(toward * 1.5 + [0, 13, 0], -toward).triangle
    assert found.min() >= 2 + OF_A_SPHERE
    assert len(np.unique(found)) > 0.95 * OF_A_SPHERE  # nearly every triangle of the sphere
    assert numbered(scene) - 50 <= found.max() + 1 <= numbered(scene)
