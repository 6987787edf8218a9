"""Fixtures: the stand-in renderer of `fake_renderer.py` in place of the real one."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture
def fake_vc(monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """viscache with the stand-in's settings and renderer; yields the stand-in's module."""
    from sweeps import fake_renderer as fake
    from viscache.scenes import sources
    from viscache.settings import by_name
    from viscache.sweeps import work

    for role, name, settings in fake.NAMES:
        monkeypatch.setitem(by_name.NAMES[role], name, settings)
    monkeypatch.setattr(work, "render_function", fake.fake_render)
    monkeypatch.setattr(sources, "open_scene", lambda spec, **_: fake.FakeScene(name=spec))
    fake.CALLS.clear()
    fake.STOP.clear()
    yield fake
    fake.STOP.clear()


@pytest.fixture
def without_netcdf(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps write no `table.nc`, which takes longer than all else of a small one."""
    module = importlib.import_module("viscache.sweeps.sweep")
    monkeypatch.setattr(module, "write_table", lambda *_: None)


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished sweep, to be copied."""
    from base.kept_formats import swept

    folder = tmp_path_factory.mktemp("finished")
    swept(folder)
    return folder
