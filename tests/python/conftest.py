"""Fixtures: the stand-in renderer of `fake_renderer.py` in place of the real one."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
import fake_renderer as fake


@pytest.fixture
def fake_vc(monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """`viscache` with the stand-in's settings and renderer; yields the stand-in's module."""
    import viscache
    from viscache import sources
    from viscache.sweeps import work

    for name in ("Whitted", "Embree", "Exact", "Aqvc"):
        monkeypatch.setattr(viscache, name, getattr(fake, name), raising=False)
    monkeypatch.setattr(work, "render_function", fake.fake_render)
    monkeypatch.setattr(sources, "open_scene", lambda spec, **_: fake.FakeScene(name=spec))
    fake.CALLS.clear()
    fake.STOP.clear()
    yield fake
    fake.STOP.clear()
