"""Each light over a floor with a cube and a wall, and each camera before a few cubes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import chain, product
from typing import Any

from viscache_lab.parity.zoo.case import (
    DAYLIGHT,
    FLOOR,
    SIDE_PX,
    SKY,
    Case,
    area,
    property_tags,
    shape,
    view,
)
from viscache_lab.parity.zoo.files import PICTURES, SKY_MAP
from viscache_lab.parity.zoo.surfaces import textured

STAGE = (
    FLOOR
    + shape("cube", '<scale value="0.6"/><rotate y="1" angle="30"/><translate y="0.6"/>')
    + shape("rectangle", '<scale value="4"/><translate z="-3"/>')
)


def emitter(kind: str, inside: str) -> str:
    """A light."""
    return f'<emitter type="{kind}">{inside}</emitter>'


def placed(steps: str) -> str:
    """A light's transform."""
    return f'<transform name="to_world">{steps}</transform>'


LOOK = '<lookat origin="1,4,2" target="0,0,0" up="0,1,0"/>'
HALF_TURN = '<rotate x="1" angle="120"/>'
POINTS = {
    "position": '<point name="position" x="1" y="3" z="1"/>',
    "to-world": placed('<rotate y="1" angle="20"/><translate x="-1" y="2" z="1.5"/>'),
    "scaled": placed('<scale value="3"/><translate y="3"/>'),
}
DIRECTIONS = {
    "direction": '<vector name="direction" x="0.5" y="-1" z="-0.4"/>',
    "long": '<vector name="direction" x="5" y="-10" z="-4"/>',
    "to-world": placed(HALF_TURN),
    "lookat": placed('<lookat origin="2,3,1" target="0,0,0" up="0,1,0"/>'),
    "scaled": placed('<scale value="4"/>' + HALF_TURN),
}
#: Turns of an environment.
TURNS = {
    "x90": '<rotate x="1" angle="90"/>',
    "y90": '<rotate y="1" angle="90"/>',
    "y200": '<rotate y="1" angle="200"/>',
    "z45": '<rotate z="1" angle="45"/>',
    "mixed": '<rotate x="0.36" y="0.48" z="0.8" angle="77"/>',
    "mirror-x": '<scale x="-1" y="1" z="1"/>',
    "mirror-y": '<scale x="1" y="-1" z="1"/>',
    "mirror-z": '<scale x="1" y="1" z="-1"/>',
    "lookat": '<lookat origin="0,0,0" target="1,0,1" up="0,1,0"/>',
}


def _bare() -> Iterator[tuple[str, str]]:
    """Lights without a surface."""
    bright = property_tags({"intensity": (20.0, 15.0, 10.0)})
    for name, where in POINTS.items():
        yield f"point-{name}", emitter("point", where + bright)
    above = placed('<translate y="2"/>')
    yield "point-default", emitter("point", above)
    yield "point-uniform", emitter("point", above + '<spectrum name="intensity" value="12"/>')
    three = (emitter("point", placed(f'<translate x="{x}" y="2"/>') + bright) for x in (-2, 0, 2))
    yield "point-three", "".join(three)
    bright = property_tags({"intensity": (60.0, 50.0, 40.0)})
    yield "spot-default", emitter("spot", placed(LOOK) + bright)
    for cutoff, beam in ((15.0, 10.0), (30.0, 5.0), (50.0, 45.0), (20.0, 20.0)):
        cone = property_tags({"cutoff_angle": cutoff, "beam_width": beam})
        yield f"spot-{cutoff:g}-{beam:g}", emitter("spot", placed(LOOK) + bright + cone)
    yield "spot-mirrored", emitter("spot", placed(TURNS["mirror-x"] + LOOK) + bright)
    bright = property_tags({"irradiance": (3.0, 2.5, 2.0)})
    for name, where in DIRECTIONS.items():
        yield f"directional-{name}", emitter("directional", where + bright)


def _skies() -> Iterator[tuple[str, str]]:
    yield "constant-default", emitter("constant", "")
    yield "constant-colour", emitter("constant", property_tags({"radiance": (0.9, 0.6, 0.3)}))
    yield "constant-uniform", emitter("constant", '<spectrum name="radiance" value="0.7"/>')
    rows: list[tuple[str, Mapping[str, object], str]] = [
        *((kind, {"filename": f"{SKY_MAP}.{kind}"}, "") for kind in ("exr", "hdr", "png")),
        ("few-rows", {"filename": PICTURES["png"]}, ""),
        ("scale", {"filename": f"{SKY_MAP}.exr", "scale": 2.5}, ""),
        *((name, {"filename": f"{SKY_MAP}.exr"}, placed(turn)) for name, turn in TURNS.items()),
    ]
    for name, values, where in rows:
        yield f"envmap-{name}", emitter("envmap", property_tags(values) + where)
    yield "sunsky-default", emitter("sunsky", property_tags({"sun_scale": 0.2}))
    yield "sunsky-sky-alone", emitter("sunsky", property_tags({"sun_scale": 0.0, "turbidity": 4.0}))


def _areas() -> Iterator[tuple[str, str]]:
    down = '<rotate x="1" angle="90"/><translate y="3"/>'
    # Under a sky that is as bright as the lamp, which looks at the camera
    seen = '<rotate x="1" angle="-20"/><translate y="1.5"/>'
    small, strip = f'<scale value="0.05"/>{down}', f'<scale value="0.2"/>{down}'
    wide = '<scale value="6"/><rotate x="1" angle="90"/><translate y="5"/>'
    two_sided = '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>'
    file = property_tags({"filename": PICTURES["exr"]})
    texture = f'<texture type="bitmap" name="radiance">{file}</texture>'
    default, picture = '<emitter type="area"/>', emitter("area", texture)
    lamp = partial(shape, "rectangle")
    many = (
        lamp(f'{strip}<translate x="{x}" z="{z}"/>', area("20,18,16"))
        for x, z in product((-3, -1, 1, 3), (-2, 0, 2))
    )
    ball = shape("sphere", '<scale value="0.3"/><translate x="1" y="2.5" z="1"/>', area("20,15,10"))
    yield from {
        "area-default": lamp(down, default),
        "area-default-surface": emitter("constant", "") + lamp(seen, default),
        "area-uniform": lamp(down, emitter("area", '<spectrum name="radiance" value="4"/>')),
        "area-small": lamp(small, area("1500,1200,900")),
        "area-wide": lamp(wide, area("0.5,0.4,0.3")),
        "area-twosided": lamp(down, area("3,3,3") + two_sided),
        "area-picture": lamp(down, picture),
        "area-picture-disk": shape("disk", down, picture),
        "area-picture-sphere": shape("sphere", down, picture),
        "area-many": "".join(many),
        "area-two-shapes": ball + lamp(small, area("300,300,900")),
    }.items()


#: Lights of the quick suite.
QUICK = {
    "point-to-world",
    "spot-30-5",
    "directional-direction",
    "constant-colour",
    "envmap-mixed",
    "area-small",
    "area-picture",
    "sunsky-default",
}


def light_cases() -> Iterator[Case]:
    """The cases."""
    # Daylight and a lamp: three kinds of light in one scene
    dim = placed('<translate y="2"/>') + property_tags({"intensity": (9.0, 3.0, 3.0)})
    mixed = "mixed", DAYLIGHT + emitter("point", dim)
    for name, light in chain(_bare(), _skies(), _areas(), [mixed]):
        yield Case(name=f"light/{name}", body="", stage=STAGE, lights=light, quick=name in QUICK)


FRONT = '<lookat origin="1,2.5,5" target="0,0.6,0" up="0,1,0"/>'
MIRROR = '<scale x="-1" y="1" z="1"/>'
WIDE, HIGH = (64, 40), (40, 64)


def _cubes() -> str:
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


def _placed() -> Iterator[tuple[str, str]]:
    for name, steps in {
        "tilted": '<lookat origin="1,2.5,5" target="0,0.6,0" up="1,1,0"/>',
        "mirror-x": MIRROR + FRONT,
        "mirror-y": '<scale x="1" y="-1" z="1"/>' + FRONT,
        "mirror-after": FRONT + MIRROR,
        "rotated": '<rotate x="1" angle="25"/><rotate y="1" angle="180"/>'
        '<translate x="0.5" y="3" z="5"/>',
        "matrix": '<matrix value="-1 0 0 0.5  0 0.9 -0.436 3  0 -0.436 -0.9 5  0 0 0 1"/>',
    }.items():
        yield f"to-world-{name}", view(steps)
    # A crop of the film is the picture; its blocks are those of the crop
    for x, y, w, h in ((0, 0, 32, 32), (16, 8, 40, 48), (32, 32, 32, 32)):
        crop = {"crop_offset_x": x, "crop_offset_y": y, "crop_width": w, "crop_height": h}
        yield f"crop-{x}-{y}-{w}-{h}", view(FRONT, film=property_tags(crop))
    square = (SIDE_PX, SIDE_PX)
    for name, steps, size in (
        ("scale2", '<scale value="2"/>', square),
        ("scale3", '<scale value="3"/>', square),
        ("stretched", '<scale x="3" y="2" z="1"/>', square),
        ("mirrored", '<scale x="-2" y="2" z="1"/>', square),
        ("wide", '<scale value="2"/>', WIDE),
        ("high", '<scale value="2"/>', HIGH),
    ):
        seen = view(steps + FRONT, more="", kind="orthographic", size=size)
        yield f"orthographic-{name}", seen
    lens = {"fov": 45.0, "aperture_radius": 0.2, "focus_distance": 5.0}
    yield "thinlens", _seen(lens, kind="thinlens")


def _seen(values: Mapping[str, object], **more: Any) -> str:
    """A camera with properties."""
    return view(FRONT, more=property_tags(values), **more)


QUICK_CAMERAS = {
    "fov-y-wide",
    "fov-larger-high",
    "principal-0.2-0",
    "to-world-mirror-x",
    "crop-16-8-40-48",
    "orthographic-scale3",
}


def camera_cases() -> Iterator[Case]:
    """The cases."""
    stage = _cubes()
    for name, camera in chain(_perspective(), _placed()):
        yield Case(
            name=f"camera/{name}",
            body="",
            camera=camera,
            stage=stage,
            lights=SKY,
            quick=name in QUICK_CAMERAS,
        )
