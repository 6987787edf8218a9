"""Plastics that Mitsuba 3 and viscache render alike, by blocks of pixels and by energy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import viscache as vc
from scene.test_mitsuba_parity import VIEW, agreement, mi, of_mitsuba, of_viscache

PLANE = """<shape type="rectangle"><transform name="to_world"><scale value="5"/>
<rotate x="1" angle="-90"/></transform>{bsdf}</shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.7"/>
<rotate x="1" angle="100"/><translate y="2" z="-2"/></transform>
<emitter type="area"><rgb name="radiance" value="6,5,4"/></emitter></shape>
<emitter type="constant"><rgb name="radiance" value="0.6,0.7,0.8"/></emitter>"""
COLOUR = '<rgb name="diffuse_reflectance" value="0.2,0.5,0.8"/>'
IMAGE = """<texture name="diffuse_reflectance" type="bitmap">
<string name="filename" value="image.png"/></texture>"""
KINDS = {
    "plastic": "",
    "roughplastic": '<float name="alpha" value="0.25"/><string name="distribution" value="ggx"/>',
}


def write(folder: Path, kind: str, nonlinear: bool, colour: str) -> Path:
    bsdf = f"""<bsdf type="{kind}"><boolean name="nonlinear" value="{str(nonlinear).lower()}"/>
    {KINDS[kind]}{colour}</bsdf>"""
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">{VIEW}{PLANE.format(bsdf=bsdf)}</scene>')
    return path


def write_image(folder: Path) -> None:
    """A smooth wave of colours."""
    x, y = np.meshgrid(np.arange(32), np.arange(32))
    wave = np.stack([np.sin(x / 5 + c) * np.cos(y / 5 - c) for c in range(3)], -1)
    mi.set_variant("scalar_rgb")
    mi.Bitmap(np.uint8(127 + 120 * wave)).write(str(folder / "image.png"))


@pytest.mark.slow
@pytest.mark.mitsuba
@pytest.mark.parametrize(
    "colour",
    [
        pytest.param(COLOUR, marks=pytest.mark.release, id="colour"),
        pytest.param(IMAGE, id="image"),
    ],
)
@pytest.mark.parametrize(
    "nonlinear",
    [
        pytest.param(False, marks=pytest.mark.release, id="linear"),
        pytest.param(True, id="nonlinear"),
    ],
)
@pytest.mark.parametrize("kind", KINDS)
def test_a_plastic_looks_as_in_mitsuba(
    tmp_path: Path, kind: str, nonlinear: bool, colour: str
) -> None:
    write_image(tmp_path)
    path = write(tmp_path, kind, nonlinear, colour)
    assert not vc.load_scene(path).warnings
    ours, theirs = of_viscache(path), of_mitsuba(path)
    assert agreement(ours, theirs) >= 0.95
    assert np.mean(ours, (0, 1, 2)) == pytest.approx(np.mean(theirs, (0, 1, 2)), rel=0.01)
    # Power: 3 % more light, or the other law of colours
    assert agreement(np.multiply(ours, 1.05), theirs) < 0.9
    other: Any = of_viscache(write(tmp_path, kind, not nonlinear, colour))
    assert agreement(other, theirs) < 0.9
