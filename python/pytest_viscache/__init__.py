"""The pytest plugin of viscache: shared exact frames, and pages of pictures for failing tests.

pytest loads this module in every run of an environment that has viscache. So it stands beside the
package and imports nothing of it until a test does.
"""

from __future__ import annotations

import hashlib
import re
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from viscache.testing import ExactFrames, PictureError

__all__ = ["viscache_exact"]


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("viscache")
    group.addoption(
        "--viscache-exact",
        metavar="DIR",
        help="where exact frames are kept (default: in pytest's cache folder)",
    )
    group.addoption(
        "--viscache-pages",
        metavar="DIR",
        help="where failing tests leave their pages (default: in pytest's cache folder)",
    )


@pytest.fixture(scope="session")
def viscache_exact(pytestconfig: pytest.Config) -> ExactFrames:
    """A function like `vc.render`, for exact frames that stay on disk from run to run.

    `viscache_exact(scene, integrator, size=..., spp=..., seed=...)`: see
    `viscache.testing.ExactFrames`.
    """
    from viscache.testing import ExactFrames

    return ExactFrames(_folder(pytestconfig, "viscache_exact", "viscache-exact"))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[Any]) -> None:
    """Write the page of an assertion about pictures; its path ends the message."""
    testing = sys.modules.get("viscache.testing")
    error = None if call.excinfo is None else call.excinfo.value
    if testing is None or not isinstance(error, testing.PictureError):
        return
    if item.get_closest_marker("xfail") is None or item.config.option.runxfail:
        error.args = (f"{error}\n{_page(item, error)}",)


def _page(item: pytest.Item, error: PictureError) -> str:
    """Where the page is, or why there is none."""
    try:
        folder = _folder(item.config, "viscache_pages", "viscache-pages")
        if folder is None:
            folder = Path(tempfile.mkdtemp(prefix="viscache-pages-"))
        page = folder / _name(item.nodeid) / "diff.html"
        page.parent.mkdir(parents=True, exist_ok=True)
        written = error.write(page, title=item.name)
    except (OSError, ValueError) as problem:
        return f"the page of the difference could not be written: {problem}"
    return "" if written is None else f"difference: {written}"


def _folder(config: pytest.Config, option: str, name: str) -> Path | None:
    """The folder of an option, or one in pytest's cache; None without a cache to write to."""
    given = config.getoption(option)
    if given is not None:
        return Path(config.invocation_params.dir, given)
    if not hasattr(config, "cache") or config.cache is None:
        return None
    try:
        return config.cache.mkdir(name)
    except OSError:
        return None


def _name(nodeid: str) -> str:
    """A test's name as a folder's: readable, and different for different tests."""
    plain = re.sub(r"[^\w.-]+", "-", nodeid).strip("-.")
    if plain == nodeid and len(plain) < 100:
        return plain
    return f"{plain[-80:].lstrip('-.')}-{hashlib.sha256(nodeid.encode()).hexdigest()[:8]}"
