"""Links from the pages into the sources: every source that a page names gets a page of its own.

A link to a file outside of docs/, a path in a cell of a table or in code, whole or from
`cpp/viscache` on (`aqvc/hash.h`), and a dotted name of docs/papers.md lead to the highlighted file,
at the line where the equation's tag or the name stands.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, get_lexer_for_filename
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

ROOT = Path(__file__).resolve().parents[2]
#: Where a path in running text may begin.
BASES = ("", "cpp/viscache/")
TOP = ("cpp", "python", "tests", "scripts", "notebooks", ".ci")
PAGES = "_source/"
PATH = re.compile(r"[\w.-]+(?:/[\w.-]+)+")
NAME = re.compile(r"viscache(?:_lab)?(?:\.\w+)+")
#: What all names of a column begin with.
SHOWN = re.compile(r"^(?:cpp/viscache/|tests/|viscache(?:_lab)?\.)")
TAG = re.compile(r"(?:AQVC|VLF|VisMap) (?:Eq\.|Alg\.) \d+")


def setup(app: Sphinx) -> dict[str, Any]:
    # Before Sphinx collects files to download
    app.connect("doctree-read", link_files, priority=100)
    app.connect("doctree-resolved", link_names)
    app.connect("html-collect-pages", pages)
    app.connect("env-purge-doc", lambda app, env, name: named(env).pop(name, None))
    app.connect("env-merge-info", merge)
    return {"parallel_read_safe": True, "parallel_write_safe": False}


def named(env: BuildEnvironment) -> dict[str, set[str]]:
    """Which sources each page names."""
    if not hasattr(env, "viscache_sources"):
        env.viscache_sources = {}  # type: ignore[attr-defined]
    return env.viscache_sources  # type: ignore[attr-defined,no-any-return]


def merge(app: Sphinx, env: BuildEnvironment, names: set[str], other: BuildEnvironment) -> None:
    named(env).update({n: s for n, s in named(other).items() if n in names})


def link_files(app: Sphinx, doctree: nodes.document) -> None:
    """Links to files outside of docs/, and paths in code."""
    page = app.env.docname
    for node in list(doctree.findall(addnodes.download_reference)):
        file = (Path(app.srcdir) / page).parent.joinpath(node["reftarget"]).resolve()
        elsewhere = file.is_relative_to(ROOT) and not file.is_relative_to(app.srcdir)
        if elsewhere and file.is_file() and file.suffix != ".ipynb":
            path = file.relative_to(ROOT).as_posix()
            node.replace_self(_reference(app, page, path, None, node.astext()))
    for literal in list(doctree.findall(nodes.literal)):
        if isinstance(literal.parent, nodes.reference):
            continue
        if path := _existing(literal.astext()):
            reference = _reference(app, page, path, None, "")
            literal.replace_self(reference)
            reference += literal


def link_names(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """The map of the papers: homes, Python names and tests in its tables."""
    if page != "papers":
        return
    for row in doctree.findall(nodes.row):
        tag = TAG.search(row.astext())
        row[0]["classes"].append("item")
        for entry in row.findall(nodes.entry):
            text = entry.astext().strip()
            if path := _existing(text):
                line = _line(path, re.escape(f"[{tag[0]}]")) if tag else None
                _fill(entry, _reference(app, page, path, line, SHOWN.sub("", text)))
            elif NAME.fullmatch(text):
                _fill(entry, _api(app, page, text) or _definition(app, page, text))


def _fill(entry: nodes.entry, reference: nodes.reference | None) -> None:
    if reference is not None:
        entry[:] = [nodes.paragraph("", "", reference)]


def _existing(text: str) -> str | None:
    """The path from the root that a text names, if there is such a source."""
    if not PATH.fullmatch(text):
        return None
    for base in BASES:
        path = base + text
        if path.split("/")[0] in TOP and (ROOT / path).is_file():
            return path
    return None


def _line(path: str, pattern: str) -> int | None:
    for number, line in enumerate((ROOT / path).read_text("utf-8").splitlines(), 1):
        if re.search(pattern, line):
            return number
    return None


def _reference(app: Sphinx, page: str, path: str, line: int | None, text: str) -> nodes.reference:
    named(app.env).setdefault(page, set()).add(path)
    target = posixpath.relpath(PAGES + path + ".html", posixpath.dirname(page) or ".")
    if line is not None:
        target += f"#L-{line}"
    return nodes.reference("", text, internal=True, refuri=target)


def _api(app: Sphinx, page: str, name: str) -> nodes.reference | None:
    """A name that the API pages document."""
    found = app.env.get_domain("py").objects.get(name)  # type: ignore[attr-defined]
    if found is None or app.builder.format != "html":
        return None
    target = app.builder.get_relative_uri(page, found.docname) + "#" + found.node_id
    return nodes.reference("", SHOWN.sub("", name), internal=True, refuri=target)


def _definition(app: Sphinx, page: str, name: str) -> nodes.reference | None:
    """The line that defines a name the API pages leave out: a stub of the core, a figure."""
    *parts, last = name.split(".")
    base = "python/" + "/".join(parts)
    pattern = rf"^(?:def|class) {last}\b|^{last}\b.*="
    for path in (base + ".py", base + ".pyi", base + "/__init__.py", base + "/__init__.pyi"):
        if (ROOT / path).is_file() and (line := _line(path, pattern)):
            return _reference(app, page, path, line, SHOWN.sub("", name))
    return None


def pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    for path in sorted(set().union(*named(app.env).values())):
        text = (ROOT / path).read_text("utf-8")
        try:
            lexer = get_lexer_for_filename(path)
        except ClassNotFound:
            lexer = TextLexer()
        shown = highlight(text, lexer, HtmlFormatter(lineanchors="L", cssclass="highlight"))
        body = f'<section><h1><code class="literal">{path}</code></h1>{shown}</section>'
        yield PAGES + path, {"title": path, "body": body, "parents": []}, "page.html"
