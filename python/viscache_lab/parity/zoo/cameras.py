"""Each camera and its parameters, before a floor with a picture and a few cubes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain, product
from typing import Any

from viscache_lab.parity.zoo.case import SIDE_PX, SKY, Case, property_tags, shape, view
from viscache_lab.parity.zoo.files import PICTURES
from viscache_lab.parity.zoo.textures import textured

LOOK = '<lookat origin="1,2.5,5" target="0,0.6,0" up="0,1,0"/>'
MIRROR = '<scale x="-1" y="1" z="1"/>'
WIDE, HIGH = (64, 40), (40, 64)


def _stage() -> str:
    picture = textured("bitmap", property_tags({"filename": PICTURES["png"]}))
    floor = shape("rectangle", '<scale value="4"/><rotate x="1" angle="-90"/>', picture)
    cubes = (
        shape("cube", f'<scale value="{size}"/><translate x="{x}" y="{size}" z="{z}"/>')
        for x, z, size in ((-1.2, 0, 0.7), (0.8, -1, 0.5), (1.5, 0.8, 0.3))
    )
    return floor + "".join(cubes)


def _perspective() -> Iterator[tuple[str, str]]:
    for axis, (shown, size) in product(
        ("x", "y", "diagonal", "smaller", "larger"), {"wide": WIDE, "high": HIGH}.items()
    ):
        yield f"fov-{axis}-{shown}", _seen({"fov": 40.0, "fov_axis": axis}, size=size)
    for fov in (10.0, 90.0, 130.0):
        yield f"fov-{fov:g}", _seen({"fov": fov})
    yield "fov-default", _seen({})
    for length in ("35mm", "80mm"):
        yield f"focal-{length}", _seen({"focal_length": length}, size=WIDE)
    for x, y in ((0.2, 0.0), (0.0, 0.2), (-0.1, 0.15)):
        offset = {"fov": 45.0, "principal_point_offset_x": x, "principal_point_offset_y": y}
        yield f"principal-{x:g}-{y:g}", _seen(offset, size=WIDE)
    for name, near, far in (("far-away", 0.1, 100.0), ("near", 4.5, 100.0), ("far", 0.1, 6.0)):
        yield f"clip-{name}", _seen({"fov": 45.0, "near_clip": near, "far_clip": far})


def _others() -> Iterator[tuple[str, str]]:
    for name, steps in {
        "tilted": '<lookat origin="1,2.5,5" target="0,0.6,0" up="1,1,0"/>',
        "mirror-x": MIRROR + LOOK,
        "mirror-y": '<scale x="1" y="-1" z="1"/>' + LOOK,
        "mirror-after": LOOK + MIRROR,
        "rotated": '<rotate x="1" angle="25"/><rotate y="1" angle="180"/>'
        '<translate x="0.5" y="3" z="5"/>',
        "matrix": '<matrix value="-1 0 0 0.5  0 0.9 -0.436 3  0 -0.436 -0.9 5  0 0 0 1"/>',
    }.items():
        yield f"to-world-{name}", view(steps)
    # A crop of the film is the picture; its blocks are those of the crop
    for x, y, w, h in ((0, 0, 32, 32), (16, 8, 40, 48), (32, 32, 32, 32)):
        crop = {"crop_offset_x": x, "crop_offset_y": y, "crop_width": w, "crop_height": h}
        yield f"crop-{x}-{y}-{w}-{h}", view(LOOK, film=property_tags(crop))
    square = (SIDE_PX, SIDE_PX)
    for name, steps, size in (
        ("scale2", '<scale value="2"/>', square),
        ("scale3", '<scale value="3"/>', square),
        ("stretched", '<scale x="3" y="2" z="1"/>', square),
        ("mirrored", '<scale x="-2" y="2" z="1"/>', square),
        ("wide", '<scale value="2"/>', WIDE),
        ("high", '<scale value="2"/>', HIGH),
    ):
        seen = view(steps + LOOK, more="", kind="orthographic", size=size)
        yield f"orthographic-{name}", seen
    lens = {"fov": 45.0, "aperture_radius": 0.2, "focus_distance": 5.0}
    yield "thinlens", _seen(lens, kind="thinlens")


def _seen(values: Mapping[str, object], **more: Any) -> str:
    """A camera with properties."""
    return view(LOOK, more=property_tags(values), **more)


QUICK = {
    "fov-y-wide",
    "fov-larger-high",
    "principal-0.2-0",
    "to-world-mirror-x",
    "crop-16-8-40-48",
    "orthographic-scale3",
}


def camera_cases() -> Iterator[Case]:
    """The cases."""
    stage = _stage()
    for name, camera in chain(_perspective(), _others()):
        yield Case(
            name=f"camera/{name}",
            body="",
            camera=camera,
            stage=stage,
            lights=SKY,
            quick=name in QUICK,
        )
