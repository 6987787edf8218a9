"""The tables of docs/claims.md and docs/limits.md that come from the recorded runs."""

from __future__ import annotations

from viscache.figures import recorded

__all__ = ["PAGES", "filled"]

#: Page to the tables between its comments `<!-- name -->` and `<!-- end of name -->`.
PAGES: dict[str, dict[str, str]] = {
    "docs/claims.md": {
        "rules": recorded.rules(),
        "runs": recorded.runs(),
        "aqvc": recorded.claims("aqvc"),
        "vlf": recorded.claims("vlf"),
        "vismap": recorded.claims("vismap"),
        "not recorded": recorded.not_recorded(),
    },
    "docs/limits.md": {"claims not found": recorded.table()},
}


def filled(page: str, text: str) -> str:
    """The page's text with its tables as they must be.

    Raises
    ------
    ValueError
        The text lacks a pair of comments.
    """
    for name, table in PAGES[page].items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        if begin not in text or end not in text:
            raise ValueError(f"{page} must have the comments of {name!r}")
        before, _, rest = text.partition(begin)
        text = before + begin + table + end + rest.partition(end)[2]
    return text
