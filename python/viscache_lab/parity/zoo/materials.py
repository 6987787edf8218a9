"""Each material and its parameters, on a floor and a ball, by a lamp, a sky and a point light."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

from viscache_lab.parity.zoo.case import BLACK, SKY, Case, area, property_tags, shape
from viscache_lab.parity.zoo.files import GREY, PICTURES, SKY_MAP

BASE = (0.6, 0.35, 0.15)
METALS = ("Cu", "Au", "Ag", "Al", "Cr", "none")
#: A lamp behind, which looks to the camera and shows in the floor's highlight.
LAMP = shape(
    "rectangle",
    '<rotate y="1" angle="180"/><rotate x="1" angle="-35"/><rotate y="1" angle="180"/>'
    '<translate x="0.3" y="3" z="-3.5"/>',
    area("6,5,4") + BLACK,
)
LIGHTS = {
    "lamp": LAMP,
    "sky": '<emitter type="envmap"><string name="filename" '
    f'value="{SKY_MAP}.exr"/><transform name="to_world"><rotate y="1" angle="70"/></transform>'
    "</emitter>",
    "point": '<emitter type="point"><point name="position" x="1" y="3" z="-1"/>'
    '<rgb name="intensity" value="20,18,16"/></emitter>',
}


def bsdf(kind: str, values: Mapping[str, object] | None = None, inside: str = "") -> str:
    """A bsdf with its properties."""
    return f'<bsdf type="{kind}">{property_tags(values or {})}{inside}</bsdf>'


def two_sided(*inner: str) -> str:
    """The adapter that gives a one-sided bsdf to both sides."""
    return f'<bsdf type="twosided">{"".join(inner)}</bsdf>'


def bitmap(file: str, name: str, *, raw: bool = False) -> str:
    """A picture as the value of a property."""
    more = property_tags({"filename": file} | ({"raw": True} if raw else {}))
    return f'<texture type="bitmap" name="{name}">{more}</texture>'


def _diffuse() -> Iterator[tuple[str, str]]:
    yield "diffuse-default", bsdf("diffuse")
    for name, value in {"colour": BASE, "black": (0.0, 0.0, 0.0), "white": (1.0, 1.0, 1.0)}.items():
        yield f"diffuse-{name}", bsdf("diffuse", {"reflectance": value})
    yield (
        "diffuse-uniform",
        '<bsdf type="diffuse"><spectrum name="reflectance" value="0.4"/></bsdf>',
    )
    yield "twosided-diffuse", two_sided(bsdf("diffuse", {"reflectance": BASE}))
    yield (
        "twosided-two",
        two_sided(
            bsdf("diffuse", {"reflectance": BASE}),
            bsdf("diffuse", {"reflectance": (0.1, 0.2, 0.8)}),
        ),
    )


def _plastic() -> Iterator[tuple[str, str]]:
    for nonlinear, ior in product((False, True), (1.3, 1.5, 1.9)):
        values = {"diffuse_reflectance": BASE, "nonlinear": nonlinear, "int_ior": ior}
        name = f"{'nonlinear-' if nonlinear else ''}ior{ior:g}"
        yield f"plastic-{name}", bsdf("plastic", values)
        for alpha in (0.05, 0.2, 0.5):
            rough = values | {"alpha": alpha, "distribution": "ggx"}
            yield f"roughplastic-{name}-alpha{alpha:g}", bsdf("roughplastic", rough)
    yield "plastic-default", bsdf("plastic")
    yield "roughplastic-default", bsdf("roughplastic")
    yield (
        "plastic-named-ior",
        bsdf("plastic", {"int_ior": "diamond", "ext_ior": "water", "diffuse_reflectance": BASE}),
    )
    tinted = {"diffuse_reflectance": BASE, "specular_reflectance": (0.9, 0.4, 0.2), "alpha": 0.2}
    yield "roughplastic-tinted", bsdf("roughplastic", tinted | {"distribution": "ggx"})
    picture = bitmap(PICTURES["png"], "diffuse_reflectance")
    yield "plastic-picture", bsdf("plastic", {"nonlinear": True}, picture)
    yield "roughplastic-picture", bsdf("roughplastic", {"distribution": "ggx"}, picture)
    yield "twosided-plastic", two_sided(bsdf("plastic", {"diffuse_reflectance": BASE}))


def _conductor() -> Iterator[tuple[str, str]]:
    for metal in METALS:
        yield f"conductor-{metal}", bsdf("conductor", {"material": metal})
        for alpha in (0.05, 0.2, 0.5):
            values = {"material": metal, "alpha": alpha, "distribution": "ggx"}
            yield f"roughconductor-{metal}-alpha{alpha:g}", bsdf("roughconductor", values)
    given = {"eta": (0.2, 0.9, 1.1), "k": (3.9, 2.4, 2.2)}
    yield "conductor-given", bsdf("conductor", given)
    yield "roughconductor-given", bsdf("roughconductor", given | {"distribution": "ggx"})
    tinted = {"material": "Ag", "specular_reflectance": (0.9, 0.5, 0.2)}
    yield "conductor-tinted", bsdf("conductor", tinted)
    stretched = {"material": "Al", "alpha_u": 0.05, "alpha_v": 0.4, "distribution": "ggx"}
    yield "roughconductor-anisotropic", bsdf("roughconductor", stretched)
    yield (
        "roughconductor-beckmann",
        bsdf("roughconductor", {"material": "Al", "alpha": 0.3, "distribution": "beckmann"}),
    )
    yield "roughconductor-default", bsdf("roughconductor")
    yield "conductor-default", bsdf("conductor")


def _glass() -> Iterator[tuple[str, str]]:
    for kind, ior in product(("dielectric", "thindielectric"), (1.3, 1.5, 2.4)):
        yield f"{kind}-ior{ior:g}", bsdf(kind, {"int_ior": ior})
    for kind in ("dielectric", "thindielectric", "roughdielectric"):
        yield f"{kind}-default", bsdf(kind)
    tinted = {"specular_reflectance": (0.9, 0.5, 0.2), "specular_transmittance": (0.3, 0.6, 0.9)}
    yield "dielectric-tinted", bsdf("dielectric", tinted)
    yield "thindielectric-tinted", bsdf("thindielectric", tinted)


def _masks() -> Iterator[tuple[str, str]]:
    surface = bsdf("diffuse", {"reflectance": BASE})
    for opacity in (0.0, 0.25, 0.5, 0.8, 1.0):
        yield f"mask-{opacity:g}", bsdf("mask", {"opacity": opacity}, surface)
    yield "mask-picture", bsdf("mask", {}, bitmap(GREY, "opacity", raw=True) + surface)
    yield "mask-twosided", bsdf("mask", {"opacity": 0.5}, two_sided(surface))
    yield "mask-plastic", bsdf("mask", {"opacity": 0.6}, bsdf("plastic"))


def _others() -> Iterator[tuple[str, str]]:
    for metallic, roughness in product((0.0, 0.5, 1.0), (0.2, 0.6)):
        values = {"base_color": BASE, "metallic": metallic, "roughness": roughness}
        yield f"principled-metallic{metallic:g}-roughness{roughness:g}", bsdf("principled", values)
    yield "principled-default", bsdf("principled")
    inner = bsdf("diffuse", {"reflectance": BASE})
    bump = bitmap(GREY, "arbitrary", raw=True)
    yield "bumpmap", bsdf("bumpmap", {"scale": 0.2}, bump + inner)
    yield "normalmap", bsdf("normalmap", {}, bitmap(PICTURES["png"], "normalmap", raw=True) + inner)
    other = bsdf("diffuse", {"reflectance": (0.1, 0.2, 0.8)})
    yield "blendbsdf", bsdf("blendbsdf", {"weight": 0.4}, inner + other)
    yield "null", bsdf("null")


#: Materials of the quick suite.
QUICK = {
    "diffuse-colour",
    "twosided-two",
    "plastic-ior1.5",
    "plastic-nonlinear-ior1.5",
    "roughplastic-nonlinear-ior1.5-alpha0.2",
    "conductor-Au",
    "roughconductor-Cu-alpha0.2",
    "dielectric-ior1.5",
    "thindielectric-ior1.5",
    "mask-0.25",
    "principled-default",
}


def material_cases() -> Iterator[Case]:
    """The cases; mirrors and glass show lights alone, so that a point light says nothing there."""
    for maker in (_diffuse, _plastic, _conductor, _glass, _masks, _others):
        for name, material in maker():
            for light, lights in LIGHTS.items():
                if light == "point" and name.startswith(("conductor", "dielectric", "thindi")):
                    continue
                yield Case(
                    name=f"material/{name}-{light}",
                    body=_stage(material, back=name.startswith("twosided")),
                    stage="",
                    lights=lights + (SKY if light == "lamp" else ""),
                    quick=name in QUICK and light in ("lamp", "sky"),
                )


def _stage(material: str, *, back: bool) -> str:
    """Floor and ball of the material, on a plain floor that shows through it.

    `back`: the floor shows its back.
    """
    turn = f'<rotate x="1" angle="{90 if back else -90}"/>'
    floor = shape("rectangle", '<scale value="4"/>' + turn, material)
    ball = shape("sphere", '<scale value="0.9"/><translate x="-0.5" y="1.1"/>', material)
    below = shape("rectangle", '<scale value="6"/><rotate x="1" angle="-90"/><translate y="-0.5"/>')
    return floor + ball + below
