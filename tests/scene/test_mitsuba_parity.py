"""Files that Mitsuba 3 and viscache load and render alike, by blocks of pixels and by energy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import viscache as vc

mi: Any = pytest.importorskip("mitsuba", reason="needs the package mitsuba")

BLOCK, FRAMES, SPP = 16, 4, 32
VIEW = """<sensor type="perspective"><float name="fov" value="50"/>
<transform name="to_world"><lookat origin="0,3,6" target="0,0.5,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/>
<rfilter type="box"/></film></sensor>"""
FLOOR = """<shape type="rectangle"><transform name="to_world"><scale value="5"/>
<rotate x="1" angle="-90"/></transform><bsdf type="diffuse"/></shape>"""
LAMP = '<emitter type="area"><rgb name="radiance" value="5,4,3"/></emitter>'
#: A slanted lamp above the floor, whose front is seen by the floor or not.
PLACED = """<transform name="to_world">{mirror}<scale value="0.6"/>
<rotate x="1" angle="{angle}"/><translate y="2"/></transform>"""
MIRROR = '<scale x="-1" y="1" z="1"/>'


def write(folder: Path, body: str) -> Path:
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{VIEW}{FLOOR}{body}</scene>')
    return path


def of_viscache(path: Path) -> Any:
    scene = vc.load_scene(path)
    return [vc.render(scene, vc.Direct(), spp=SPP, seed=s).image for s in range(FRAMES)]


def of_mitsuba(path: Path) -> Any:
    mi.set_variant("scalar_rgb")
    scene, direct = mi.load_file(str(path)), mi.load_dict({"type": "direct"})
    return [np.array(mi.render(scene, integrator=direct, spp=SPP, seed=s)) for s in range(FRAMES)]


def blocks(frames: Any) -> Any:
    """Means of blocks (frames, rows, columns, 3)."""
    a = np.asarray(frames, np.float64)
    n, height, width, _ = a.shape
    return a.reshape(n, height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((2, 4))


def agreement(ours: Any, theirs: Any) -> float:
    """Share of the blocks within 3σ + 1 %."""
    mine, other = blocks(ours), blocks(theirs)
    sigma = np.sqrt((mine.var(0, ddof=1) + other.var(0, ddof=1)) / FRAMES)
    a, b = mine.mean(0), other.mean(0)
    return float(np.mean(np.abs(a - b) <= 3 * sigma + 0.01 * np.maximum(b, 1e-4)))


@pytest.mark.slow
@pytest.mark.parametrize("angle", [60, -120], ids=["front down", "front up"])
@pytest.mark.parametrize("mirror", ["", MIRROR], ids=["plain", "mirrored"])
@pytest.mark.parametrize("shape", ["rectangle", "cube", "disk", "sphere"])
def test_a_lamp_shines_to_the_side_of_mitsuba(
    tmp_path: Path, shape: str, mirror: str, angle: float
) -> None:
    place = PLACED.format(mirror=mirror, angle=angle)
    path = write(tmp_path, f'<shape type="{shape}">{place}{LAMP}</shape>')
    ours, theirs = of_viscache(path), of_mitsuba(path)
    assert agreement(ours, theirs) >= 0.95
    light, expected = np.mean(ours), np.mean(theirs)
    assert light == pytest.approx(expected, rel=0.01, abs=1e-6)
    # Power: the other side, or 3 % more light, would be noticed
    if expected > 1e-3:
        assert agreement(np.multiply(ours, 1.05), theirs) < 0.9
        assert agreement(np.multiply(ours, 0), theirs) < 0.5


SPOT = """<emitter type="spot"><transform name="to_world"><scale value="2"/>
<lookat origin="-2,4,1" target="0.5,0,0" up="0,1,0"/></transform>
<rgb name="intensity" value="30,20,10"/>{angles}</emitter>"""
BOX = """<shape type="cube"><transform name="to_world"><scale value="0.5"/>
<translate x="0.3" y="0.5"/></transform></shape>"""


@pytest.mark.parametrize(
    "angles",
    [
        "",
        '<float name="cutoff_angle" value="35"/>',
        '<float name="cutoff_angle" value="30"/><float name="beam_width" value="5"/>',
        '<float name="cutoff_angle" value="25"/><float name="beam_width" value="25"/>',
    ],
    ids=["default", "wide", "soft", "hard"],
)
def test_a_spot_light_shines_as_mitsubas(tmp_path: Path, angles: str) -> None:
    path = write(tmp_path, BOX + SPOT.format(angles=angles))
    ours, theirs = of_viscache(path), of_mitsuba(path)
    assert not vc.load_scene(path).warnings
    assert agreement(ours, theirs) >= 0.95
    assert np.mean(ours) == pytest.approx(np.mean(theirs), rel=0.005)
    # Power: 5 % more light, and a light without a cone, would be noticed
    assert agreement(np.multiply(ours, 1.05), theirs) < 0.9
    point = SPOT.format(angles="").replace("spot", "point")
    assert agreement(of_viscache(write(tmp_path, BOX + point)), theirs) < 0.7


@pytest.mark.parametrize("mirror", ["", MIRROR], ids=["plain", "mirrored"])
@pytest.mark.parametrize("normals", [False, True], ids=["winding", "normals"])
def test_a_mesh_shines_to_the_side_of_mitsuba(tmp_path: Path, normals: bool, mirror: str) -> None:
    corners = ["-1 -1 0", "1 -1 0", "1 1 0", "-1 1 0"]
    names = "xyz" if not normals else ["x", "y", "z", "nx", "ny", "nz"]
    head = [f"property float {n}" for n in names]
    rows = [c + " 0 0 1" if normals else c for c in corners]
    faces = ["element face 2", "property list uchar int vertex_indices", "end_header"]
    lines = ["ply", "format ascii 1.0", "element vertex 4", *head, *faces, *rows]
    (tmp_path / "lamp.ply").write_text("\n".join([*lines, "3 0 1 2", "3 0 2 3", ""]))
    place = PLACED.format(mirror=mirror, angle=60)
    lamp = f'<shape type="ply"><string name="filename" value="lamp.ply"/>{place}{LAMP}</shape>'
    path = write(tmp_path, lamp)
    assert agreement(of_viscache(path), of_mitsuba(path)) >= 0.95
