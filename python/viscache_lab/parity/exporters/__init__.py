"""Files as other programs write them: one feature each, and what is right by a closed formula.

A row of a table is `name | who writes it, or the rule | what is right | change of the template`.
The files show a quad that fills the picture, under a sky whose front is bright within 45° of the
quad's normal (radiance 2, elsewhere 0, so that a white diffuse surface has radiance 1), and whose
back has radiance 3. In rows `light-…` the file's lights shine on the middle of the quad instead;
in rows `camera-…` its camera sees the quad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.parity.exporters.formats import CORNERS, Files, gltf, obj, pbrt, pictures, ply
from viscache_lab.parity.judge import Effort, Judged, judge_pair
from viscache_lab.parity.renderers import SAMPLES, FloatImage, Loaded, brief

__all__ = ["Row", "judge_row", "rows", "write"]

#: The word for files of which a warning or an error is the only right answer.
SAID = "said"
#: These pictures have little noise.
EFFORT = Effort(spp=8, first=4, most=16)
#: Radiances of the sky: within 45° of the quad's normal, and behind the quad.
BRIGHT, BEHIND = 2.0, 3.0
#: Half the height of the picture, and of that of the middle alone.
VIEW, MIDDLE = 1.0, 0.001


@dataclass(frozen=True, kw_only=True, slots=True)
class Row:
    """A file: its name, `format/feature-what`, its texts by name, and what is right."""

    name: str
    by: str
    right: str
    files: Files

    @property
    def feature(self) -> str:
        """The kind of feature."""
        return self.name.partition("/")[2].partition("-")[0]

    @property
    def file(self) -> str:
        """The file that is loaded."""
        return next(iter(self.files))


_MAKERS: dict[str, Callable[[str, str], Files]] = {
    "gltf": gltf,
    "obj": obj,
    "ply": ply,
    "pbrt3": lambda stem, change: pbrt(stem, change, "3"),
    "pbrt4": lambda stem, change: pbrt(stem, change, "4"),
}


def rows(*, quick: bool = False) -> list[Row]:
    """All rows, or the first of each feature of each format."""
    return [row for table in ("gltf", "obj", "pbrt", "ply") for row in _table(table, quick)]


def _table(table: str, quick: bool) -> Iterator[Row]:
    text = (resources.files(__package__) / f"{table}.txt").read_text("utf-8")
    seen: set[tuple[str, str]] = set()
    for line in text.splitlines():
        if not line or line.startswith("#"):
            continue
        name, by, right, change = (cell.strip() for cell in line.split(" | ", 3))
        # Rows of pbrt begin with the versions
        names = [f"pbrt{v}/{name[2:].strip()}" for v in name[:2].strip()] if table == "pbrt" else []
        for full in names or [f"{table}/{name}"]:
            kind, _, what = full.partition("/")
            feature = (kind, what.partition("-")[0])
            if not quick or feature not in seen:
                files = _MAKERS[kind](full.replace("/", "-"), change)
                yield Row(name=full, by=by, right=right, files=files)
            seen.add(feature)


def write(folder: Path, chosen: list[Row]) -> dict[str, Path]:
    """Write files and the pictures that they name; the path of each row's file."""
    folder.mkdir(parents=True, exist_ok=True)
    for row in [Row(name="", by="", right="", files=pictures()), *chosen]:
        for name, content in row.files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
    return {row.name: folder / row.file for row in chosen}


def judge_row(row: Row, path: Path, *, threads: int | None = None) -> Judged:
    """The picture of a file against what is right."""
    mine = _load(row, path, threads)
    about = f"{row.by}; right: {row.right}"
    if row.right == SAID:
        said = bool(mine.warnings)
        return Judged(
            name=row.name,
            verdict="agrees" if said else "differs",
            warnings=mine.warnings,
            mitsuba=[],
            why="" if said else "neither refused nor warned of",
            about=about,
        )
    theirs = expected(row.right)
    other = Loaded(render=lambda spp, seed: theirs)
    return judge_pair(row.name, mine, other, effort=EFFORT, about=about)


def _load(row: Row, path: Path, threads: int | None) -> Loaded:
    """The file with the sky and the camera of its kind; what was said of a wrong picture."""
    sky = None if row.feature == "light" else _sky()
    try:
        scene = vc.load_scene(path, env=sky)
    except (ValueError, OSError, MemoryError) as error:
        return Loaded(warnings=[brief(str(error), path)])
    warnings: list[str] = []
    if scene.warnings:
        try:
            vc.load_scene(path, env=sky, strict=True)
        except (ValueError, OSError):  # otherwise all is said to leave the picture right
            warnings = [brief(text, path) for text in scene.warnings]
    if row.feature == "camera" and not scene.cameras:
        return Loaded(warnings=[*warnings, "the scene has no camera"])
    half = MIDDLE if row.feature == "light" else VIEW
    camera = (
        None
        if row.feature == "camera"
        else vc.orthographic((0, 0, 1.5), (0, 0, 0), height=2 * half)
    )
    height, width = (1, 1) if row.right == SAID else expected(row.right).shape[:2]

    def picture(spp: int, seed: int) -> FloatImage:
        size = (width, height)
        frame = vc.render(
            scene, SAMPLES, camera=camera, size=size, spp=spp, seed=seed, threads=threads
        )
        return frame.image

    return Loaded(render=picture, warnings=warnings)


@cache
def _sky(height: int = 256) -> npt.NDArray[np.float32]:
    """The sky: y is up, and +z, where the quad looks, is the middle column."""
    v, u = (np.mgrid[0:height, 0 : 2 * height] + 0.5) / height
    z = -np.sin(np.pi * v) * np.cos(np.pi * u)
    level = np.where(z > math.sqrt(0.5), BRIGHT, np.where(z < 0, BEHIND, 0))
    return np.repeat(level[..., None], 3, axis=2).astype(np.float32)


def expected(right: str) -> FloatImage:
    """The picture of `.5` or `.8,.6,.4` everywhere, or of several, from the top left, in two rows.

    Letters are the corners of `quad.png`, small ones without the transfer function of sRGB. A word
    is a formula, and what follows is given to it.
    """
    first, *rest = right.split()
    cells = FORMULAS[first](*map(_cell, rest)) if first in FORMULAS else _cells(right)
    table = np.array([np.broadcast_to(cell, 3) for cell in cells], np.float32)
    table = (
        table.reshape(-1, len(table) // 2, 3)
        if len(table) > 1
        else table.repeat(4, 0).reshape(2, 2, 3)
    )
    return np.asarray(table.repeat(8, axis=0).repeat(8, axis=1))


def _cells(right: str) -> list[Any]:
    return [_cell(word) for word in right.split()]


def _cell(word: str) -> Any:
    if word.upper() in CORNERS:
        linear = np.array(CORNERS[word.upper()]) / 255
        return linear if word.islower() else srgb(linear)
    numbers = np.array([float(x) for x in word.split(",")])
    return numbers if len(numbers) > 1 else numbers[0]


def srgb(encoded: Any) -> Any:
    """Linear values of encoded ones."""
    x = np.asarray(encoded, float)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def furnace(
    base: float, metallic: float, roughness: float, f0: float = 0.04, f90: float = 1.0
) -> float:
    """Radiance along the normal under the sky's front, by the formula of glTF 2.0, appendix B."""
    edge, steps = math.pi / 4, 20_000
    theta = (np.arange(steps) + 0.5) * edge / steps
    cos, half = np.cos(theta), np.cos(theta / 2)
    a2 = roughness**4
    d = a2 / (math.pi * (half**2 * (a2 - 1) + 1) ** 2)
    visible = 0.5 / (cos + np.sqrt(cos**2 * (1 - a2) + a2))
    grown = (1 - half) ** 5
    dielectric, metal = f0 + (f90 - f0) * grown, base + (1 - base) * grown
    diffuse = (1 - metallic) * (1 - dielectric) * base / math.pi
    mirror = d * visible * (metallic * metal + (1 - metallic) * dielectric)
    weight = BRIGHT * 2 * math.pi * cos * np.sin(theta) * edge / steps
    return float((weight * (diffuse + mirror)).sum())


def glassy(base: float, share: float, roughness: float) -> float:
    """A dielectric that lets a share of the light through that it does not reflect."""
    mirror = furnace(0, 0, roughness)
    diffuse = furnace(base, 0, roughness) - mirror
    return mirror + (1 - share) * diffuse + share * base * BEHIND * (1 - 0.04)


def lamp(radiance: Any, half: float, distance: float) -> Any:
    """Radiance of the grey quad under a square lamp of half that side."""
    r = math.hypot(half, distance)
    factor = 4 * half / r * math.atan(half / r) / math.pi
    return 0.5 * radiance * factor


#: Words of the column "right".
FORMULAS: dict[str, Callable[..., list[Any]]] = {
    # a of the front, the rest of what is behind
    "over": lambda a, *cells: [a * cell + (1 - a) * BEHIND for cell in cells],
    "times": lambda k, *cells: [k * cell for cell in cells],
    "plus": lambda k, *cells: [k + cell for cell in cells],
    "mean": lambda *cells: [sum(cells) / len(cells)],
    "srgb": lambda *cells: [srgb(cell) for cell in cells],
    # the grey quad by its irradiance
    "lit": lambda irradiance: [0.5 * irradiance / math.pi],
    "lamp": lambda *values: [lamp(*values)],
    "furnace": lambda *values: [furnace(*values)],
    "plastic": lambda kd, ks, alpha: [kd + ks * furnace(0, 0, alpha**0.5)],
    "gloss": lambda share, alpha: [share * furnace(1, 1, alpha**0.5)],
    "glassy": lambda *values: [glassy(*values)],
    "glow": lambda k, factor, *cells: [k + factor * cell for cell in cells],
    # the corners of `metal.png`
    "metals": lambda base: [
        2 * base if roughness == 0 else furnace(base, metallic, roughness)
        for metallic, roughness in ((1, 1), (0, 1), (1, 0), (1, 1))
    ],
    "invert": lambda *cells: [1 - cell for cell in cells],
    # an emitting circle of half the picture's height before what is behind
    "disk": lambda radiance, r, hole=0: [
        BEHIND + (radiance - BEHIND) * math.pi * (r * r - hole * hole) / 4
    ],
}
