"""scene/scene.h, solid_at: opacity, constant or of an image, is a fixed pattern of holes."""

import numpy as np
import pytest

import viscache as vc
from core import testing


def veils(opacity, n=40):
    """Triangles without order, placed twice, one of them mirrored."""
    random = np.random.default_rng(3)
    d = vc.SceneDescription()
    material = d.add_material(opacity=opacity)
    vertices = random.uniform(-1, 1, (n, 1, 3)) + random.normal(0, 0.4, (n, 3, 3))
    triangles = np.arange(3 * n).reshape(-1, 3)
    mesh = d.add_mesh(vertices.reshape(-1, 3), triangles, material=material, in_world=False)
    d.add_mesh(vertices.reshape(-1, 3) * 0.5, triangles, material=material)
    d.add_instance([mesh], [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]])
    d.add_instance([mesh], [[-1.2, 0, 0, 1], [0, 1.2, 0, 0], [0, 0, 1.2, 0.5]])
    return vc.Scene.from_description(d)


def chords(n):
    random = np.random.default_rng(4)
    ends = random.normal(size=(2, n, 3))
    ends *= 4 / np.linalg.norm(ends, axis=2, keepdims=True)
    ends[1] = random.uniform(-1, 1, (n, 3))
    d = ends[1] - ends[0]
    return ends[0].astype(np.float32), (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(
        np.float32
    )


def solid(scene, uv, triangle=0):
    n = len(uv)
    zeros = np.zeros(n, np.int64)
    return testing.solid_at(scene._core, zeros, zeros + triangle, uv)


@pytest.mark.parametrize("opacity", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_the_solid_share_is_the_opacity(opacity):
    u = np.random.default_rng(1).random((100_000, 2)).astype(np.float32)
    u = np.where(u.sum(1, keepdims=True) > 1, 1 - u, u)
    there = solid(veils(opacity), u)
    sigma = np.sqrt(opacity * (1 - opacity) / len(u))
    assert abs(there.mean() - opacity) <= 4 * sigma
    # Neither two triangles nor neighbouring cells have the same holes
    assert np.mean(solid(veils(opacity), u, 1) == there) == pytest.approx(
        opacity**2 + (1 - opacity) ** 2, abs=0.02
    )
    moved = u + np.float32([1 / 4096, 0])
    assert np.mean(solid(veils(opacity), moved) == there) == pytest.approx(
        opacity**2 + (1 - opacity) ** 2, abs=0.02
    )


@pytest.mark.parametrize(
    "rays", [vc.Bsp(), vc.Vlf(n_directions=513)], ids=["bsp", "visibility field"]
)
def test_every_caster_sees_the_same_holes(rays):
    """Up to rays that pass the border of a hole within rounding: 0.12 % here."""
    scene = veils(0.4)
    start, d = chords(20_000)
    ours, theirs = scene.intersect(start, d, rays=rays), scene.intersect(start, d)
    same = (ours.triangle == theirs.triangle) & (ours.instance == theirs.instance)
    assert 0.3 < np.mean(theirs.triangle >= 0) < 0.97
    assert np.mean(~same) < 0.003
    np.testing.assert_array_equal(scene.occluded(start, d), theirs.triangle >= 0)
    # Power: with other holes, many rays end elsewhere
    other = veils(0.41).intersect(start, d)
    assert np.mean(other.triangle != theirs.triangle) > 0.01


def test_greys_of_an_image_are_shares_if_the_cutoff_is_negative():
    def plate(cutoff, opacity=1):
        d = vc.SceneDescription()
        greys = d.add_image(np.float32([[[0.2], [0.7]]]), nearest=True)
        material = d.add_material(alpha_texture=greys, alpha_cutoff=cutoff, opacity=opacity)
        corners = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
        faces = np.uint32([[0, 1, 2], [0, 2, 3]])
        d.add_mesh(corners, faces, material=material, uvs=corners[:, :2])
        return vc.Scene.from_description(d)

    a = np.random.default_rng(2).random((40_000, 3)).astype(np.float32)
    a[:, 2] = 1
    b = a * np.float32([1, 1, -1])
    right = a[:, 0] > 0.5

    def shares(scene):
        stopped = ~scene.visible(a, b)
        return [float(stopped[~right].mean()), float(stopped[right].mean())]

    assert shares(plate(-1)) == pytest.approx([0.2, 0.7], abs=0.015)
    assert shares(plate(-1, 0.5)) == pytest.approx([0.1, 0.35], abs=0.015)
    # Power: a cut-out has no share between
    assert shares(plate(0.5)) == [0, 1]
    assert plate(-1).geometry_hash != plate(0.5).geometry_hash
