"""Each material and its parameters, on a floor and a ball, by a lamp, a sky and a point light."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain, product

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


ALPHAS = (0.05, 0.2, 0.5)
GGX: dict[str, object] = {"distribution": "ggx"}
TINT = (0.9, 0.5, 0.2)


def _diffuse() -> Iterator[tuple[str, str]]:
    yield "diffuse-default", bsdf("diffuse")
    for name, value in {"colour": BASE, "black": (0.0, 0.0, 0.0), "white": (1.0, 1.0, 1.0)}.items():
        yield f"diffuse-{name}", bsdf("diffuse", {"reflectance": value})
    uniform = '<spectrum name="reflectance" value="0.4"/>'
    yield "diffuse-uniform", bsdf("diffuse", inside=uniform)
    base, blue = SURFACE, bsdf("diffuse", {"reflectance": (0.1, 0.2, 0.8)})
    yield "twosided-diffuse", two_sided(base)
    yield "twosided-two", two_sided(base, blue)


def _plastic() -> Iterator[tuple[str, str]]:
    base: dict[str, object] = {"diffuse_reflectance": BASE}
    for nonlinear, ior in product((False, True), (1.3, 1.5, 1.9)):
        values = base | {"nonlinear": nonlinear, "int_ior": ior}
        name = f"{'nonlinear-' if nonlinear else ''}ior{ior:g}"
        yield f"plastic-{name}", bsdf("plastic", values)
        for alpha in ALPHAS:
            rough = bsdf("roughplastic", values | {"alpha": alpha} | GGX)
            yield f"roughplastic-{name}-alpha{alpha:g}", rough
    yield "plastic-default", bsdf("plastic")
    yield "roughplastic-default", bsdf("roughplastic")
    named: dict[str, object] = {"int_ior": "diamond", "ext_ior": "water"}
    yield "plastic-named-ior", bsdf("plastic", named | base)
    tinted = base | {"specular_reflectance": (0.9, 0.4, 0.2), "alpha": 0.2}
    yield "roughplastic-tinted", bsdf("roughplastic", tinted | GGX)
    picture = bitmap(PICTURES["png"], "diffuse_reflectance")
    yield "plastic-picture", bsdf("plastic", {"nonlinear": True}, picture)
    yield "roughplastic-picture", bsdf("roughplastic", GGX, picture)
    yield "twosided-plastic", two_sided(bsdf("plastic", base))


def _conductor() -> Iterator[tuple[str, str]]:
    for metal in METALS:
        yield f"conductor-{metal}", bsdf("conductor", {"material": metal})
        for alpha in ALPHAS:
            rough = bsdf("roughconductor", {"material": metal, "alpha": alpha} | GGX)
            yield f"roughconductor-{metal}-alpha{alpha:g}", rough
    given: dict[str, object] = {"eta": (0.2, 0.9, 1.1), "k": (3.9, 2.4, 2.2)}
    yield "conductor-given", bsdf("conductor", given)
    yield "roughconductor-given", bsdf("roughconductor", given | GGX)
    yield "conductor-tinted", bsdf("conductor", {"material": "Ag", "specular_reflectance": TINT})
    stretched = {"material": "Al", "alpha_u": 0.05, "alpha_v": 0.4} | GGX
    yield "roughconductor-anisotropic", bsdf("roughconductor", stretched)
    beckmann = {"material": "Al", "alpha": 0.3, "distribution": "beckmann"}
    yield "roughconductor-beckmann", bsdf("roughconductor", beckmann)
    yield "roughconductor-default", bsdf("roughconductor")
    yield "conductor-default", bsdf("conductor")


def _others() -> Iterator[tuple[str, str]]:
    for kind, ior in product(("dielectric", "thindielectric"), (1.3, 1.5, 2.4)):
        yield f"{kind}-ior{ior:g}", bsdf(kind, {"int_ior": ior})
    for kind in ("dielectric", "thindielectric", "roughdielectric"):
        yield f"{kind}-default", bsdf(kind)
    tinted = {"specular_reflectance": TINT, "specular_transmittance": (0.3, 0.6, 0.9)}
    for kind in ("dielectric", "thindielectric"):
        yield f"{kind}-tinted", bsdf(kind, tinted)
    for opacity in (0.0, 0.25, 0.5, 0.8, 1.0):
        yield f"mask-{opacity:g}", bsdf("mask", {"opacity": opacity}, SURFACE)
    yield "mask-picture", bsdf("mask", {}, bitmap(GREY, "opacity", raw=True) + SURFACE)
    yield "mask-twosided", bsdf("mask", {"opacity": 0.5}, two_sided(SURFACE))
    yield "mask-plastic", bsdf("mask", {"opacity": 0.6}, bsdf("plastic"))
    for metallic, roughness in product((0.0, 0.5, 1.0), (0.2, 0.6)):
        values = {"base_color": BASE, "metallic": metallic, "roughness": roughness}
        yield f"principled-metallic{metallic:g}-roughness{roughness:g}", bsdf("principled", values)
    yield "principled-default", bsdf("principled")
    bump = bitmap(GREY, "arbitrary", raw=True)
    yield "bumpmap", bsdf("bumpmap", {"scale": 0.2}, bump + SURFACE)
    normals = bitmap(PICTURES["png"], "normalmap", raw=True)
    yield "normalmap", bsdf("normalmap", {}, normals + SURFACE)
    blue = bsdf("diffuse", {"reflectance": (0.1, 0.2, 0.8)})
    yield "blendbsdf", bsdf("blendbsdf", {"weight": 0.4}, SURFACE + blue)
    yield "null", bsdf("null")


SURFACE = bsdf("diffuse", {"reflectance": BASE})
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
    every = chain(_diffuse(), _plastic(), _conductor(), _others())
    for (name, material), (light, lights) in product(every, LIGHTS.items()):
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
