# ruff: noqa: E501  (scene texts stay on their lines)
"""Cylinders, disks and other surfaces of revolution: areas, sides and Mitsuba's light."""

import numpy as np
import pytest

from viscache import _core as core


def mitsuba(folder, body):
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{body}</scene>')
    return core.load_scene_file(str(path), True)


def pbrt(folder, world):
    path = folder / "scene.pbrt"
    path.write_text(f"WorldBegin\n{world}\nWorldEnd\n")
    return core.load_scene_file(str(path), True)


def areas(scene, index=0):
    """Area vectors (T, 3) of the triangles."""
    m = scene.mesh_arrays(index)
    a, b, c = m["vertices"].astype(float)[m["triangles"]].transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2


def total(scene, index=0):
    return float(np.linalg.norm(areas(scene, index), axis=1).sum())


def middles(scene):
    m = scene.mesh_arrays(0)
    return m["vertices"].astype(float)[m["triangles"]].mean(1)


def test_disks_and_cylinders_have_the_area_of_the_round_shape(tmp_path):
    disk = mitsuba(tmp_path, '<shape type="disk"/>')
    assert total(disk) == pytest.approx(np.pi, rel=1e-5)
    tube = mitsuba(
        tmp_path,
        """<shape type="cylinder"><float name="radius" value="0.5"/>
        <point name="p0" value="1, 0, 0"/><point name="p1" value="1, 3, 4"/></shape>""",
    )
    assert total(tube) == pytest.approx(2 * np.pi * 0.5 * 5, rel=1e-5)
    # Power: the inscribed polygon of 64 corners would be noticed
    assert 64 * np.sin(np.pi / 64) / np.pi != pytest.approx(1, rel=1e-4)


def test_balls_have_the_area_of_the_sphere_and_so_its_mean_shadow(tmp_path):
    ball = mitsuba(tmp_path, '<shape type="sphere"><float name="radius" value="2"/></shape>')
    assert total(ball) == pytest.approx(16 * np.pi, rel=1e-5)
    assert total(pbrt(tmp_path, 'Shape "sphere" "float radius" 2')) == pytest.approx(total(ball))
    # The shadows of a convex body have the mean area of a quarter of its surface
    axes = np.random.default_rng(1).normal(size=(200, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    shadows = np.abs(areas(ball) @ axes.T).sum(0) / 2
    assert shadows.mean() == pytest.approx(4 * np.pi, rel=1e-4)
    # Power: corners on the sphere itself would be noticed
    m = ball.mesh_arrays(0)
    inscribed = 4 / (np.linalg.norm(m["vertices"], axis=1).astype(float) ** 2).mean()
    assert inscribed < 0.998


def test_a_cylinder_spans_its_ends_and_faces_outwards_also_mirrored(tmp_path):
    for mirror in ("", '<scale x="-1" y="1" z="1"/>'):
        scene = mitsuba(
            tmp_path,
            f"""<shape type="cylinder"><point name="p0" value="0, 0, 1"/>
            <point name="p1" value="0, 0, 3"/><transform name="to_world">{mirror}</transform></shape>""",
        )
        low, high = scene.bounds()
        assert (low[2], high[2]) == pytest.approx((1, 3)) and scene.mesh_arrays(0)["normals"].size
        outwards = middles(scene) * (1, 1, 0)
        assert ((areas(scene) * outwards).sum(1) > 0).all()
        m = scene.mesh_arrays(0)
        assert ((m["normals"] * m["vertices"] * (1, 1, 0)).sum(1) > 0).all()
    inside = mitsuba(
        tmp_path, '<shape type="cylinder"><boolean name="flip_normals" value="true"/></shape>'
    )
    assert ((areas(inside) * middles(inside) * (1, 1, 0)).sum(1) < 0).all()
    with pytest.raises(core.SceneError, match="the ends of a cylinder must differ"):
        mitsuba(tmp_path, '<shape type="cylinder"><point name="p1" value="0, 0, 0"/></shape>')


@pytest.mark.parametrize(
    ("shape", "area", "tolerance"),
    [
        ('"cylinder" "float radius" 2 "float zmin" -1 "float zmax" 3', 16 * np.pi, 1e-5),
        ('"cylinder" "float radius" 2 "float phimax" 90', 2 * np.pi, 1e-5),
        ('"disk" "float radius" 2 "float height" 1', 4 * np.pi, 1e-5),
        ('"disk" "float radius" 2 "float innerradius" 1', 3 * np.pi, 2e-3),
        ('"disk" "float radius" 2 "float phimax" 180', 2 * np.pi, 2e-3),
        ('"cone" "float radius" 3 "float height" 4', 15 * np.pi, 1e-3),
        ('"paraboloid"', np.pi / 6 * (5**1.5 - 1), 2e-3),
        ('"sphere" "float zmin" 0', 2 * np.pi, 2e-3),
        ('"sphere" "float radius" 2 "float phimax" 90', 4 * np.pi, 3e-3),
    ],
)
def test_surfaces_of_revolution_have_their_area_in_pbrt(tmp_path, shape, area, tolerance):
    assert total(pbrt(tmp_path, f"Shape {shape}")) == pytest.approx(area, rel=tolerance)


@pytest.mark.parametrize("shape", ['"cylinder"', '"cone"', '"sphere" "float zmin" 0'])
def test_pbrt_shapes_face_outwards_and_reverse(tmp_path, shape):
    for words, side in ((f"Shape {shape}", 1), (f"Scale -1 1 1 Shape {shape}", 1),
                        (f"ReverseOrientation Shape {shape}", -1)):  # fmt: skip
        scene = pbrt(tmp_path, words)
        assert (side * (areas(scene) * middles(scene) * (1, 1, 0)).sum(1) > -1e-9).all(), words
    bowl = pbrt(tmp_path, 'Shape "paraboloid"')
    assert (areas(bowl)[:, 2] < 0).all()
    assert (areas(pbrt(tmp_path, 'Shape "disk" "float innerradius" .5'))[:, 2] > 0).all()
