"""Fixtures: the stand-in renderer of `fake_renderer.py` in place of the real one."""

import csv
import importlib
from pathlib import Path

import pytest

from sweeps import fake_renderer as fake


def rows_of(directory: Path) -> list[dict[str, str]]:
    """Of a sweep's table."""
    with (directory / "table.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def install(patch: pytest.MonkeyPatch) -> None:
    """Give viscache the stand-in's settings and renderer."""
    from viscache.scenes import sources
    from viscache.settings import by_name
    from viscache.sweeps import work

    for role, name, settings in fake.NAMES:
        patch.setitem(by_name.NAMES[role], name, settings)
    patch.setattr(work, "render_function", fake.fake_render)
    patch.setattr(sources, "open_scene", lambda spec, **_: fake.FakeScene(name=spec))


@pytest.fixture
def fake_vc(monkeypatch):
    """viscache with the stand-in; yields the stand-in's module."""
    install(monkeypatch)
    fake.CALLS.clear()
    fake.STOP.clear()
    yield fake
    fake.STOP.clear()


@pytest.fixture
def without_netcdf(monkeypatch):
    """Sweeps write no `table.nc`, which takes longer than all else of a small one."""
    module = importlib.import_module("viscache.sweeps.sweep")
    monkeypatch.setattr(module, "write_table", lambda *_: None)


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """The folder of a finished sweep, to be copied."""
    from base.kept_formats import swept

    folder = tmp_path_factory.mktemp("finished")
    swept(folder)
    return folder
