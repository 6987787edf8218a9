"""Offsets follow the surface that a ray leaves: what is far or large moves no other shadow."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from render.mitsuba_scene import ball
from viscache_lab.extremes.families.moves import turn

Array = npt.NDArray[Any]
RAYS = {
    "embree": vc.Embree(),
    "watertight": vc.Embree(watertight=True),
    "bsp": vc.Bsp(),
    "wald": vc.Bsp(kernel="wald"),
    "field": vc.Vlf(n_directions=9, n_tiles=32),
}
#: On the floor of each scene.
BALL = ball((0, 1, 0), 1, 24)


def floor(half):
    s = half
    corners = np.array([[-s, 0, -s], [s, 0, -s], [s, 0, s], [-s, 0, s]])
    return corners, np.array([[0, 2, 1], [0, 3, 2]], np.uint32)


def dome(radius):
    far = ball((0, 0, 0), radius, 12)
    return far.vertices, far.triangles


def card(far):
    corners = np.array([[far, -5, far], [far + 1, -5, far], [far, -5, far + 1]])
    return corners, np.array([[0, 1, 2]], np.uint32)


def around_the_ball(parts, light, frame):
    """A ball, what is around it, a light and a camera; all turned by a rotation."""
    q = np.eye(3) if frame is None else frame
    d = vc.SceneDescription()
    white = d.add_material(base_color=(0.6, 0.6, 0.6))
    for corners, triangles in [*parts, (BALL.vertices, BALL.triangles)]:
        d.add_mesh(corners @ q.T, triangles, material=white)
    if light == "directional":
        d.add_directional_light(tuple(q @ [1, 1, 0.6]), (3, 3, 3))
    else:
        d.add_point_light(tuple(q @ [3, 5, 2]), (90, 90, 90))
    d.add_camera(tuple(q @ [0, 4, 9]), tuple(q @ [0, 0.3, 0]), up=tuple(q[:, 1]), fov_deg=30)
    return vc.Scene.from_description(d)


def lit(parts, light="directional", rays=None, visibility=None, frame=None):
    """Where the light arrives, (96, 96) bool."""
    scene = around_the_ball(parts, light, frame)
    found = vc.render(scene, vc.Direct(), visibility=visibility, rays=rays, size=(96, 96))
    return np.asarray(found.image)[..., 0] > 0.02


@pytest.mark.parametrize("far", [1e3, 1e4, 1e6])
@pytest.mark.parametrize("rays", RAYS)
def test_one_far_triangle_moves_no_shadow(rays, far):
    near = lit([floor(1e3)], rays=RAYS[rays])
    assert 0.03 < 1 - near.mean() < 0.3
    np.testing.assert_array_equal(lit([floor(1e3), card(far)], rays=RAYS[rays]), near)


@pytest.mark.parametrize("half", [1e4, 1e6])
@pytest.mark.parametrize("rays", RAYS)
def test_a_large_floor_keeps_the_shadow_of_a_small_ball(rays, half):
    np.testing.assert_array_equal(lit([floor(half)], rays=RAYS[rays]), lit([floor(1e3)]))


@pytest.mark.parametrize("visibility", ["exact", "packets", "shafts", "aqvc?c_e=64"])
def test_packets_shafts_and_caches_keep_it_too(visibility):
    chosen = {
        "exact": vc.Exact(),
        "packets": vc.Exact(engine="packets"),
        "shafts": vc.Exact(engine="shafts"),
    }.get(visibility, visibility)
    near = lit([floor(1e3)], "point")
    for parts in ([floor(1e6)], [floor(1e3), card(1e6)]):
        found = lit(parts, "point", visibility=chosen)
        # Cells follow the size of the scene
        assert (found != near).mean() <= (0 if "aqvc" not in visibility else 0.02)


@pytest.mark.parametrize("rays", RAYS)
def test_a_dome_of_tilted_triangles_moves_no_shadow_inside(rays):
    q = turn(3)
    near = lit([floor(1e3)], "point", frame=q)
    found = lit([floor(1e3), dome(1e6)], "point", rays=RAYS[rays], frame=q)
    # The corners of the floor and of the ball are rounded where the light grazes them
    assert (found != near).mean() <= 3e-4


@pytest.mark.parametrize("rays", RAYS)
def test_a_large_tilted_floor_shades_itself_nowhere(rays):
    """Its offset grows with it, as its plane is known to ulps of its size."""
    q = turn(3)
    for half in (1e3, 1e4):
        near, found = lit([floor(1e3)], frame=q), lit([floor(half)], rays=RAYS[rays], frame=q)
        assert not (near & ~found).sum() > 0.002 * near.size


def test_shared_directions_leave_the_batch_where_its_offsets_are_too_coarse():
    def ambient(parts, engine):
        light = vc.AmbientOcclusion(
            n_samples=129, directions="shared", max_distance=4, engine=engine
        )
        scene = around_the_ball(parts, "point", None)
        return np.asarray(vc.render(scene, light, size=(48, 48)).image)[..., 0]

    near = ambient([floor(20)], "embree")
    far = [floor(20), card(1e6)]
    # Rays start at other heights of the same surfaces: one level ray may find what the other misses
    assert (ambient(far, "auto") != near).sum() <= 2
    assert (ambient(far, "batch") != near).mean() > 0.5
