"""scene/scene.h, solid_at: opacity, constant or of an image, is a fixed pattern of holes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from core import testing
from scene import test_mitsuba_parity as parity

BODY = """<shape type="rectangle"><transform name="to_world"><scale value="1.5"/>
<rotate x="1" angle="-20"/><translate y="1"/></transform><bsdf type="mask">
<float name="opacity" value="{opacity}"/><bsdf type="twosided"><bsdf type="diffuse">
<rgb name="reflectance" value="0.8,0.5,0.2"/></bsdf></bsdf></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.7"/>
<rotate x="1" angle="100"/><translate y="3" z="1"/></transform>
<emitter type="area"><rgb name="radiance" value="6,5,4"/></emitter></shape>
<emitter type="constant"><rgb name="radiance" value="0.3,0.4,0.5"/></emitter>"""


def veils(opacity: float, n: int = 40) -> vc.Scene:
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


def chords(n: int) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    random = np.random.default_rng(4)
    ends = random.normal(size=(2, n, 3))
    ends *= 4 / np.linalg.norm(ends, axis=2, keepdims=True)
    ends[1] = random.uniform(-1, 1, (n, 3))
    d = ends[1] - ends[0]
    return ends[0].astype(np.float32), (d / np.linalg.norm(d, axis=1, keepdims=True)).astype(
        np.float32
    )


def solid(scene: vc.Scene, uv: npt.NDArray[np.float32], triangle: int = 0) -> npt.NDArray[Any]:
    n = len(uv)
    zeros = np.zeros(n, np.int64)
    return testing.solid_at(scene._core, zeros, zeros + triangle, uv)


@pytest.mark.parametrize("opacity", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_the_solid_share_is_the_opacity(opacity: float) -> None:
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
def test_every_caster_sees_the_same_holes(rays: Any) -> None:
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


def frames(path: Path, **settings: Any) -> Any:
    scene = vc.load_scene(path)
    assert not scene.warnings
    return [vc.render(scene, vc.Direct(), spp=32, seed=s, **settings).image for s in range(4)]


def write(folder: Path, opacity: float) -> Path:
    path = folder / "scene.xml"
    body = parity.FLOOR + BODY.format(opacity=opacity)
    path.write_text(f'<scene version="3.0.0">{parity.VIEW}{body}</scene>')
    return path


def test_greys_of_an_image_are_shares_if_the_cutoff_is_negative() -> None:
    def plate(cutoff: float, opacity: float = 1) -> vc.Scene:
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

    def shares(scene: vc.Scene) -> list[float]:
        stopped = ~scene.visible(a, b)
        return [float(stopped[~right].mean()), float(stopped[right].mean())]

    assert shares(plate(-1)) == pytest.approx([0.2, 0.7], abs=0.015)
    assert shares(plate(-1, 0.5)) == pytest.approx([0.1, 0.35], abs=0.015)
    # Power: a cut-out has no share between
    assert shares(plate(0.5)) == [0, 1]
    assert plate(-1).geometry_hash != plate(0.5).geometry_hash


@pytest.mark.mitsuba
@pytest.mark.slow
def test_greys_of_opacity_let_through_what_mitsubas_do(tmp_path: Path) -> None:
    from PIL import Image

    greys = np.uint8([[20, 90, 200, 255], [160, 120, 60, 230]]).repeat(4, 0).repeat(4, 1)
    Image.fromarray(greys).save(tmp_path / "greys.png")
    picture = """<texture type="bitmap" name="opacity"><string name="filename" value="greys.png"/>
    <boolean name="raw" value="true"/></texture>"""
    path = write(tmp_path, 0.5)
    path.write_text(path.read_text().replace('<float name="opacity" value="0.5"/>', picture))
    assert not vc.load_scene(path).warnings
    parity.mi.set_variant("scalar_rgb")
    scene = parity.mi.load_file(str(path))
    direct = parity.mi.load_dict({"type": "volpath", "max_depth": 2})
    theirs = [
        np.array(parity.mi.render(scene, integrator=direct, spp=64, seed=s)) for s in range(4)
    ]
    assert parity.agreement(frames(path), theirs) >= 0.95
    # Power: as a cut-out, or of one grey
    for other in (greys // 128 * 255, np.full_like(greys, greys.mean())):
        Image.fromarray(other).save(tmp_path / "greys.png")
        assert parity.agreement(frames(path), theirs) < 0.9


@pytest.mark.mitsuba
@pytest.mark.slow
@pytest.mark.parametrize("opacity", [pytest.param(0.2, marks=pytest.mark.release), 0.7])
def test_holes_let_through_what_mitsubas_mask_does(tmp_path: Path, opacity: float) -> None:
    """Mitsuba's `volpath` sees lights through a mask; for `path` it is a wall."""
    path = write(tmp_path, opacity)
    parity.mi.set_variant("scalar_rgb")
    scene = parity.mi.load_file(str(path))
    direct = parity.mi.load_dict({"type": "volpath", "max_depth": 2})
    theirs = [
        np.array(parity.mi.render(scene, integrator=direct, spp=64, seed=s)) for s in range(4)
    ]
    ours = frames(path)
    assert parity.agreement(ours, theirs) >= 0.95
    assert np.mean(ours) == pytest.approx(np.mean(theirs), rel=0.01)
    other = frames(write(tmp_path, opacity + 0.05))
    assert parity.agreement(other, theirs) < 0.9
