"""The size of a field is predicted before the build; too large fields are refused."""

import re
import resource

import numpy as np
import pytest

import viscache as vc
from core import testing
from reference.built import built
from viscache import _core
from vlf.field_rays import soup


def soup_scene(n=3000, edge=None):
    return vc.Scene.from_arrays(*soup(n, edge=edge))


SCENES = {
    "soup": soup_scene,
    "large triangles": lambda: soup_scene(500, 0.8),
    "small triangles": lambda: soup_scene(5000, 0.02),
    "room": lambda: built("room?triangles=5000"),
    "courtyard": lambda: vc.scenes.courtyard(triangles=20_000),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    "settings",
    [
        vc.Vlf(n_directions=129, n_tiles=32, bsp_depth=0),
        vc.Vlf(n_directions=129, n_tiles=64, bsp_depth=4),
        vc.Vlf(n_directions=129, n_tiles=64, bsp_depth=3, leaf_target=0, split="object"),
        vc.Vlf(n_directions=9, n_tiles=128, tile_ranges=False),
    ],
)
def test_the_predicted_bytes_are_those_built_within_a_tenth(name, settings):
    scene = SCENES[name]()
    predicted = vc.VisibilityField.memory_estimate(scene, settings)
    f = vc.VisibilityField(
        scene, settings.n_directions, settings.n_tiles, settings.bsp_depth, settings=settings
    )
    assert predicted / f.stats["bytes"] == pytest.approx(1, abs=0.1)


def test_a_field_beyond_its_budget_is_refused_with_what_fits():
    scene = soup_scene()
    whole = vc.VisibilityField(scene, 129, 64, 3).stats["bytes"]
    with pytest.raises(MemoryError) as refused:
        vc.VisibilityField(scene, 129, 64, 3, max_bytes=whole * 3 // 5)
    text = str(refused.value)
    stated = re.search(r"predicted to take (\d+) bytes, max_bytes is (\d+)", text)
    assert stated and int(stated[2]) == whole * 3 // 5
    assert int(stated[1]) == pytest.approx(whole, rel=0.1)
    for name, value in re.findall(r"(n_tiles|n_directions|bsp_depth)=(\d+)", text):
        kept = {"n_directions": 129, "n_tiles": 64, "bsp_depth": 3} | {name: int(value)}
        assert (
            vc.VisibilityField(scene, **kept, max_bytes=whole * 3 // 5).stats["bytes"]
            <= whole * 3 // 5
        )
    assert "n_tiles=" in text and "n_directions=33" in text


def test_a_hopeless_field_is_refused_without_memory_taken_for_it():
    scene = soup_scene(200, 1.0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(MemoryError, match="predicted to take at least"):
        vc.VisibilityField(scene, 8193, 4096, 5, max_bytes=1 << 20)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before  # KiB
    assert grown < 100_000


def test_what_nothing_makes_fit_is_refused():
    with pytest.raises(MemoryError, match="no smaller"):
        vc.VisibilityField(soup_scene(), 3, 1, 0, max_bytes=1000)


@pytest.mark.parametrize("budget", [1 << 20, 4 << 20, 32 << 20])
def test_parameters_left_open_are_chosen_to_fit(budget):
    scene = soup_scene()
    f = vc.VisibilityField(scene, "auto", "auto", "auto", max_bytes=budget)
    assert f.stats["bytes"] <= 1.05 * budget
    assert f.n_directions in vc.vlf.DIRECTION_COUNTS and 1 <= f.n_tiles <= 512
    assert f.settings.n_tiles == "auto"


def test_a_larger_budget_gives_a_field_with_fewer_steps():
    scene = soup_scene()
    r = np.random.default_rng(0)
    o = r.uniform(-1, 1, (2000, 3)).astype(np.float32)
    d = r.normal(size=o.shape).astype(np.float32)
    costs = []
    for budget in (1 << 20, 8 << 20, 64 << 20):
        f = vc.VisibilityField(scene, "auto", "auto", "auto", max_bytes=budget)
        axes = vc.vlf.nearest_direction(d, f.n_directions)
        *_, steps, _ = f._core.trace_by(o, d, axes)
        costs.append(2 * steps["tiles"] + steps["tests"])
    assert costs[0] > 1.2 * costs[1] > 1.2 * costs[2]


@pytest.mark.parametrize("given", [{"n_tiles": 48}, {"n_directions": 9}, {"bsp_depth": 2}])
def test_parameters_that_are_given_stay(given):
    open_ = {"n_directions": "auto", "n_tiles": "auto", "bsp_depth": "auto"} | given
    f = vc.VisibilityField(soup_scene(), **open_, max_bytes=16 << 20)  # type: ignore[arg-type]
    assert {name: getattr(f, name) for name in given} == given


def test_the_default_depth_is_one_that_fits():
    scene = soup_scene()
    assert vc.VisibilityField(scene, 33, 32).bsp_depth == 5
    tight = int(vc.VisibilityField(scene, 33, 32, 0).stats["bytes"] * 1.03)
    # The budget includes only one builder thread's working memory
    with pytest.raises(MemoryError, match=r"\(\d+ only while it is built\)") as refused:
        vc.VisibilityField(scene, 33, 32, 0, max_bytes=tight)
    room = re.search(r"\((\d+) only", str(refused.value))
    assert room is not None and 0.05 * tight < int(room[1]) < tight
    for threads in (1, 4):
        made = vc.VisibilityField(scene, 33, 32, max_bytes=tight + int(room[1]), threads=threads)
        assert made.bsp_depth < 5


def test_a_time_budget_chooses_a_field_that_is_built_sooner():
    scene = soup_scene()
    sizes = []
    for seconds in (0.01, 0.1, 1.0):
        settings = vc.Vlf(n_directions="auto", n_tiles="auto", max_build_s=seconds)
        f = vc.VisibilityField(scene, "auto", "auto", "auto", settings=settings)
        assert testing.expected_build_s(scene._core, f._core.settings) <= seconds
        sizes.append(f.stats["bytes"])
    assert sizes[0] < 0.5 * sizes[1] < 0.25 * sizes[2]


def test_the_rule_for_build_time_counts_references_and_tiles():
    scene = soup_scene()
    for n in (16, 128):
        settings = vc.Vlf(n_directions=129, n_tiles=n, bsp_depth=3).core()
        references = _core.vlf.expected_references(scene._core, n)
        seconds = testing.expected_build_s(scene._core, settings)
        assert seconds == pytest.approx(129 * (75e-9 * references + 27e-9 * n * n))
