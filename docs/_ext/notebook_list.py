"""`{notebook-list}`: the title and first words of every notebook, with the file beside them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("notebook-list", NotebookList)
    return {"parallel_read_safe": True}


class NotebookList(SphinxDirective):
    """Sections from the notebooks' first cells: their words have one home."""

    def run(self) -> list[nodes.Node]:
        lines: list[str] = []
        for path in sorted(FOLDER.glob("*.ipynb")):
            self.env.note_dependency(str(path))
            first = json.loads(path.read_text("utf-8"))["cells"][0]["source"]
            title, _, rest = "".join(first).partition("\n")
            lines += [f"## {title.lstrip('# ')}", "", *rest.replace("$", "").strip().splitlines()]
            lines += ["", f"Open {{download}}`{path.name} <../notebooks/{path.name}>`.", ""]
        parent = nodes.Element()
        self.state.nested_parse(StringList(lines, "notebooks"), 0, parent, match_titles=True)
        return parent.children
