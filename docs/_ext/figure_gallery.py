"""`{figure-gallery} aqvc`: every figure of one paper, with its results where there are some.

Results are those of `viscache reproduce all -o DIR`, given as `scripts/docs --figures DIR`. Without
them the figures are listed with what they show and the command that makes them.
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from PIL import Image
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

from viscache_lab.experiment import Experiment
from viscache_lab.figures import FIGURES

#: Pictures wider than this are shrunk: pages should open at once.
WIDTH_PX = 1400
#: Small pictures of a quick run, by scripts/gallery_thumbnails.py.
THUMBNAILS = Path(__file__).resolve().parents[1] / "gallery" / "thumbnails"
#: Longer tables are folded, except for the rows that do not hold.
MOST_ROWS = 8
NO_RESULTS = (
    "This copy of the site was built without results, so it lists the figures with small pictures "
    "of a quick run. "
    "`scripts/docs --figures DIR` shows results of `viscache reproduce all -o DIR`."
)
QUICK_RUN = (
    "A quick run takes seconds per figure, with small scenes and pictures. It shows what a figure "
    "looks like. Do not quote its numbers; [Performance](/performance.md) has those of full runs."
)
log = logging.getLogger(__name__)


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_config_value("viscache_figures", "", "env")
    app.add_directive("figure-gallery", FigureGallery)
    app.add_directive("figure-summary", FigureSummary)
    app.add_directive("figure-cards", FigureCards)
    app.add_transform(FigureNames)
    return {"parallel_read_safe": True}


class FigureNames(SphinxTransform):
    """The cards refer to a figure's section by its name."""

    default_priority = 840  # before Sphinx collects what can be referred to

    def apply(self, **_: Any) -> None:
        for section in self.document.findall(nodes.section):
            name = section.next_node(nodes.title).astext().partition(":")[0]
            if self.env.docname.startswith("gallery/") and name in FIGURES:
                section["names"].append(name)
                section["ids"].insert(0, name)
                self.document.note_explicit_target(section)


class FigureSummary(SphinxDirective):
    """Where the pictures on this page come from, and how many bands hold."""

    def run(self) -> list[nodes.Node]:
        found = [r for name in FIGURES if (r := result(self.config.viscache_figures, name))]
        if not found:
            return markdown(self, [NO_RESULTS])
        rows = [row for r in found for row in r["rows"] if row["holds"] is not None]
        kind = "quick" if all(r["quick"] for r in found) else "full"
        made = found[0]["provenance"]
        held = sum(row["holds"] for row in rows)
        summary = (
            f"Below: a {kind} run of viscache {made['viscache']} with Embree {made['embree']}"
            f" ({made['isa']}), {len(found)} figures and tables, {held} of {len(rows)} bands hold. "
        )
        return markdown(self, [summary + (QUICK_RUN if kind == "quick" else "")])


class FigureCards(SphinxDirective):
    """A card for every figure of one paper, with its first picture."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        lines = ["::::{grid} 2 2 3 4", ":gutter: 2", ""]
        for name, info in chosen(self.arguments[0]):
            found = result(self.config.viscache_figures, name)
            lines += [f":::{{grid-item-card}} {name}", f":link: {name}", ":link-type: ref"]
            lines.append(f":link-alt: {name}")
            if shown := self._thumbnail(name, pictures(found)):
                lines += [f":img-bottom: {shown}", ":class-img-bottom: thumbnail"]
                lines.append(f":img-alt: {name}: {info.description}")
            lines += ["", info.description, ":::", ""]
        return markdown(self, [*lines, "::::"])

    def _thumbnail(self, name: str, files: list[str]) -> str:
        """The first picture of a result; without results, the small one kept with the pages."""
        if files:
            return picture(self, files[0])
        kept = THUMBNAILS / f"{name}.webp"
        if not kept.is_file():
            return ""
        self.env.note_dependency(str(kept))
        page = Path(self.env.doc2path(self.env.docname)).parent
        return Path(os.path.relpath(kept, page)).as_posix()


class FigureGallery(SphinxDirective):
    """Sections of the figures whose names begin with the argument."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        lines: list[str] = []
        for name, info in chosen(self.arguments[0]):
            lines += self._section(name, info)
        return markdown(self, lines)

    def _section(self, name: str, info: Experiment) -> list[str]:
        found = result(self.config.viscache_figures, name)
        quick = " --quick" if found and found["quick"] else ""
        lines = [f"## {name}: {info.description}", ""]
        lines += ["```sh", f"viscache reproduce {name} -o DIR{quick}", "```", ""]
        if found is None:
            return lines
        if "error" in found:
            log.warning("%s ended with an error: %s", name, found["error"])
        for file in pictures(found):
            lines += [f"![{name}: {info.description}]({picture(self, file)})", ""]
        lines += table(found["rows"]) + [text for note in found["notes"] for text in (note, "")]
        for left in found["skipped"]:
            lines += [f"Left out: {left['what']}: {left['reason']}", ""]
        return lines


def chosen(paper: str) -> list[tuple[str, Experiment]]:
    """The figures of a paper."""
    return [(n, i) for n, i in FIGURES.items() if n.partition("-")[0] == paper]


def pictures(found: dict[str, Any] | None) -> list[str]:
    """Names of a result's pictures."""
    return [Path(file).name for file in found["files"] if file.endswith(".png")] if found else []


def picture(directive: SphinxDirective, name: str) -> str:
    """A small copy of a result's picture, as a path from the page."""
    env = directive.env
    source = Path(directive.config.viscache_figures) / name
    env.note_dependency(str(source))
    folder = Path(env.app.doctreedir) / "gallery"
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / f"{source.stem}.webp"
    with Image.open(source) as image:
        shown = image.convert("RGB")
        shown.thumbnail((WIDTH_PX, 4 * WIDTH_PX))
        shown.save(copy, "WEBP", quality=90)
    return Path(os.path.relpath(copy, Path(env.doc2path(env.docname)).parent)).as_posix()


def markdown(directive: SphinxDirective, lines: list[str]) -> list[nodes.Node]:
    """Nodes of lines of Markdown, sections among them."""
    parent = nodes.Element()
    directive.state.nested_parse(StringList(lines, "gallery"), 0, parent, match_titles=True)
    return parent.children


def result(folder: str, name: str) -> dict[str, Any] | None:
    """What a run left of a figure."""
    path = Path(folder) / f"{name}.json"
    if not folder or not path.is_file():
        return None
    found: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return found


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Markdown of rows; long tables fold all but what does not hold."""
    if not rows:
        return []
    missed = [row for row in rows if row["holds"] is False]
    if len(rows) <= MOST_ROWS:
        return _lines(rows)
    banded = sum(row["holds"] is not None for row in rows)
    title = f"{len(rows)} rows, {banded - len(missed)} of {banded} bands hold"
    folded = [f":::{{dropdown}} {title}", "", *_lines(rows), ":::", ""]
    return (["Does not hold:", "", *_lines(missed)] if missed else []) + folded


def _lines(rows: list[dict[str, Any]]) -> list[str]:
    lines = ["| what | printed | measured | band | holds |", "| --- | ---: | ---: | --- | --- |"]
    for row in rows:
        band = (
            ""
            if row["band"] is None
            else " … ".join(
                number(end, sign) for end, sign in zip(row["band"], ("−∞", "∞"), strict=True)
            )
        )
        holds = {None: "", True: "yes", False: "**no**"}[row["holds"]]
        cells = [row["what"], number(row["printed"]), number(row["measured"]), band, holds]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return [*lines, ""]


def number(value: Any, missing: str = "") -> str:
    """Four digits; an open end of a band is infinite."""
    if value is None or isinstance(value, str):
        return value or missing
    return missing if math.isinf(value) else f"{value:.4g}"
