"""Fails the build where a page needs something from elsewhere: scripts, styles, fonts, pictures."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

#: Tag → attributes whose target a browser fetches by itself. Links that a reader follows are free.
FETCHED = {
    "script": ("src",),
    "link": ("href",),
    "img": ("src", "srcset"),
    "iframe": ("src",),
    "source": ("src", "srcset"),
    "video": ("src",),
    "audio": ("src",),
    "object": ("data",),
}
ELSEWHERE = re.compile(r"\s*(?:https?:)?//", re.I)
IN_STYLE = re.compile(r"(?:url\(|@import)\s*[\"']?((?:https?:)?//[^\"')\s]+)", re.I)


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def check(app: Sphinx, error: Exception | None) -> None:
    from sphinx.errors import ExtensionError

    if error is None and app.builder.format == "html":
        found = [
            f"{path.relative_to(app.outdir)}: {target}"
            for path in sorted(Path(app.outdir).rglob("*"))
            if path.suffix in (".html", ".css")
            for target in outside(path.read_text("utf-8"), path.suffix)
        ]
        if found:
            raise ExtensionError("pages need what lies elsewhere:\n" + "\n".join(found))


def outside(text: str, suffix: str) -> Iterator[str]:
    """What a page (.html) or a style (.css) fetches from another place."""
    if suffix == ".css":
        yield from IN_STYLE.findall(text)
        return
    page = _Page()
    page.feed(text)
    yield from page.found


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self._in_style = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self._in_style = tag == "style"
        canonical = tag == "link" and given.get("rel") in ("canonical", "alternate", "author")
        names = () if canonical else FETCHED.get(tag, ())
        targets = [given[name] or "" for name in names if name in given]
        self.found += [target for target in targets if ELSEWHERE.match(target)]
        self.found += IN_STYLE.findall(given.get("style") or "")

    def handle_data(self, data: str) -> None:
        if self._in_style:
            self.found += IN_STYLE.findall(data)

    def handle_endtag(self, tag: str) -> None:
        self._in_style = False
