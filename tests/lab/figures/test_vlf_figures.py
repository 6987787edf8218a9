"""Parts of the visibility field's figures."""

from types import SimpleNamespace

import numpy as np
import pytest

import viscache as vc
from viscache_lab.cases.beams import Beams
from viscache_lab.cases.moving_object import ball
from viscache_lab.experiment import Trial
from viscache_lab.figures import vlf_drawings, vlf_tracers
from viscache_lab.figures.vlf_frames import local_shading
from viscache_lab.figures.vlf_occlusion import place
from viscache_lab.figures.vlf_tracers import camera_rays, first_hits


def test_tiles_of_an_edge_by_every_way():
    """A diagonal through a tile's corner region: a DDA steps over it."""
    a, b = np.float32([-0.99, -0.99]), np.float32([0.95, -0.2])
    touched = vlf_drawings.touched_tiles(a, b)
    assert vlf_drawings.supercover(a, b) == touched
    assert vlf_drawings.dda(a, b) < touched
    level = np.float32([-0.9, 0.03]), np.float32([0.9, 0.03])
    row = {(x, 8) for x in range(16)}
    assert vlf_drawings.touched_tiles(*level) == vlf_drawings.dda(*level) == row


def test_rays_of_a_camera_meet_what_its_picture_shows():
    scene = vc.scenes.room(triangles=2000)
    view, size = scene.cameras[1], (40, 24)
    beams = camera_rays(view, size)
    depth = scene.intersect(beams.origins, beams.directions).t.reshape(24, 40)
    frame = vc.render(scene, vc.Direct(), size=size, spp=64, camera=view)
    shown = frame.layers["depth"][..., 0]

    def alike(other):
        return float((np.abs(shown - other) < 0.01 * shown).mean())

    assert alike(depth) > 0.7
    # A pixel aside, upside down, or mirrored, they would not
    for wrong in (np.roll(depth, 1, axis=1), depth[::-1], depth[:, ::-1]):
        assert alike(wrong) < 0.5


def test_first_hits_lie_on_surfaces_and_their_normals_look_back():
    scene = vc.scenes.cube_on_plane()
    view = scene.cameras[0]
    positions, normals, seen = first_hits(scene, view, (20, 12))
    assert seen.shape == (12, 20) and seen.sum() == len(positions)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)
    to_eye = np.asarray(view.origin) - positions
    assert (np.einsum("nk,nk->n", to_eye, normals) > 0).all()
    eye = np.broadcast_to(view.origin, to_eye.shape)
    assert scene.visible(positions + 1e-3 * normals, eye).all()


def test_rays_of_occlusion_are_those_of_the_aligned_batch():
    spot = place("cow", quick=True)
    by_point, by_direction = spot.beams(40)
    blocked = spot.scene.occluded(by_point.origins, by_point.directions).reshape(-1, 129)
    turned = spot.scene.occluded(by_direction.origins, by_direction.directions)
    np.testing.assert_array_equal(turned.reshape(129, -1).T, blocked)
    pick = np.unique(np.linspace(0, len(spot.positions) - 1, 40).astype(int))
    words = vc.aligned_occlusion(
        spot.scene, spot.positions[pick], spot.normals[pick], 129, engine="embree"
    )
    free = np.unpackbits(words.view(np.uint8), axis=1, bitorder="little")[:, :129]
    np.testing.assert_array_equal(free, ~blocked)
    assert 0.05 < blocked.mean() < 0.95


def test_a_grid_search_takes_the_fastest(monkeypatch):
    seconds = iter([3.0, 1.0, 2.0, 4.0])
    monkeypatch.setattr(vlf_tracers, "cpu_seconds", lambda run: next(seconds))
    scene = vc.scenes.cube_on_plane()
    beams = camera_rays(scene.cameras[0], (16, 16))
    best = vlf_tracers.best_bsp(scene, beams, quick=True)
    assert (best.settings.max_depth, best.settings.leaf_size) == (14, 16)  # type: ignore[union-attr]
    assert best.nbytes == best.caster.stats["bytes"]


def test_a_trial_takes_runs_of_neighbours_from_everywhere():
    o = np.arange(30_000, dtype=np.float32).reshape(-1, 3)
    some = Beams(origins=o, directions=o).some(160)
    assert len(some) == 160
    np.testing.assert_array_equal(np.diff(some.origins[:16, 0]), 3)
    assert some.origins[0, 0] == 0 and some.origins[-1, 0] == o[-1, 0]


def test_local_shading_is_direct_light_where_nothing_stands_between():
    d = vc.SceneDescription()
    material = d.add_material(base_color=(0.5, 0.25, 0.75))
    floor = [[-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]]
    d.add_mesh(floor, [[0, 1, 2], [0, 2, 3]], material=material)
    d.add_point_light((0.5, 2, 0.3), (5, 6, 7))
    scene = vc.Scene.from_description(d)
    view = vc.look_at((0, 3, 2), (0, 0, 0), fov_deg=40)
    frame = vc.render(scene, vc.Direct(), size=(16, 12), spp=16, camera=view)
    lights = [light for light in scene.lights if light["kind"] == "point"]
    shaded = local_shading(frame, view, lights)
    np.testing.assert_allclose(shaded, frame.image, rtol=0.02, atol=1e-4)
    lit = SimpleNamespace(layers=frame.layers)
    assert local_shading(lit, view, []).max() == 0


def test_the_object_that_moves_is_closed_and_of_the_size_asked_for():
    for wanted in (100, 1000, 10_000):
        vertices, triangles = ball(wanted, (0, 0, 0))
        assert 0.7 * wanted < len(triangles) < 1.4 * wanted
        np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 0.12)
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        assert (np.linalg.norm(normal, axis=1) > 0).all()
        # Enclosed volume by the divergence theorem: near a ball's, so there is no hole
        volume = abs(np.einsum("nk,nk->n", a, normal).sum()) / 6
        assert volume == pytest.approx(4 / 3 * np.pi * 0.12**3, rel=0.2)


def test_a_table_has_every_column_of_its_rows(tmp_path):
    Trial(folder=tmp_path).csv("a.csv", [{"x": 1, "y": 0.5}, {"x": 2, "z": "a"}])
    assert (tmp_path / "a.csv").read_text() == "x,y,z\n1,0.5,\n2,,a\n"
