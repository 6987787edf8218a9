"""viscache works beside other renderers in one process, whichever is imported first."""

from __future__ import annotations

import importlib.util
import itertools
import subprocess
import sys

import pytest

#: What each of them does after all were imported: it traces a ray, or renders.
WORK = {
    "viscache": """
assert vc.render("cube_on_plane", "direct", size=(8, 8)).image.mean() > 0
assert vc.scenes.cube_on_plane().intersect([[0, 5, 0]], [[0, -1, 0]]).triangle[0] >= 0
""",
    "mitsuba": """
mi.set_variant("scalar_rgb")
scene = mi.load_dict({"type": "scene", "s": {"type": "sphere"}, "e": {"type": "constant"}})
assert scene.ray_intersect(mi.Ray3f([0, 0, 5], [0, 0, -1])).is_valid()
""",
    "embreex": """
import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
made = rtcore_scene.EmbreeScene()
mesh = TriangleMesh(made, np.float32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]))
assert made.run(np.float32([[0, 0, 1]]), np.float32([[0, 0, -1]]))[0] == 0
""",
    "torch": """
assert float(torch.ones(8, 8).matmul(torch.ones(8, 8)).sum()) == 512
""",
}
AS = {"viscache": " as vc", "mitsuba": " as mi"}
THERE = [name for name in WORK if importlib.util.find_spec(name) is not None]


def run(names: tuple[str, ...]) -> None:
    lines = [f"import {name}{AS.get(name, '')}" for name in names]
    code = "\n".join([*lines, *(WORK[name] for name in names), "print('all of them')"])
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0 and "all of them" in done.stdout, done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("names", list(itertools.permutations(THERE)), ids="-".join)
def test_all_of_them_work_in_any_order(names: tuple[str, ...]) -> None:
    run(names)


@pytest.mark.slow
@pytest.mark.parametrize("other", [name for name in WORK if name != "viscache"])
def test_two_of_them_work_in_any_order(other: str) -> None:
    if other not in THERE:
        pytest.skip(f"{other} is not installed")
    run(("viscache", other))
    run((other, "viscache"))


def test_what_few_calls_need_is_loaded_by_these() -> None:
    """`import viscache` stays quick: scipy would double its time."""
    code = "import sys, viscache; print(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    late = {"scipy", "xarray", "matplotlib", "skimage", "h5py", "h5netcdf", "pandas", "PIL"}
    assert "numpy" in done.stdout.split()
    assert late.isdisjoint(done.stdout.split())
