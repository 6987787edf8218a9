"""Virtual environments of the peers: one each, made with `python -m venv` and pip."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

#: A peer's module, also the name of its environment, and what pip installs there.
PACKAGES: dict[str, tuple[str, ...]] = {
    "mitsuba": ("numpy", "mitsuba"),
    "embreex": ("numpy", "embreex"),
    "bpy": ("numpy", "bpy==4.2.*"),
    "pyluxcore": ("numpy", "pyluxcore==2.11.*"),
}


def default_folder() -> Path:
    """`viscache/peers` in the user's folder of caches (`$XDG_CACHE_HOME`, else `~/.cache`)."""
    caches = os.environ.get("XDG_CACHE_HOME")
    return (Path(caches) if caches else Path.home() / ".cache") / "viscache" / "peers"


def interpreter(name: str, folder: Path) -> Path | None:
    """The interpreter that has a module of `PACKAGES`; None if there is none.

    That of its environment in `folder`, or the one that runs now.
    """
    own = _python(folder / name)
    if own.exists():
        return own
    return Path(sys.executable) if importlib.util.find_spec(name) is not None else None


def make_environments(folder: Path) -> dict[str, str]:
    """Make an environment for each peer, or bring it up to date.

    Parameters
    ----------
    folder : Path
        Each environment is a folder in it. pip's own settings say where packages come from.

    Returns
    -------
    dict of str
        For each name: "" if it was made, else the last line that venv or pip said.
    """
    folder.mkdir(parents=True, exist_ok=True)
    return {name: _make(folder / name, needs) for name, needs in PACKAGES.items()}


def _make(place: Path, needs: tuple[str, ...]) -> str:
    steps = (
        [sys.executable, "-m", "venv", str(place)],
        [str(_python(place)), "-m", "pip", "install", "--quiet", "--upgrade", *needs],
    )
    for step in steps:
        try:
            done = subprocess.run(step, capture_output=True, text=True)
        except OSError as error:
            return str(error)
        if done.returncode:
            said = (done.stderr or done.stdout).strip().splitlines()
            return said[-1] if said else f"{step[2]} ended with status {done.returncode}"
    return ""


def _python(place: Path) -> Path:
    return place / "bin" / "python"
