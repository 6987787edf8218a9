"""viscache works beside other renderers in one process, whichever is imported first."""

import importlib.util
import itertools
import re
import subprocess
import sys
from pathlib import Path

import pytest

import viscache as vc

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


def run(names):
    lines = [f"import {name}{AS.get(name, '')}" for name in names]
    code = "\n".join([*lines, *(WORK[name] for name in names), "print('all of them')"])
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0 and "all of them" in done.stdout, done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("names", list(itertools.permutations(THERE)), ids="-".join)
def test_all_of_them_work_in_any_order(names):
    run(names)


def test_what_few_calls_need_is_loaded_by_these():
    """`import viscache` stays quick: scipy would double its time."""
    code = "import sys, viscache; print(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    late = {"scipy", "xarray", "matplotlib", "skimage", "h5py", "h5netcdf", "pandas", "PIL"}
    late |= {"sqlite3", "socket", "http", "asyncio", "multiprocessing"}
    assert "numpy" in done.stdout.split()
    assert late.isdisjoint(done.stdout.split())


def test_names_load_their_modules_when_first_used():
    code = """
import sys, viscache as vc
def there(): return {name for name in sys.modules if name.startswith("viscache.")}
own = {name for name in there() if not name.startswith("viscache._core")}
assert own == {"viscache.base", "viscache.base.given"}, own
vc.load_scene
assert "viscache.scene" in there() and "viscache.sweeps" not in there()
for name in vc.__all__: getattr(vc, name)
assert {"viscache.sweeps.tune", "viscache.plots", "viscache.report"} <= there()
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_type_checkers_and_programs_see_the_same_names():
    stub = Path(vc.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    listed = re.findall(r"^from (\S+) import (\w+)", stub, re.M)
    for module in re.findall(r"^from (\S+) import \*", stub, re.M):
        listed += [(module, name) for name in importlib.import_module(module).__all__]
    assert {*vc.__all__} - {"__version__"} < {name for _, name in listed}
    for module, name in listed:
        assert getattr(vc, name) is getattr(importlib.import_module(module), name)
