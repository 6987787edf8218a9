"""`{notebook-list}`: every notebook with its first words, its cells folded, and the file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
#: What TeX writes and these notebooks use; pages of this site load no script for formulas.
TEX = {r"\times": "×", r"\rho": "ρ", r"\theta": "θ", r"\alpha": "α", r"\bar": "mean "}


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("notebook-list", NotebookList)
    return {"parallel_read_safe": True}


class NotebookList(SphinxDirective):
    """Sections from the notebooks themselves: their words have one home."""

    def run(self) -> list[nodes.Node]:
        lines: list[str] = []
        for path in sorted(FOLDER.glob("*.ipynb")):
            self.env.note_dependency(str(path))
            cells = json.loads(path.read_text("utf-8"))["cells"]
            title, _, rest = "".join(cells[0]["source"]).partition("\n")
            lines += [f"## {title.lstrip('# ')}", "", *plain(rest), ""]
            lines += [":::{dropdown} Its cells", "", *(x for c in cells[1:] for x in shown(c))]
            lines += [":::", "", f"File: {{download}}`{path.name} <../notebooks/{path.name}>`", ""]
        parent = nodes.Element()
        self.state.nested_parse(StringList(lines, "notebooks"), 0, parent, match_titles=True)
        return parent.children


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
