#!/usr/bin/env python3
"""Writes the tables of recorded claims into docs/claims.md and docs/limits.md."""

from __future__ import annotations

from pathlib import Path

from viscache.figures.claims_pages import PAGES, filled

if __name__ == "__main__":
    root = Path(__file__).resolve().parents[1]
    for page in PAGES:
        path = root / page
        path.write_text(filled(page, path.read_text("utf-8")), "utf-8")
