"""One scene of the zoo: one feature on a plain stage, and the XML that says it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

#: Pixels of a zoo picture, both ways.
SIDE_PX = 64


def view(
    to_world: str = '<lookat origin="0,3,6" target="0,0.8,0" up="0,1,0"/>',
    *,
    more: str = '<float name="fov" value="45"/>',
    film: str = "",
    size: tuple[int, int] = (SIDE_PX, SIDE_PX),
    kind: str = "perspective",
) -> str:
    """A sensor. The filter is a box: each pixel counts its own samples alone, as ours does."""
    return (
        f'<sensor type="{kind}">{more}<transform name="to_world">{to_world}</transform>'
        f'<film type="hdrfilm"><integer name="width" value="{size[0]}"/>'
        f'<integer name="height" value="{size[1]}"/>{film}<rfilter type="box"/></film></sensor>'
    )


def area(radiance: str = "5,4,3") -> str:
    """An area emitter, to stand inside a shape."""
    return f'<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>'


def shape(kind: str, to_world: str = "", inside: str = "") -> str:
    """A shape with its transform and what else stands inside."""
    place = f'<transform name="to_world">{to_world}</transform>' if to_world else ""
    return f'<shape type="{kind}">{place}{inside}</shape>'


VIEW = view()
#: The surface of lamps. A shape that emits and names no bsdf has this one in Mitsuba 3.
BLACK = '<bsdf type="diffuse"><rgb name="reflectance" value="0,0,0"/></bsdf>'
#: Its front looks up.
FLOOR = shape(
    "rectangle",
    '<scale value="5"/><rotate x="1" angle="-90"/>',
    '<bsdf type="diffuse"><rgb name="reflectance" value="0.6,0.6,0.5"/></bsdf>',
)
#: A lamp that looks down, out of sight.
LAMP = shape(
    "rectangle",
    '<scale value="0.8"/><rotate x="1" angle="90"/><translate y="4.5"/>',
    area("9,8,7") + BLACK,
)
SKY = '<emitter type="constant"><rgb name="radiance" value="0.4,0.5,0.6"/></emitter>'
DAYLIGHT = LAMP + SKY


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """A scene of one feature, its body. The name, `group/what-it-has`, is also that of its file.

    Camera, stage and lights are empty where the feature takes their place.
    """

    name: str
    body: str
    camera: str = VIEW
    stage: str = FLOOR
    lights: str = DAYLIGHT
    quick: bool = False

    @property
    def group(self) -> str:
        """The kind of feature."""
        return self.name.partition("/")[0]

    @property
    def file(self) -> str:
        """The name of the file."""
        return self.name.replace("/", "-") + ".xml"

    def text(self) -> str:
        """The file."""
        parts = [self.camera, self.stage, self.lights, self.body]
        inside = "\n".join(part for part in parts if part)
        return f'<scene version="3.0.0">\n{inside}\n</scene>\n'


def property_tags(values: Mapping[str, object]) -> str:
    """Properties of a plugin by the Python types of their values; a tuple is a colour."""
    tags = []
    for name, value in values.items():
        match value:
            case bool():
                tags.append(f'<boolean name="{name}" value="{str(value).lower()}"/>')
            case int():
                tags.append(f'<integer name="{name}" value="{value}"/>')
            case float():
                tags.append(f'<float name="{name}" value="{value:g}"/>')
            case tuple():
                tags.append(f'<rgb name="{name}" value="{",".join(f"{v:g}" for v in value)}"/>')
            case _:
                tags.append(f'<string name="{name}" value="{value}"/>')
    return "".join(tags)
