"""Each shape under each transform, seen and emitting, with normals; and each kind of texture."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from viscache_lab.parity.zoo.case import SKY, Case, area, property_tags, shape, view
from viscache_lab.parity.zoo.files import ALPHA, BARE, DEEP, GREY, PALETTE, PEBBLE, PICTURES, WEDGE

#: Mitsuba 3 computes smooth normals for files without; the scenes `normals/…-computed` show them.
FLAT = '<boolean name="face_normals" value="true"/>'


def _file(name: str, more: str = "") -> str:
    return f'<string name="filename" value="{name}"/>{more}'


#: Shape → its kind and its properties. The wedge has neither a plane nor a centre of symmetry.
SHAPES: dict[str, tuple[str, str]] = {
    "rectangle": ("rectangle", ""),
    "disk": ("disk", ""),
    "cube": ("cube", ""),
    "sphere": (
        "sphere",
        '<point name="center" x="0.2" y="0" z="0"/><float name="radius" value="0.8"/>',
    ),
    "cylinder": (
        "cylinder",
        '<point name="p0" x="0" y="-0.7" z="0"/><point name="p1" x="0" y="0.8" z="0"/>'
        '<float name="radius" value="0.7"/>',
    ),
    "obj": ("obj", _file(f"{WEDGE}.obj", FLAT)),
    "ply": ("ply", _file(f"{WEDGE}.ply", FLAT)),
    "serialized": ("serialized", _file(f"{WEDGE}.serialized", FLAT)),
}
#: The axis is a unit vector: Mitsuba 3 scales by the length of any other.
TURN = '<rotate x="0.36" y="0.8" z="0.48" angle="40"/>'
TRANSFORMS: dict[str, str] = {
    "plain": "",
    "rotated": TURN,
    "long-axis": '<rotate x="0" y="1.2" z="0" angle="40"/>',
    "half": '<scale value="0.5"/>',
    "stretched": '<scale x="0.6" y="1.2" z="0.8"/>',
    "tall": '<scale x="0.8" y="0.8" z="1.3"/><rotate x="1" angle="-30"/>',
    "sheared": '<matrix value="1 0.4 0 0  0 1 0 0  0.2 0 1 0  0 0 0 1"/>',
    "mirror-x": '<scale x="-1" y="1" z="1"/>',
    "mirror-y": '<scale x="1" y="-1" z="1"/>',
    "mirror-z": '<scale x="1" y="1" z="-1"/>',
    "mirror-all": '<scale value="-1"/>',
    "mirror-rotated": '<scale x="-1" y="1" z="1"/>' + TURN,
    "lookat": '<lookat origin="0,0,0" target="0.5,0.4,1" up="0,1,0"/>',
}
#: One-sided, so that the side that is its front shows.
SURFACE = '<bsdf type="diffuse"><rgb name="reflectance" value="0.7,0.4,0.2"/></bsdf>'
#: Lifted above the floor; emitters are slanted, so that they look at the floor and the camera.
LIFT = '<translate y="1.1"/>'
SLANT = '<scale value="0.7"/><rotate x="1" angle="50"/><translate y="1.8"/>'
#: A little light, so that emitters that face away leave a picture to compare.
DIM = '<emitter type="constant"><rgb name="radiance" value="0.1,0.1,0.15"/></emitter>'
FLIP = '<boolean name="flip_normals" value="true"/>'


def shape_cases() -> Iterator[Case]:
    """The cases."""
    for name, (kind, properties) in SHAPES.items():
        for turned, transform in TRANSFORMS.items():
            yield Case(
                name=f"shape/{name}-{turned}",
                body=shape(kind, transform + LIFT, properties + SURFACE),
                quick=turned in ("rotated", "mirror-x"),
            )
            yield Case(
                name=f"emitter/{name}-{turned}",
                body=shape(kind, transform + SLANT, properties + SURFACE + area()),
                lights=DIM,
                quick=turned in ("plain", "mirror-x"),
            )
        yield Case(
            name=f"shape/{name}-flip-normals", body=shape(kind, LIFT, properties + SURFACE + FLIP)
        )
        yield Case(
            name=f"emitter/{name}-flip-normals",
            body=shape(kind, SLANT, properties + SURFACE + area() + FLIP),
            lights=DIM,
            quick=name == "ply",
        )
    for kind, turned in product(("obj", "ply"), ("plain", "mirror-x")):
        # Every normal is that of one face: those of a smooth lamp weigh Mitsuba's samples
        body = _file(f"{WEDGE}-creased.{kind}") + SURFACE + area()
        yield Case(
            name=f"emitter/{kind}-creased-{turned}",
            body=shape(kind, TRANSFORMS[turned] + SLANT, body),
            lights=DIM,
        )
    yield from _normals()
    yield from _instances()


def _normals() -> Iterator[Case]:
    """Files with normals at their vertices, with normals to leave out, and without any."""
    for kind in ("obj", "ply", "serialized"):
        for given, more in {
            "smooth": "",
            "smooth-flip": FLIP,
            "leaning": "",
            "face-normals": FLAT,
            "computed": "",
        }.items():
            stem = PEBBLE if given.startswith("smooth") else f"{WEDGE}-smooth"
            for turned in ("plain", "mirror-x", "stretched"):
                file = _file(f"{WEDGE if given == 'computed' else stem}.{kind}")
                transform = TRANSFORMS[turned] + LIFT
                yield Case(
                    name=f"normals/{kind}-{given}-{turned}",
                    body=shape(kind, transform, file + more + SURFACE),
                    quick=(kind, turned) == ("ply", "mirror-x") and given in ("smooth", "computed"),
                )


def _instances() -> Iterator[Case]:
    """A group that is placed several times."""
    wedge = shape("ply", "", _file(f"{WEDGE}.ply", FLAT) + SURFACE)
    cube = shape("cube", '<scale value="0.3"/><translate x="0.6" y="0.7"/>', SURFACE)
    group = f'<shape type="shapegroup" id="group">{wedge}{cube}</shape>'
    for turned, transform in TRANSFORMS.items():
        placed = shape("instance", transform + LIFT, '<ref id="group"/>')
        yield Case(
            name=f"instance/{turned}", body=group + placed, lights=SKY, quick=turned == "mirror-x"
        )


#: Close above the floor: texels are several pixels wide.
ABOVE = view('<lookat origin="0.3,5,0.5" target="0,0,0" up="0,0,-1"/>')
TO_UV = {
    "scaled": '<scale x="2" y="3" z="1"/>',
    "turned": '<rotate z="1" angle="30"/>',
    "moved": '<translate x="0.3" y="0.1"/>',
    "mixed": '<scale x="1.5" y="-2" z="1"/><rotate z="1" angle="20"/><translate x="0.2" y="0.4"/>',
}


def textured(kind: str, inside: str, *, to_uv: str = "") -> str:
    """A diffuse bsdf with a texture."""
    placed = f'<transform name="to_uv">{to_uv}</transform>' if to_uv else ""
    texture = f'<texture type="{kind}" name="reflectance">{inside}{placed}</texture>'
    return f'<bsdf type="diffuse">{texture}</bsdf>'


def _textures() -> Iterator[tuple[str, str]]:
    png = PICTURES["png"]
    rows: list[tuple[str, dict[str, object], str]] = [
        (f"{kind}-{'raw' if raw else 'srgb'}", {"filename": PICTURES[kind], "raw": raw}, "")
        for kind, raw in product(PICTURES, (False, True))
    ]
    for file in (GREY, ALPHA, DEEP, PALETTE):
        rows.append((file.partition(".")[0], {"filename": file}, ""))
    rows.append(("nearest", {"filename": png, "filter_type": "nearest"}, ""))
    for wrap, (name, to_uv) in product(("repeat", "mirror", "clamp"), TO_UV.items()):
        rows.append((f"{wrap}-{name}", {"filename": png, "wrap_mode": wrap}, to_uv))
    for name, values, to_uv in rows:
        yield f"bitmap-{name}", textured("bitmap", property_tags(values), to_uv=to_uv)
    yield "checkerboard-default", textured("checkerboard", "")
    colours = property_tags({"color0": (0.9, 0.2, 0.1), "color1": (0.1, 0.3, 0.8)})
    for name, to_uv in {"colours": "", **TO_UV}.items():
        yield f"checkerboard-{name}", textured("checkerboard", colours, to_uv=to_uv)


def texture_cases() -> Iterator[Case]:
    """The cases."""
    quick = {"bitmap-jpeg-srgb", "bitmap-exr-raw", "bitmap-mirror-mixed", "checkerboard-scaled"}
    for name, material in _textures():
        yield Case(
            name=f"texture/{name}",
            body=shape("rectangle", '<scale value="2.5"/><rotate x="1" angle="-90"/>', material),
            camera=ABOVE,
            stage="",
            lights=SKY,
            quick=name in quick,
        )
    yield from _on_shapes()


def _on_shapes() -> Iterator[Case]:
    """Texture coordinates of shapes and of files."""
    picture = textured("bitmap", property_tags({"filename": PICTURES["png"]}))
    both = f'<bsdf type="twosided">{picture}</bsdf>'
    turns = {"plain": "", "turned": '<rotate x="0.6" y="0.8" angle="130"/>'}
    for name, (kind, properties) in SHAPES.items():
        for turned, step in turns.items():
            yield Case(
                name=f"uv/{name}-{turned}",
                body=shape(kind, step + LIFT, properties + both),
                lights=SKY,
                quick=(name, turned) in {("cube", "plain"), ("obj", "plain")},
            )
    for kind, flip in product(("obj", "ply"), (False, True)):
        values = {"filename": f"{WEDGE}.{kind}", "flip_tex_coords": flip, "face_normals": True}
        yield Case(
            name=f"uv/{kind}-flip-{str(flip).lower()}",
            body=shape(kind, LIFT, property_tags(values) + picture),
            lights=SKY,
        )
    for kind, more in product(("obj", "ply"), ({"face_normals": True}, {})):
        yield Case(
            name=f"uv/{kind}-without-{'flat' if more else 'smooth'}",
            body=shape(kind, LIFT, property_tags({"filename": f"{BARE}.{kind}", **more}) + both),
            lights=SKY,
        )
