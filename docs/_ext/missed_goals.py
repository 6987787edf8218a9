"""`{missed-goals}`: the rows under docs/performance that say "missed", with their section."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from missed_rows import anchor, missed
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

PAGES = "performance"


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("missed-goals", MissedGoals)
    return {"parallel_read_safe": True}


class MissedGoals(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        folder = Path(self.env.srcdir) / PAGES
        lines = ["| section | what | result |", "| --- | --- | --- |"]
        for path in sorted(folder.glob("*.md")):
            self.env.note_dependency(str(path))
            for row in missed(path.read_text("utf-8")):
                link = f"[{row.section}]({PAGES}/{path.name}#{anchor(row.section)})"
                lines.append(f"| {link} | {row.what} | {row.words} |")
        assert len(lines) > 2, f"{folder} must have rows of missed goals"
        parent = nodes.Element()
        self.state.nested_parse(StringList(lines, "missed-goals"), 0, parent)
        return parent.children
