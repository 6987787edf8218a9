#!/usr/bin/env python3
"""Pictures of the documentation: scripts/doc_pictures.py [NAME …] [-o FOLDER]
All are of built-in scenes and of the pages' own examples. pictures.json notes by which text of
scripts/pictures each was made; tests/docs/test_pictures.py holds pictures and text together."""

from __future__ import annotations

import argparse
import hashlib
import inspect
import io
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

sys.path.insert(0, str(Path(__file__).parent))
from pictures import howtos, methods, pages

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "images"
MANIFEST = "pictures.json"
DPI = 120
#: Says where something is, not what a picture shows.
IMPORT = re.compile(r"^(?:from|import) [^(\n]*(?:\([^)]*\))?\n", re.M)

#: By name: functions that give a matplotlib figure, or the picture of a page in a browser.
PICTURES: dict[str, Callable[[], Any]] = methods.PICTURES | howtos.PICTURES | pages.PICTURES
#: Those that need chromium.
OF_BROWSERS = frozenset(pages.PICTURES)


def recipe(name: str) -> str:
    """SHA-256 of the file that makes a picture without its imports, in the first 16 digits."""
    text = Path(inspect.getsourcefile(PICTURES[name]) or "").read_text("utf-8")
    return digest(IMPORT.sub("", text).encode())


def digest(data: bytes) -> str:
    """SHA-256 in the first 16 digits."""
    return hashlib.sha256(data).hexdigest()[:16]


def webp(made: Any) -> bytes:
    """A figure on white, as both themes of the site show it, or a picture as it is."""
    if not isinstance(made, Image.Image):
        png = io.BytesIO()
        made.savefig(png, dpi=DPI, facecolor="white", bbox_inches="tight")
        made = Image.open(png)
    out = io.BytesIO()
    made.convert("RGB").save(out, "WEBP", quality=75, method=6)
    return out.getvalue()


def main() -> None:
    """Make the pictures named, or all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *PICTURES], metavar="NAME")
    parser.add_argument("-o", type=Path, default=FOLDER, metavar="FOLDER")
    given = parser.parse_args()
    given.o.mkdir(parents=True, exist_ok=True)
    path = given.o / MANIFEST
    made = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    for name in given.names or PICTURES:
        data = webp(PICTURES[name]())
        (given.o / f"{name}.webp").write_bytes(data)
        made[name] = {"recipe": recipe(name), "picture": digest(data)}
        print(name, len(data), "bytes")
    path.write_text(json.dumps(dict(sorted(made.items())), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
