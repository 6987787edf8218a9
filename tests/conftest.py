"""Fixtures that every test can ask for."""

import os
import time
from pathlib import Path

import pytest

from mutants import run
from sweeps.stand_in import fake_vc, finished, without_netcdf

__all__ = ["fake_vc", "finished", "without_netcdf"]


@pytest.fixture(scope="session")
def shared_scenes():
    """Folder of scenes by other authors; tests that need it are skipped without it."""
    default = Path(__file__).resolve().parents[2] / "shared" / "scenes"
    folder = Path(os.environ.get("VISCACHE_SCENES", default))
    if not folder.is_dir():
        pytest.skip("the shared scenes are absent (set VISCACHE_SCENES to their folder)")
    return folder


@pytest.fixture(scope="session")
def room():
    """A scene that tests leave as it is."""
    from reference.built import built

    return built("room?triangles=3000")


def pytest_configure(config: pytest.Config) -> None:
    """Workers share the cores, so that not every frame of every worker uses all of them.

    Each has two at least: Mitsuba never ends loading a scene where it has one.
    """
    worker = getattr(config, "workerinput", None)
    if worker is None:
        return
    cores = sorted(os.sched_getaffinity(0))
    share = max(2, len(cores) // worker["workercount"])
    first = int(worker["workerid"].removeprefix("gw")) * share
    os.sched_setaffinity(0, {cores[(first + i) % len(cores)] for i in range(share)})


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("fuzzing")
    group.addoption("--fuzz-seconds", type=float, default=20, help="of each target; default: 20")
    group.addoption("--fuzz-cases", type=int, help="of each target at most; default: no limit")
    group.addoption("--fuzz-runs", type=int, default=-1, help="of each libFuzzer target at most")
    group.addoption("--fuzz-seed", type=int, default=0, help="of each target's first case")
    parser.addoption("--until", type=int, metavar="EPOCH", help="skip tests that begin later")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Where time may run out, files whose tests kill mutants come first."""
    if config.getoption("--until") is not None:
        files = {test.partition("::")[0] for mutant in run.catalogue() for test in mutant.tests}
        items.sort(key=lambda item: item.nodeid.partition("::")[0] not in files)


def pytest_runtest_setup(item: pytest.Item) -> None:
    until = item.config.getoption("--until")
    if until is not None and time.time() > until:
        pytest.skip("no time is left on this machine")
