"""Fixtures that every test can ask for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_scenes() -> Path:
    """Folder of scenes by other authors; tests that need it are skipped without it."""
    default = Path(__file__).resolve().parents[2] / "shared" / "scenes"
    folder = Path(os.environ.get("VISCACHE_SCENES", default))
    if not folder.is_dir():
        pytest.skip("the shared scenes are absent (set VISCACHE_SCENES to their folder)")
    return folder
