"""Removes outputs and execution counts from the notebooks given; exits 1 when one was changed."""

import json
import sys
from pathlib import Path


def strip(path: Path) -> bool:
    """Whether the notebook at `path` held outputs; it does not afterwards."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    changed = False
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code" and (cell["outputs"] or cell["execution_count"] is not None):
            cell["outputs"], cell["execution_count"], changed = [], None, True
    if changed:
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return changed


if __name__ == "__main__":
    sys.exit(any([strip(Path(name)) for name in sys.argv[1:]]))
