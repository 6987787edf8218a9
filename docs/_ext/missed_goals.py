"""`{missed-goals}`: the rows of docs/performance.md that say "missed", with their section."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from missed_rows import anchor, missed
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

PAGE = "performance"


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("missed-goals", MissedGoals)
    return {"parallel_read_safe": True}


class MissedGoals(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        path = self.env.doc2path(PAGE)
        self.env.note_dependency(str(path))
        lines = ["| section | what | said |", "| --- | --- | --- |"]
        found = list(missed(Path(path).read_text("utf-8")))
        assert found, f"{path} must tell of missed goals"
        for row in found:
            link = f"[{row.section}]({PAGE}.md#{anchor(row.section)})"
            lines.append(f"| {link} | {row.what} | {row.words} |")
        parent = nodes.Element()
        self.state.nested_parse(StringList(lines, "missed-goals"), 0, parent)
        return parent.children
