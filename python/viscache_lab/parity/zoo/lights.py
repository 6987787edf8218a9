"""Each kind of light and its parameters, over a floor with a cube and a wall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import chain, product

from viscache_lab.parity.zoo.case import DAYLIGHT, FLOOR, Case, area, property_tags, shape
from viscache_lab.parity.zoo.files import PICTURES, SKY_MAP

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
