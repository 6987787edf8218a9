"""`{notebook-list}`: every notebook with its first words, its cells folded, and the file.

Cells have their outputs where `scripts/docs --notebooks DIR` names a folder of notebooks that ran.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
import os
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from PIL import Image
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
#: What TeX writes and these notebooks use; pages of this site load no script for formulas.
TEX = {r"\times": "×", r"\rho": "ρ", r"\theta": "θ", r"\alpha": "α", r"\bar": "mean "}


#: Longer outputs are cut; pictures wider than this are shrunk.
MOST_LINES = 30
WIDTH_PX = 1000


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_config_value("viscache_notebooks", "", "env")
    app.add_directive("notebook-list", NotebookList)
    return {"parallel_read_safe": True}


class NotebookList(SphinxDirective):
    """Sections from the notebooks themselves: their words have one home."""

    def run(self) -> list[nodes.Node]:
        lines: list[str] = []
        for path in sorted(FOLDER.glob("*.ipynb")):
            self.env.note_dependency(str(path))
            ran = Path(self.config.viscache_notebooks) / path.name
            has_outputs = bool(self.config.viscache_notebooks) and ran.is_file()
            cells = json.loads((ran if has_outputs else path).read_text("utf-8"))["cells"]
            title, _, rest = "".join(cells[0]["source"]).partition("\n")
            lines += [f"## {title.lstrip('# ')}", "", *plain(rest), ""]
            title = "Its cells, with the outputs of a quick run" if has_outputs else "Its cells"
            lines += [f":::{{dropdown}} {title}", ""]
            for cell in cells[1:]:
                lines += shown(cell)
                for output in cell.get("outputs", ()):
                    lines += self._output(output)
            lines += [":::", "", f"File: {{download}}`{path.name} <../notebooks/{path.name}>`", ""]
        parent = nodes.Element()
        self.state.nested_parse(StringList(lines, "notebooks"), 0, parent, match_titles=True)
        return parent.children

    def _output(self, output: dict[str, Any]) -> list[str]:
        """Markdown of what a cell printed or drew; widgets are left out."""
        data = output.get("data", {})
        if "application/vnd.jupyter.widget-view+json" in data:
            return []
        if "image/png" in data:
            return [f"![What the cell above draws]({self._picture(data['image/png'])})", ""]
        if output.get("name") == "stderr":
            return []
        text = "".join(output.get("text") or data.get("text/plain") or "")
        lines = text.rstrip().splitlines()
        cut = ["…"] if len(lines) > MOST_LINES else []
        return ["```text", *lines[:MOST_LINES], *cut, "```", ""] if lines else []

    def _picture(self, encoded: str) -> str:
        """A small copy of a picture, as a path from the page."""
        folder = Path(self.env.app.doctreedir) / "notebooks"
        folder.mkdir(parents=True, exist_ok=True)
        raw = base64.b64decode("".join(encoded))
        copy = folder / f"{hashlib.sha256(raw).hexdigest()[:16]}.webp"
        with Image.open(io.BytesIO(raw)) as image:
            kept = image.convert("RGB")
            kept.thumbnail((WIDTH_PX, 4 * WIDTH_PX))
            kept.save(copy, "WEBP", quality=90)
        page = Path(self.env.doc2path(self.env.docname)).parent
        return Path(os.path.relpath(copy, page)).as_posix()


def shown(cell: dict[str, Any]) -> list[str]:
    """Markdown of one cell."""
    text = "".join(cell["source"])
    if cell["cell_type"] == "code":
        return ["```python", *text.splitlines(), "```", ""]
    return [re.sub(r"^#+ (.*)", r"**\1**", line) for line in plain(text)] + [""]


def plain(text: str) -> list[str]:
    """Formulas in letters."""
    for tex, letter in TEX.items():
        text = text.replace(tex, letter)
    return text.replace("$", "").strip().splitlines()
