"""libFuzzer on the loaders and the pictures, with address and undefined behaviour sanitizers.

The targets (`tests/cpp/fuzz`) need clang: `cmake --preset fuzz && cmake --build --preset fuzz`.
"""

import os
import re
import subprocess
import tempfile
from pathlib import Path

import pytest

from fuzz.readers import CORPUS

BUILT = Path(__file__).resolve().parents[2] / "build" / "fuzz"
TARGETS = sorted(path.name for path in CORPUS.iterdir())


def run(name, corpus, folder, *options):
    """One run of a target; new inputs and findings lie in the folder."""
    target = BUILT / name
    if not target.exists():
        pytest.skip("the targets of libFuzzer are not built: cmake --build --preset fuzz (clang)")
    (folder / "found").mkdir(exist_ok=True)
    memory = Path("/dev/shm")  # loaders read files: there they are written at once
    scratch = tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None)
    limits = ("-timeout=20", "-rss_limit_mb=2048", "-max_len=4096", "-print_final_stats=1")
    environment = {
        **os.environ,
        "TMPDIR": scratch.name,
        "ASAN_OPTIONS": "allocator_may_return_null=0:detect_leaks=1:max_allocation_size_mb=1500",
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }
    with scratch:
        return subprocess.run(
            [target, *limits, *options, f"-artifact_prefix={folder}/", folder / "found", corpus],
            capture_output=True,
            text=True,
            errors="replace",
            env=environment,
            check=False,
        )


@pytest.mark.fuzz
@pytest.mark.slow
@pytest.mark.parametrize("name", TARGETS)
def test_no_input_of_a_loader_is_a_finding(name, pytestconfig, tmp_path):
    option = pytestconfig.getoption
    found = run(
        f"fuzz_{name}",
        CORPUS / name,
        tmp_path,
        f"-max_total_time={max(1, round(option('--fuzz-seconds')))}",
        f"-runs={option('--fuzz-runs')}",
        f"-seed={option('--fuzz-seed') + 1}",
    )
    assert found.returncode == 0, found.stderr[-4000:]
    units = re.search(r"stat::number_of_executed_units: (\d+)", found.stderr)
    assert units is not None, found.stderr[-2000:]
    print(f"{name}: {units[1]} runs")
    assert int(units[1]) > 20


@pytest.mark.fuzz
@pytest.mark.slow
def test_a_finding_fails(tmp_path):
    """The bytes "defect" alone abort the target that only knows them."""
    (tmp_path / "seeds").mkdir()
    (tmp_path / "seeds" / "near").write_bytes(b"defekt")
    found = run("fuzz_defect", tmp_path / "seeds", tmp_path, "-runs=200000", "-seed=1")
    assert found.returncode != 0 and "heap-buffer-overflow" in found.stderr
