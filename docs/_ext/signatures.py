"""The API as people write and read it: signatures, code in docstrings, what is left out."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.domains.python import PyXRefRole
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode

_INNER = r"((?:[^\[\]]|\[[^\[\]]*\])+)"
_NUMBER = r"typing\.Supports(Float|Int) \| typing\.SupportsIndex"
#: What annotations expand to, and what the sources say.
SHORT = [
    (re.compile(pattern), plain)
    for pattern, plain in (
        (r"\(self: [\w.]+(?:, |(?=\)))", "("),  # the first line of pybind11's docstrings
        (r'typing\.Annotated\[collections\.abc\.Sequence\[[^\[\]]*\], "FixedSize\(3\)"\]', "Vec3"),
        (r"typing\.Annotated\[numpy\.typing\.ArrayLike, numpy\.\w+\]", "ArrayLike"),
        (r"typing\.Annotated\[numpy\.typing\.NDArray\[([\w.]+)\][^\]]*\]", r"NDArray[\1]"),
        (_NUMBER, lambda found: found[1].lower()),
        (r"<(\w+\.\w+): \d+>", r"\1"),
        (r"(\d\.\d{1,4}[1-9])0000\d+", r"\1"),  # 0.1 in single precision
        (
            r"~?numpy\.ndarray\[tuple\[~?typing\.Any, \.\.\.\], ~?numpy\.dtype\["
            + _INNER
            + r"\]\]",
            r"NDArray[\1]",
        ),
        (r"[~\w.]*_Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]", "ArrayLike"),
        (r"<factory>", "..."),
        (r"(?<![\w.~])(?:viscache\.)?_core\.Camera\b", "~viscache._core.Camera"),
        (
            r"\b(?:numpy|np|npt|typing|xarray|collections\.abc|concurrent\.futures)\.(?=[A-Za-z_])",
            "",
        ),
    )
]
SHOWN_ARRAY = re.compile(r"ndarray\[tuple\[Any, \.\.\.\], dtype\[" + _INNER + r"\]\]")
#: Settings turn themselves into those of the core: nothing for users.
GLUE = {
    "corrected",
    "core",
    "build",
    "estimate",
    "map_settings",
    "for_frame_table",
    "for_kept_table",
    "source",
}
#: A built-in scene is written as a function that returns a `Builder`; called, it returns a Scene.
BUILDERS = ("Builder", "~viscache.scenes.builder.Builder", "viscache.scenes.builder.Builder")
#: Things whose docstring has no sections: "N: text" is not a type.
PLAIN = {"attribute", "property", "data"}


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_role_to_domain("py", "known", Known())
    app.connect("autodoc-process-signature", shorten)
    app.connect("autodoc-skip-member", skip)
    kept: dict[str, list[str]] = {}
    # Around napoleon, which has priority 500
    app.connect("autodoc-process-docstring", lambda *a: keep(kept, *a), priority=400)
    app.connect("autodoc-process-docstring", lambda *a: put_back(kept, *a), priority=600)
    app.connect("doctree-read", shorten_arrays)
    app.connect("missing-reference", from_package)
    return {"parallel_read_safe": True}


class Known(PyXRefRole):
    """`name` in a docstring: a link where the pages have such a name, else code."""

    def __call__(self, name: str, rawtext: str, text: str, *rest: Any, **more: Any) -> Any:
        if re.fullmatch(r"[A-Za-z_][\w.]*(?:\(\))?", text):
            return super().__call__("py:obj", rawtext, text, *rest, **more)
        return [nodes.literal(rawtext, nodes.unescape(text))], []


def from_package(
    app: Sphinx, env: BuildEnvironment, node: addnodes.pending_xref, shown: nodes.Element
) -> nodes.reference | None:
    """`Aqvc` and `vc.Aqvc()` in the docstring of another module are `viscache.Aqvc`."""
    if node.get("reftype") != "obj":
        return None
    name = "viscache." + node["reftarget"].removeprefix("vc.").removesuffix("()")
    found = env.get_domain("py").objects.get(name)  # type: ignore[attr-defined]
    if found is None:
        return None
    return make_refnode(app.builder, node["refdoc"], found.docname, found.node_id, shown, name)


def shorten(
    app: Sphinx,
    what: str,
    name: str,
    found: Any,
    options: Any,
    signature: str | None,
    returns: str | None,
) -> tuple[str | None, str | None]:
    signature, returns = _short(signature), _short(returns)
    return signature, "~viscache.Scene" if returns in BUILDERS else returns


def _short(text: str | None) -> str | None:
    for pattern, plain in SHORT if text else ():
        text = pattern.sub(plain, text or "")
    return text


def shorten_arrays(app: Sphinx, doctree: nodes.document) -> None:
    """Types of properties and attributes, which no event offers as text."""
    for node in doctree.findall(addnodes.desc_annotation):
        if SHOWN_ARRAY.search(node.astext()):
            node[:] = [nodes.Text(SHOWN_ARRAY.sub(r"NDArray[\1]", node.astext()))]


def skip(app: Sphinx, what: str, name: str, found: Any, skipped: bool, options: Any) -> bool | None:
    return True if what == "class" and name in GLUE else None


def keep(
    kept: dict[str, list[str]],
    app: Sphinx,
    what: str,
    name: str,
    found: Any,
    options: Any,
    lines: list[str],
) -> None:
    if what in PLAIN:
        kept[name] = list(lines)


def put_back(
    kept: dict[str, list[str]],
    app: Sphinx,
    what: str,
    name: str,
    found: Any,
    options: Any,
    lines: list[str],
) -> None:
    if what in PLAIN:
        lines[:] = kept.pop(name)
