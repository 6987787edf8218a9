"""Scenes of others in `$VISCACHE_SCENES`, and what Mitsuba 3 needs to load them.

Both renderers load the same prepared file. It differs from the original in the film (small, with a
box filter), the integrator and the sampler, which belong to no comparison, and in what Mitsuba 3
does not know: files of Mitsuba 0.x name plugins and properties that are gone.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from xml.etree import ElementTree

from viscache.scenes.sources import SCENES_VARIABLE
from viscache_lab.parity.zoo import scene_text

#: Width of the pictures.
WIDTH_PX = 160
#: Plugins that Mitsuba 3 has no more, and the nearest that it has.
RENAMED = {"roughdiffuse": "diffuse", "lambertian": "diffuse"}
#: Properties that Mitsuba 3 has no more, by plugin.
GONE = {
    "bitmap": ("filterType", "filter_type", "gamma", "maxAnisotropy", "cache"),
    "diffuse": ("alpha", "useFastApprox"),
    "obj": ("maxSmoothAngle", "max_smooth_angle"),
    "serialized": ("maxSmoothAngle", "max_smooth_angle"),
    "conductor": ("extEta", "ext_eta"),
    "roughconductor": ("extEta", "ext_eta"),
    "sunsky": ("sunRadiusScale", "sun_radius_scale", "extend", "resolution"),
}
#: Files that make a scene: Mitsuba's own, meshes and maps.
PREPARED = (".xml", ".ply", ".hdr", ".exr")
#: Scenes of which Mitsuba 3 has no loader, by the end of their file.
OTHERS = {".pbrt": "pbrt", ".gltf": "glTF", ".glb": "glTF"}


@dataclass(frozen=True, kw_only=True, slots=True)
class Shared:
    """A scene of others: a prepared file, or why there is none."""

    name: str
    path: Path | None = None
    reason: str = ""


def shared_scenes(folder: Path, *, only: str = "*", quick: bool = False) -> Iterator[Shared]:
    """Prepare the shared scenes whose names match in a folder; quick: the smallest alone."""
    given = os.environ.get(SCENES_VARIABLE)
    if not given or not Path(given).is_dir():
        if fnmatchcase("shared/", only) or only.startswith("shared"):
            yield Shared(name="shared/*", reason=f"{SCENES_VARIABLE} names no folder of scenes")
        return
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted(Path(given).resolve().glob("*/*")):
        suffix = path.suffix
        if suffix not in PREPARED and suffix not in OTHERS:
            continue
        name = f"shared/{path.parent.name}" + ("" if path.stem == "scene" else f"-{path.stem}")
        if not fnmatchcase(name, only) or (quick and name != "shared/cornell-box"):
            continue
        if suffix == ".xml":
            yield _prepared(name, path, folder / f"{name.replace('/', '-')}.xml")
        elif suffix in PREPARED:
            # Meshes beside a scene belong to it
            if not list(path.parent.glob("scene.*")):
                yield _alone(name, path, folder)
        elif not path.with_suffix(".xml").exists():
            yield Shared(name=name, reason=f"Mitsuba 3 does not read {OTHERS[suffix]}")


def _prepared(name: str, path: Path, target: Path) -> Shared:
    try:
        tree = ElementTree.parse(path)
    except (ElementTree.ParseError, OSError) as error:
        return Shared(name=name, reason=f"{path.name} is not XML: {error}")
    scene = tree.getroot()
    for integrator in scene.findall("integrator"):
        scene.remove(integrator)
    defaults = {f"${d.get('name')}": str(d.get("value")) for d in scene.findall("default")}
    for sensor in scene.findall("sensor"):
        _small_film(sensor, defaults)
    old = not str(scene.get("version", "")).startswith(("2", "3"))
    for element in scene.iter():
        _modern(element, old)
    if old:
        _turn_skies(scene)
    scene.insert(0, ElementTree.Element("path", {"value": str(path.parent)}))
    tree.write(target, encoding="utf-8")
    return Shared(name=name, path=target)


def _small_film(sensor: ElementTree.Element, defaults: Mapping[str, str]) -> None:
    """Same aspect, box filter, independent samples."""
    size = {"width": 768, "height": 576}
    for film in sensor.findall("film"):
        for child in film:
            if child.get("name") in size:
                given = str(child.get("value"))
                size[str(child.get("name"))] = int(defaults.get(given, given))
        sensor.remove(film)
    for sampler in sensor.findall("sampler"):
        sensor.remove(sampler)
    height = max(16, round(WIDTH_PX * size["height"] / size["width"]))
    film = ElementTree.SubElement(sensor, "film", {"type": "hdrfilm"})
    for key, value in (("width", WIDTH_PX), ("height", height)):
        ElementTree.SubElement(film, "integer", {"name": key, "value": str(value)})
    ElementTree.SubElement(film, "rfilter", {"type": "box"})


def _modern(element: ElementTree.Element, old: bool) -> None:
    """Take out what Mitsuba 3 refuses, so that the rest is compared."""
    kind = element.get("type", "")
    if element.tag == "lookAt":
        element.tag = "lookat"
    if old and kind == "phong":
        element.set("type", "roughplastic")
        for child in list(element):
            if child.get("name") in ("exponent", "specularReflectance"):
                element.remove(child)
    if kind in RENAMED:
        element.set("type", RENAMED[kind])
        kind = RENAMED[kind]
    for child in list(element):
        if child.get("name") in GONE.get(kind, ()):
            element.remove(child)


def _turn_skies(scene: ElementTree.Element) -> None:
    """A clear sky has y up in Mitsuba 0.x and z in Mitsuba 3: its file becomes one of Mitsuba 3."""
    skies = [emitter for emitter in scene.iter("emitter") if emitter.get("type") == "sunsky"]
    if not skies:
        return
    scene.set("version", "3.0.0")
    for element in scene.iter():
        if element.get("name") and element.tag != "default":
            name = str(element.get("name"))
            element.set("name", re.sub("(?<=[a-z])[A-Z]+", lambda m: f"_{m[0].lower()}", name))
    for sky in skies:
        names = {child.get("name"): child for child in sky}
        place = names.get("to_world")
        if place is None:
            place = ElementTree.SubElement(sky, "transform", {"name": "to_world"})
        place.insert(0, ElementTree.Element("rotate", {"x": "1", "angle": "-90"}))
        if "albedo" not in names:
            ElementTree.SubElement(sky, "rgb", {"name": "albedo", "value": "0.2"})


def _alone(name: str, path: Path, folder: Path) -> Shared:
    """A scene around a single mesh or map."""
    target = folder / f"{name.replace('/', '-')}.xml"
    file = "string:filename(PATH) }"
    body = (
        f"shape.ply{{ $AT{{ scale(6) translate(y=0.2) }} {file} $DAYLIGHT"
        if path.suffix == ".ply"
        else f"shape.cube{{ $AT{{ scale(0.7) translate(y=0.7) }} }} emitter.envmap{{ {file}"
    )
    floor = "shape.rectangle{ $AT{ scale(4) rotate(x=1 angle=-90) } }"
    text = scene_text(f"$VIEW {floor} {body}").replace("PATH", str(path))
    target.write_text(text, encoding="utf-8")
    return Shared(name=name, path=target)
