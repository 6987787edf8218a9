"""Each kind of texture and its parameters, on a floor seen from above under an even sky."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from viscache_lab.parity.zoo.case import SKY, Case, property_tags, shape, view
from viscache_lab.parity.zoo.files import ALPHA, BARE, DEEP, GREY, PALETTE, PICTURES, WEDGE
from viscache_lab.parity.zoo.shapes import LIFT, SHAPES

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


def _pictures() -> Iterator[tuple[str, str]]:
    for kind, raw in product(PICTURES, (False, True)):
        values = property_tags({"filename": PICTURES[kind], "raw": raw})
        yield f"bitmap-{kind}-{'raw' if raw else 'srgb'}", textured("bitmap", values)
    for file in (GREY, ALPHA, DEEP, PALETTE):
        name = file.partition(".")[0]
        yield f"bitmap-{name}", textured("bitmap", property_tags({"filename": file}))
    nearest = property_tags({"filename": PICTURES["png"], "filter_type": "nearest"})
    yield "bitmap-nearest", textured("bitmap", nearest)
    for wrap, uv in product(("repeat", "mirror", "clamp"), TO_UV):
        values = property_tags({"filename": PICTURES["png"], "wrap_mode": wrap})
        yield f"bitmap-{wrap}-{uv}", textured("bitmap", values, to_uv=TO_UV[uv])


def _checkerboards() -> Iterator[tuple[str, str]]:
    yield "checkerboard-default", textured("checkerboard", "")
    colours = property_tags({"color0": (0.9, 0.2, 0.1), "color1": (0.1, 0.3, 0.8)})
    yield "checkerboard-colours", textured("checkerboard", colours)
    for name, to_uv in TO_UV.items():
        yield f"checkerboard-{name}", textured("checkerboard", colours, to_uv=to_uv)


def texture_cases() -> Iterator[Case]:
    """The cases."""
    quick = {"bitmap-jpeg-srgb", "bitmap-exr-raw", "bitmap-mirror-mixed", "checkerboard-scaled"}
    for maker in (_pictures, _checkerboards):
        for name, material in maker():
            floor = shape("rectangle", '<scale value="2.5"/><rotate x="1" angle="-90"/>', material)
            yield Case(
                name=f"texture/{name}",
                body=floor,
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
