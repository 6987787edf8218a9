"""The pytest plugin: it costs other tests nothing, keeps exact frames, and leaves pages."""

import json
import re
import sys
from pathlib import Path

import pytest

import viscache
from codebase.repository import text

pytest_plugins = ["pytester"]

#: Counts frames that are rendered, in files that all processes see.
CONFTEST = """
import time, uuid, pathlib, pytest

@pytest.fixture(autouse=True)
def counted(monkeypatch):
    from viscache.sweeps import exact_frames

    whole = exact_frames.render_part

    def render(*arguments, **options):
        time.sleep(0.3)
        pathlib.Path(__file__).with_name(f"rendered-{uuid.uuid4()}").touch()
        return whole(*arguments, **options)

    monkeypatch.setattr(exact_frames, "render_part", render)
"""
SHARED = """
import pytest
import viscache as vc

@pytest.mark.parametrize("n", range(6))
def test_frame(viscache_exact, n):
    exact = viscache_exact("stairs", "direct", size=(32, 20), seed=n % 2)
    assert exact.image.any()
    exact.image[:] = 0  # a test's own
"""
FAILING = """
import numpy as np
import pytest
import viscache as vc

SIZE = (64, 40)
cached = vc.render("stairs", "direct", size=SIZE, visibility=vc.Unoccluded())

def test_fails(viscache_exact):
    vc.testing.assert_close(cached, viscache_exact("stairs", "direct", size=SIZE))

@pytest.mark.parametrize("name", ["../a b?"])
def test_biased(viscache_exact, name):
    rng = np.random.default_rng(0)
    exact = viscache_exact("stairs", "direct", size=SIZE)
    frames = [cached.image * rng.uniform(0.9, 1.1, (40, 64, 1)) for _ in range(4)]
    vc.testing.assert_unbiased(frames, exact)

@pytest.fixture
def broken(viscache_exact):
    vc.testing.assert_close(cached, viscache_exact("stairs", "direct", size=SIZE))

def test_setup_fails(broken):
    pass

def test_sizes_differ():
    vc.testing.assert_close(cached, np.ones((4, 4, 3)))

def test_passes(viscache_exact):
    exact = viscache_exact("stairs", "direct", size=SIZE)
    vc.testing.assert_close(exact, exact)
    with pytest.raises(AssertionError, match="not close"):
        vc.testing.assert_close(cached, exact)

@pytest.mark.xfail(strict=True)
def test_expected_to_fail(viscache_exact):
    vc.testing.assert_close(cached, viscache_exact("stairs", "direct", size=SIZE))

def test_something_else():
    assert 1 == 2
"""


@pytest.fixture
def run(pytester, monkeypatch):
    """Run pytest in a process of its own, which finds the plugin by its entry point."""
    package = Path(viscache.__file__).parents[1]
    info = pytester.mkdir("site") / "made_up-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: made_up\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[pytest11]\npytest_viscache = pytest_viscache\n")
    monkeypatch.setenv("PYTHONPATH", f"{package}:{info.parent}")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    pytester.makeini("[pytest]\nfilterwarnings = error\nxfail_strict = true\n")

    def ran(*arguments):
        # Others of this environment are slow to load
        alone = [f"-pno:{plugin}" for plugin in ("nbmake", "hypothesispytest", "anyio")]
        return pytester.runpytest_subprocess(
            "--strict-markers", "--strict-config", *alone, *arguments
        )

    return ran


def rendered(pytester):
    return len(list(pytester.path.glob("rendered-*")))


def pages(folder):
    return sorted(folder.rglob("diff.html"))


def test_the_entry_point_is_the_one_of_the_project():
    project = text("pyproject.toml")
    assert '[project.entry-points.pytest11]\npytest_viscache = "pytest_viscache"' in project
    assert '"python/pytest_viscache"' in project


def test_other_tests_are_neither_slowed_nor_changed(pytester, run):
    pytester.makepyfile(
        """
        import sys
        before = set(sys.modules)

        def test_nothing_is_imported(request):
            assert "pytest_viscache" in sys.modules  # the plugin is on
            assert request.config.pluginmanager.get_plugin("pytest_viscache")
            assert not [m for m in sys.modules if m.split(".")[0] in ("viscache", "numpy")]

        def test_failures_are_told_as_ever():
            assert 1 == 2
        """
    )
    result = run("-q")
    result.assert_outcomes(passed=1, failed=1)
    without = run("-q", "-p", "no:pytest_viscache")
    without.assert_outcomes(passed=0, failed=2)  # its import is looked for, as it should be
    plain = [re.sub(r"[\d.]+s", "", line) for line in result.outlines if "1 == 2" in line]
    assert plain == [re.sub(r"[\d.]+s", "", line) for line in without.outlines if "1 == 2" in line]
    assert not [line for line in result.outlines if "viscache" in line]
    assert sorted(p.name for p in (pytester.path / ".pytest_cache/v").rglob("*")) == [
        "cache",
        "lastfailed",
        "nodeids",
    ]
    assert not (pytester.path / ".pytest_cache/d").exists()


def test_exact_frames_are_rendered_once_for_all_tests_workers_and_runs(pytester, run):
    pytester.makeconftest(CONFTEST)
    pytester.makepyfile(SHARED)
    run("-n", "2").assert_outcomes(passed=6)
    assert rendered(pytester) == 2
    run().assert_outcomes(passed=6)
    assert rendered(pytester) == 2


@pytest.mark.slow
def test_exact_frames_are_kept_where_they_should_be(pytester, run):
    pytester.makeconftest(CONFTEST)
    pytester.makepyfile(SHARED)
    for count, arguments in ((2, []), (4, ["--cache-clear"]), (6, ["--viscache-exact", "here"])):
        run(*arguments).assert_outcomes(passed=6)
        assert rendered(pytester) == count
    assert len(list(pytester.path.glob("here/*/frames/*.exr"))) == 2
    run("-p", "no:cacheprovider", "-k", "0 or 1").assert_outcomes(passed=2, deselected=4)
    assert rendered(pytester) == 8  # a run without a cache keeps nothing
    (pytester.path / ".pytest_cache/d/viscache-exact").rename(pytester.path / "moved")
    (pytester.path / ".pytest_cache/d/viscache-exact").touch()  # as good as one that is read-only
    run("-k", "0 or 1").assert_outcomes(passed=2, deselected=4)
    assert rendered(pytester) == 10


def test_a_failing_test_leaves_a_page_and_prints_its_path(pytester, run):
    pytester.makepyfile(FAILING)
    result = run()
    result.assert_outcomes(failed=4, errors=1, passed=1, xfailed=1)
    found = pages(pytester.path)
    told = re.findall(r"^E +difference: (.+)$", result.stdout.str(), re.M)
    assert sorted(told) == [str(p) for p in found] and len(found) == 3
    assert all(p.is_relative_to(pytester.path / ".pytest_cache") for p in found)
    text = next(p for p in found if "test_fails" in str(p)).read_text("utf-8")
    assert "<title>test_fails − exact</title>" in text and "rel_l1" in text and "must be" in text
    data = json.loads(re.search(r'id="data" type="application/json">(.*?)</script>', text)[1])
    assert data["pictures"]["reference"] and data["settings"][0]["difference"]
    assert data["settings"][0]["flip"]
    result.stdout.fnmatch_lines(
        [
            ">       vc.testing.assert_close(cached, viscache_exact(*",
            "E       viscache.testing.PictureError: not close to the exact picture: rel_l1 must*",
            "E         rel_l1 *must be <= 0.02, * times",
            "E       Try:",
            "E         - it leaves all shadows out",
        ]
    )
    assert "could not be written" not in result.stdout.str()
    biased = next(p for p in found if "test_biased" in str(p)).read_text("utf-8")
    assert "worst block" in biased and "with probability 0.99" in biased


def test_pages_go_where_the_option_says(pytester, run):
    pytester.makepyfile(FAILING)
    run("-k", "test_fails", "--viscache-pages", "shown").assert_outcomes(failed=1, deselected=6)
    assert [p.is_relative_to(pytester.path / "shown") for p in pages(pytester.path)] == [True]
    (pytester.path / "file").touch()
    result = run("-k", "test_fails", "--viscache-pages", "file")
    result.assert_outcomes(failed=1, deselected=6)
    result.stdout.fnmatch_lines(["*the page of the difference could not be written:*"])
    assert "INTERNALERROR" not in result.stdout.str()


def test_this_run_has_the_plugin(pytestconfig):
    assert pytestconfig.pluginmanager.hasplugin("pytest_viscache")
    assert "pytest_viscache" in sys.modules
