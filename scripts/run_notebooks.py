"""Run the notebooks in their quick form and keep them with outputs: run_notebooks.py DIR.

`scripts/docs --notebooks DIR` shows what they print and draw.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import nbclient
import nbformat

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"


def main() -> int:
    """Return 1 if a notebook raised an error; the others are run all the same."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    os.environ.update(VISCACHE_QUICK="1", MPLBACKEND="agg")
    failed = 0
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        notebook = nbformat.read(path, as_version=4)
        try:
            nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
        except nbclient.exceptions.CellExecutionError as error:
            print(f"{path.name}: {error}", file=sys.stderr)
            failed = 1
            continue
        nbformat.write(notebook, folder / path.name)
        print(f"[viscache] ran {path.name}", file=sys.stderr)
    return failed


if __name__ == "__main__":
    sys.exit(main())
