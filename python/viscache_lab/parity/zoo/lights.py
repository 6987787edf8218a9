"""Each kind of light and its parameters, over a floor with a cube and a wall."""

from __future__ import annotations

from collections.abc import Iterator

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


def _points() -> Iterator[tuple[str, str]]:
    bright = property_tags({"intensity": (20.0, 15.0, 10.0)})
    for name, where in {
        "position": '<point name="position" x="1" y="3" z="1"/>',
        "to-world": placed('<rotate y="1" angle="20"/><translate x="-1" y="2" z="1.5"/>'),
        "scaled": placed('<scale value="3"/><translate y="3"/>'),
    }.items():
        yield f"point-{name}", emitter("point", where + bright)
    yield "point-default", emitter("point", placed('<translate y="2"/>'))
    uniform = '<spectrum name="intensity" value="12"/>'
    yield "point-uniform", emitter("point", placed('<translate y="2"/>') + uniform)
    three = (emitter("point", placed(f'<translate x="{x}" y="2"/>') + bright) for x in (-2, 0, 2))
    yield "point-three", "".join(three)


def _spots() -> Iterator[tuple[str, str]]:
    look = '<lookat origin="1,4,2" target="0,0,0" up="0,1,0"/>'
    at = placed(look)
    bright = property_tags({"intensity": (60.0, 50.0, 40.0)})
    yield "spot-default", emitter("spot", at + bright)
    for cutoff, beam in ((15.0, 10.0), (30.0, 5.0), (50.0, 45.0), (20.0, 20.0)):
        cone = property_tags({"cutoff_angle": cutoff, "beam_width": beam})
        yield f"spot-{cutoff:g}-{beam:g}", emitter("spot", at + bright + cone)
    mirrored = placed(
        '<scale x="-1" y="1" z="1"/><lookat origin="1,4,2" target="0,0,0" up="0,1,0"/>'
    )
    yield "spot-mirrored", emitter("spot", mirrored + bright)


def _directional() -> Iterator[tuple[str, str]]:
    bright = property_tags({"irradiance": (3.0, 2.5, 2.0)})
    for name, where in {
        "direction": '<vector name="direction" x="0.5" y="-1" z="-0.4"/>',
        "long": '<vector name="direction" x="5" y="-10" z="-4"/>',
        "to-world": placed('<rotate x="1" angle="120"/>'),
        "lookat": placed('<lookat origin="2,3,1" target="0,0,0" up="0,1,0"/>'),
        "scaled": placed('<scale value="4"/><rotate x="1" angle="120"/>'),
    }.items():
        yield f"directional-{name}", emitter("directional", where + bright)


def _skies() -> Iterator[tuple[str, str]]:
    yield "constant-default", emitter("constant", "")
    yield "constant-colour", emitter("constant", property_tags({"radiance": (0.9, 0.6, 0.3)}))
    yield "constant-uniform", emitter("constant", '<spectrum name="radiance" value="0.7"/>')
    for kind in ("exr", "hdr", "png"):
        yield f"envmap-{kind}", emitter("envmap", property_tags({"filename": f"{SKY_MAP}.{kind}"}))
    yield "envmap-few-rows", emitter("envmap", property_tags({"filename": PICTURES["png"]}))
    scaled = property_tags({"filename": f"{SKY_MAP}.exr", "scale": 2.5})
    yield "envmap-scale", emitter("envmap", scaled)
    for name, steps in {
        "x90": '<rotate x="1" angle="90"/>',
        "y90": '<rotate y="1" angle="90"/>',
        "y200": '<rotate y="1" angle="200"/>',
        "z45": '<rotate z="1" angle="45"/>',
        "mixed": '<rotate x="0.36" y="0.48" z="0.8" angle="77"/>',
        "mirror-x": '<scale x="-1" y="1" z="1"/>',
        "mirror-y": '<scale x="1" y="-1" z="1"/>',
        "mirror-z": '<scale x="1" y="1" z="-1"/>',
        "lookat": '<lookat origin="0,0,0" target="1,0,1" up="0,1,0"/>',
    }.items():
        values = property_tags({"filename": f"{SKY_MAP}.exr"})
        yield f"envmap-{name}", emitter("envmap", values + placed(steps))
    yield "sunsky-default", emitter("sunsky", property_tags({"sun_scale": 0.2}))
    yield "sunsky-sky-alone", emitter("sunsky", property_tags({"sun_scale": 0.0, "turbidity": 4.0}))


def _areas() -> Iterator[tuple[str, str]]:
    down = '<rotate x="1" angle="90"/><translate y="3"/>'
    yield "area-default", shape("rectangle", down, '<emitter type="area"/>')
    # Under a sky that is as bright as the lamp, which looks at the camera
    seen = '<rotate x="1" angle="-20"/><translate y="1.5"/>'
    bright = emitter("constant", "")
    yield "area-default-surface", bright + shape("rectangle", seen, '<emitter type="area"/>')
    uniform = '<emitter type="area"><spectrum name="radiance" value="4"/></emitter>'
    yield "area-uniform", shape("rectangle", down, uniform)
    small = f'<scale value="0.05"/>{down}'
    yield "area-small", shape("rectangle", small, area("1500,1200,900"))
    wide = '<scale value="6"/><rotate x="1" angle="90"/><translate y="5"/>'
    yield "area-wide", shape("rectangle", wide, area("0.5,0.4,0.3"))
    two = shape(
        "rectangle", down, area("3,3,3") + '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>'
    )
    yield "area-twosided", two
    picture = (
        '<emitter type="area"><texture type="bitmap" name="radiance">'
        f"{property_tags({'filename': PICTURES['exr']})}</texture></emitter>"
    )
    yield "area-picture", shape("rectangle", down, picture)
    for kind in ("disk", "sphere"):
        yield f"area-picture-{kind}", shape(kind, down, picture)
    strip = f'<scale value="0.2"/>{down}'
    many = (
        shape("rectangle", f'{strip}<translate x="{x}" z="{z}"/>', area("20,18,16"))
        for x in (-3, -1, 1, 3)
        for z in (-2, 0, 2)
    )
    yield "area-many", "".join(many)
    ball = shape("sphere", '<scale value="0.3"/><translate x="1" y="2.5" z="1"/>', area("20,15,10"))
    yield "area-two-shapes", ball + shape("rectangle", small, area("300,300,900"))


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
    for maker in (_points, _spots, _directional, _skies, _areas):
        for name, light in maker():
            yield Case(
                name=f"light/{name}", body="", stage=STAGE, lights=light, quick=name in QUICK
            )
    # Daylight and a lamp: three kinds of light in one scene
    both = DAYLIGHT + emitter(
        "point", placed('<translate y="2"/>') + property_tags({"intensity": (9.0, 3.0, 3.0)})
    )
    yield Case(name="light/mixed", body="", stage=STAGE, lights=both)
