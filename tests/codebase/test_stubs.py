"""The committed type stubs of the C++ module are the ones its bindings give."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from codebase.repository import ROOT, paths, text

STUBS = "python/viscache/_core/"


@pytest.mark.skipif(
    importlib.util.find_spec("pybind11_stubgen") is None, reason="pybind11-stubgen is not installed"
)
def test_stubs_are_current(tmp_path):
    """Where this fails, run scripts/stubs and commit what it writes."""
    made = subprocess.run(
        [ROOT / "scripts/stubs", tmp_path],
        env={**os.environ, "PYTHON": sys.executable},
        capture_output=True,
        text=True,
    )
    assert made.returncode == 0, made.stderr
    written = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.pyi")}
    committed = {path.removeprefix(STUBS): text(path) for path in paths(".pyi", under=STUBS)}
    assert written.keys() == committed.keys()
    stale = [name for name in written if written[name] != committed[name]]
    assert stale == [], "run scripts/stubs"


def test_every_submodule_has_a_stub():
    import types

    import viscache._core as core

    submodules = {name for name, found in vars(core).items() if isinstance(found, types.ModuleType)}
    stubs = {Path(path).stem for path in paths(".pyi", under=STUBS)}
    assert stubs == submodules | {"__init__"}
