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
