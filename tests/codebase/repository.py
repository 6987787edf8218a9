"""The files of the repository that git tracks or would track."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[2]
BUILT = {"build", "out", ".venv", "__pycache__", ".git"}


def paths(*suffixes: str, under: str = "") -> list[str]:
    """Sorted paths, relative to the root, of files with one of the suffixes (all when none)."""
    try:
        listed = subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.splitlines()
    except (OSError, subprocess.CalledProcessError):  # a source archive without git
        listed = [
            path.relative_to(ROOT).as_posix()
            for path in ROOT.rglob("*")
            if not BUILT.intersection(path.relative_to(ROOT).parts)
        ]
    return sorted(
        path
        for path in listed
        if path.startswith(under)
        and (not suffixes or path.endswith(suffixes))
        and (ROOT / path).is_file()
    )


def environment(**more: str) -> dict[str, str]:
    """For a Python that imports what this one does."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p), **more}


def module(path: str) -> ModuleType:
    """A file of the repository that no package holds, imported."""
    name = Path(path).stem
    spec = importlib.util.spec_from_file_location(name, ROOT / path)
    assert spec is not None and spec.loader is not None
    made = sys.modules[name] = importlib.util.module_from_spec(spec)  # dataclasses look there
    spec.loader.exec_module(made)
    return made


def text(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def sources(*suffixes: str, under: str = "") -> dict[str, str]:
    return {path: text(path) for path in paths(*suffixes, under=under)}
