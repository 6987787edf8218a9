"""Every notebook runs from top to bottom, in its quick form."""

import os
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "notebooks").glob("*.ipynb"))


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, monkeypatch):
    nbformat = pytest.importorskip("nbformat", reason="nbformat comes with the test extra")
    nbclient = pytest.importorskip("nbclient", reason="nbclient comes with the test extra")
    if ran := os.environ.get("VISCACHE_NOTEBOOKS_RAN"):  # by scripts/run_notebooks.py, as CI does
        notebook = nbformat.read(Path(ran) / path.name, as_version=4)
    else:
        monkeypatch.setenv("VISCACHE_QUICK", "1")
        monkeypatch.setenv("MPLBACKEND", "agg")
        notebook = nbformat.read(path, as_version=4)
        nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    outputs = [o for c in notebook.cells if c.cell_type == "code" for o in c.outputs]
    assert any(o.output_type == "stream" and o.name == "stdout" for o in outputs)
    pictures = sum("image/png" in o.get("data", {}) for o in outputs)
    assert pictures >= (2 if path.stem[:2].isdigit() else 0)
