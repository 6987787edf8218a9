"""Each camera and its parameters, before a floor with a picture and a few cubes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from viscache_lab.parity.zoo.case import SKY, Case, property_tags, shape, view
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
    for axis, size in product(("x", "y", "diagonal", "smaller", "larger"), (WIDE, HIGH)):
        values = property_tags({"fov": 40.0, "fov_axis": axis})
        shown = "wide" if size == WIDE else "high"
        yield f"fov-{axis}-{shown}", view(LOOK, more=values, size=size)
    for fov in (10.0, 90.0, 130.0):
        yield f"fov-{fov:g}", view(LOOK, more=property_tags({"fov": fov}))
    yield "fov-default", view(LOOK, more="")
    for length in ("35mm", "80mm"):
        more = property_tags({"focal_length": length})
        yield f"focal-{length}", view(LOOK, more=more, size=WIDE)
    for x, y in ((0.2, 0.0), (0.0, 0.2), (-0.1, 0.15)):
        offset = {"fov": 45.0, "principal_point_offset_x": x, "principal_point_offset_y": y}
        yield f"principal-{x:g}-{y:g}", view(LOOK, more=property_tags(offset), size=WIDE)
    near = {"fov": 45.0, "near_clip": 0.1, "far_clip": 100.0}
    yield "clip-far-away", view(LOOK, more=property_tags(near))
    cut = {"fov": 45.0, "near_clip": 4.5, "far_clip": 100.0}
    yield "clip-near", view(LOOK, more=property_tags(cut))
    cut = {"fov": 45.0, "near_clip": 0.1, "far_clip": 6.0}
    yield "clip-far", view(LOOK, more=property_tags(cut))


def _placed() -> Iterator[tuple[str, str]]:
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


def _crops() -> Iterator[tuple[str, str]]:
    # A crop of the film is the picture; its blocks are those of the crop
    for x, y, w, h in ((0, 0, 32, 32), (16, 8, 40, 48), (32, 32, 32, 32)):
        crop = {"crop_offset_x": x, "crop_offset_y": y, "crop_width": w, "crop_height": h}
        yield f"crop-{x}-{y}-{w}-{h}", view(LOOK, film=property_tags(crop))


def _orthographic() -> Iterator[tuple[str, str]]:
    for name, steps in {
        "scale2": '<scale value="2"/>',
        "scale3": '<scale value="3"/>',
        "stretched": '<scale x="3" y="2" z="1"/>',
        "mirrored": '<scale x="-2" y="2" z="1"/>',
    }.items():
        yield f"orthographic-{name}", view(steps + LOOK, more="", kind="orthographic")
    wide = view('<scale value="2"/>' + LOOK, more="", kind="orthographic", size=WIDE)
    yield "orthographic-wide", wide
    high = view('<scale value="2"/>' + LOOK, more="", kind="orthographic", size=HIGH)
    yield "orthographic-high", high


def _lenses() -> Iterator[tuple[str, str]]:
    sharp = property_tags({"fov": 45.0, "aperture_radius": 0.2, "focus_distance": 5.0})
    yield "thinlens", view(LOOK, more=sharp, kind="thinlens")


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
    for maker in (_perspective, _placed, _crops, _orthographic, _lenses):
        for name, camera in maker():
            yield Case(
                name=f"camera/{name}",
                body="",
                camera=camera,
                stage=stage,
                lights=SKY,
                quick=name in QUICK,
            )
