#!/usr/bin/env python3
"""Thumbnails of the gallery: scripts/gallery_thumbnails.py DIR
Run `viscache reproduce NAME --quick -o DIR` before, or `all`. Figures that are not in it keep their
thumbnail. manifest.json notes which `thumbnail` made each, and when its figure was run."""

from __future__ import annotations

import argparse
import hashlib
import inspect
import io
import json
from pathlib import Path
from typing import Any

from PIL import Image

from viscache_lab.figures import FIGURES

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "gallery" / "thumbnails"
MANIFEST = "manifest.json"
SIZE_PX = (360, 270)


def thumbnail(picture: Path) -> bytes:
    """A small WebP of a figure's picture."""
    out = io.BytesIO()
    with Image.open(picture) as image:
        small = image.convert("RGB")
        small.thumbnail(SIZE_PX)
        small.save(out, "WEBP", quality=75, method=6)
    return out.getvalue()


def recipe(name: str) -> str:
    """What a thumbnail depends on here: its figure, and how it is made."""
    made_by = f"{SIZE_PX} {inspect.getsource(thumbnail)}"
    return digest((made_by + FIGURES[name].description).encode())


def digest(data: bytes) -> str:
    """SHA-256 in the first 16 digits."""
    return hashlib.sha256(data).hexdigest()[:16]


def main() -> None:
    """Make the thumbnails of all figures that have a picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, metavar="DIR")
    results: Path = parser.parse_args().results
    made = json.loads((FOLDER / MANIFEST).read_text("utf-8"))
    for name in (name for name in FIGURES if (results / f"{name}.json").exists()):
        found = json.loads((results / f"{name}.json").read_text("utf-8"))
        files = [Path(file).name for file in found["files"] if file.endswith(".png")]
        entry: dict[str, Any] = {"recipe": recipe(name), "date": found["provenance"]["date"]}
        if files:
            data = thumbnail(results / files[0])
            (FOLDER / f"{name}.webp").write_bytes(data)
            entry["picture"] = digest(data)
        made[name] = entry
    kept = {name: made[name] for name in FIGURES if name in made}
    (FOLDER / MANIFEST).write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
