"""Light groups of the quantized cache that exact rays answer."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render import quantized as q

SIZE = (64, 40)
MIXED = vc.Whitted(n_vpls=12, n_area=4, n_environment=3, n_brdf=3)
GROUPS = ("point", "directional", "area", "environment", "vpl")
FORMS = {
    "waves": vc.Aqvc(c_e=8),
    "by contribution": vc.Aqvc(preset="fast", c_e=8),
    "pairs": vc.Aqvc(c_e=8, paper=vc.PaperForm(form="pairs")),
    "one at a time": vc.Aqvc(c_e=8, preset="paper"),
    "queue": vc.Aqvc(c_e=8, paper=vc.PaperForm(form="pairs", queue=64)),
    "paper tiles": vc.Aqvc(c_e=8, paper=vc.PaperForm(form="pairs", storage="paper_tiles")),
}


@pytest.fixture(scope="module")
def scene():
    """Lamps, a sun, an area light and a sky."""
    return q.lit_box().with_environment(0.5)


def render(scene, visibility, integrator=MIXED, **options):
    return vc.render(scene, integrator, visibility=visibility, size=SIZE, **options)


@pytest.mark.parametrize("form", FORMS)
def test_named_groups_have_the_bytes_and_counts_of_exact_visibility(scene, form):
    exact = render(scene, vc.Exact())
    none = render(scene, replace(FORMS[form], exact_groups=()))
    chosen = ("point", "area")
    some = render(scene, replace(FORMS[form], exact_groups=chosen))
    for group in GROUPS:
        layer, truth = some.layers[group], exact.layers[group]
        assert np.array_equal(layer, truth) == (group in chosen)
        assert not np.array_equal(none.layers[group], truth)  # else this says nothing
        # Groups share no clusters; in tables of pairs they share the order and the slots
        if group not in chosen and form in ("waves", "by contribution"):
            assert np.array_equal(layer, none.layers[group])
            assert some.counters["groups"][group] == none.counters["groups"][group]
    for group in chosen:
        assert some.counters["groups"][group] == exact.counters["groups"][group]
    assert none.counters["rays"] < some.counters["rays"] < exact.counters["rays"]
    both = render(scene, replace(FORMS[form], exact_groups=GROUPS), threads=2)
    assert np.array_equal(both.image, exact.image)
    assert both.counters["groups"] == exact.counters["groups"]


@pytest.mark.parametrize("preset", ["default", "fast"])
def test_own_samples_and_groups_of_few_lights_are_exact_by_default(scene, preset):
    cache, exact = vc.Aqvc(preset=preset), render(scene, vc.Exact())
    frame = render(scene, cache)
    assert cache.exact_groups == "auto" == frame.parameters["visibility"]["exact_groups"]
    rays = {group: count["rays"] for group, count in frame.counters["groups"].items()}
    for group, count in exact.counters["groups"].items():
        cached = group == "vpl"
        assert np.array_equal(frame.layers[group], exact.layers[group]) != cached
        assert (rays[group] == count["rays"]) != cached
    assert list(frame.counters["audit"]["groups"]) == list(exact.counters["groups"])
    errors = [group.rel_l1 for group in frame.audit.groups.values()]
    assert sum(error is not None and error.value > 0 for error in errors) <= 1


@pytest.mark.parametrize("lights", [8, 9])
def test_few_are_up_to_eight(lights):
    room = q.scene("room", triangles=2000, lights=lights)
    counts = render(room, vc.Aqvc(), vc.Direct()).counters["groups"]["point"]
    assert (counts["rays"] == counts["queries"]) == (lights == 8)


@pytest.mark.parametrize("lights", [32, 33])
def test_few_are_up_to_32_with_corrections(lights):
    """The answers of each of few lights would be checked often; the frame tells what it did."""
    room, direct = q.scene("room", triangles=2000, lights=lights), vc.Direct(n_area=2)
    found = render(room, vc.Aqvc(), direct, use="correct")
    exact = render(room, vc.Exact(), direct)
    own = found.counters["groups"].get("area", {"queries": 0})["queries"]
    queries, asked = exact.counters["queries"], found.counters["exact_queries"]
    if lights == 32:
        assert found.sha256 == exact.sha256 and found.counters["corrections"] == 0
        assert asked == queries
    else:
        assert asked == own < queries and found.counters["corrections"] > 0
    for cache in (vc.Aqvc(exact_groups=()), vc.Aqvc(preset="paper")):
        counters = render(room, cache, vc.Direct(), use="correct").counters
        assert counters["exact_queries"] == 0 < counters["corrections"]


@pytest.mark.parametrize("n_vpls", [135, 134])
def test_a_small_part_of_the_shared_lights_is_exact(n_vpls):
    """Nine lamps are a sixteenth of 9 + 135 lights."""
    room = q.scene("room", triangles=2000, lights=9)
    low, high = room.bounds
    places = np.random.default_rng(2).uniform(low, high, (n_vpls, 3))
    own = vc.Vpls(places, np.broadcast_to([0.0, -1, 0], places.shape), np.full(n_vpls, 0.1))
    counts = render(room, vc.Aqvc(), vc.Whitted(vpls=own)).counters["groups"]
    assert (counts["point"]["rays"] == counts["point"]["queries"]) == (n_vpls == 135)
    assert counts["vpl"]["rays"] < counts["vpl"]["queries"]


def test_directions_that_all_share_stay_in_the_cache_by_default(scene):
    shared = vc.Direct(environment="shared", n_environment=32)
    counts = {
        named: render(scene, vc.Aqvc(exact_groups=named), shared).counters["groups"]["environment"]
        for named in ("auto", ("environment",), ())
    }
    assert counts["auto"] == counts[()] != counts["environment",]
    assert counts["environment",]["rays"] == counts["environment",]["queries"]


def test_ambient_occlusion_stays_in_the_cache_by_default():
    ambient, scene = vc.AmbientOcclusion(n_samples=16, max_distance=None), q.scene("slats")
    counts = render(scene, vc.Aqvc(), ambient).counters["groups"]["ambient"]
    assert counts["rays"] < counts["queries"]
    named = render(scene, vc.Aqvc(exact_groups=["ambient"]), ambient)
    assert named.sha256 == render(scene, vc.Exact(), ambient).sha256


@pytest.mark.parametrize("preset", ["paper", "as_printed", "pairs"])
def test_the_paper_form_caches_every_group_unless_one_is_named(scene, preset):
    pairs = {"paper": vc.PaperForm(form="pairs")}
    cache = vc.Aqvc(**pairs if preset == "pairs" else {"preset": preset})
    counts = render(scene, cache).counters["groups"]
    assert all(count["rays"] < count["queries"] for count in counts.values())


def test_a_kept_table_holds_no_bits_of_named_groups(scene):
    def second(**named):
        """Counts of a frame that finds the table of the one before."""
        table = vc.AqvcTable(table_bytes=1 << 25)  # large enough for every cell
        cache = vc.Aqvc(c_e=8, refinement="off", **named)
        return [render(scene, cache, keep=table) for _ in range(2)][1].counters

    exact, named = ("point", "area"), second(exact_groups=("point", "area"))["groups"]
    truth = render(scene, vc.Exact()).counters["groups"]
    assert all(named[group] == truth[group] for group in exact) and named["vpl"]["rays"] == 0
    # By default everything is kept
    assert second()["rays"] == second(exact_groups=())["rays"] == 0


def test_bidirectional_paths_fill_the_table_unless_a_group_is_named():
    scene, bdpt = q.scene("cornell_box"), vc.Bdpt(max_depth=4)
    options = {"integrator": bdpt, "spp": 2}
    exact = render(scene, vc.Exact(), **options)
    default = render(scene, vc.Aqvc(c_e=8), **options)
    assert default.sha256 == render(scene, vc.Aqvc(c_e=8, exact_groups=()), **options).sha256
    groups = exact.counters["groups"]
    assert all(n["rays"] < n["queries"] for n in default.counters["groups"].values())
    named = vc.Aqvc(c_e=8, exact_groups=tuple(groups))
    assert render(scene, named, **options).sha256 == exact.sha256
    some = vc.Aqvc(c_e=8, exact_groups=("connection",))
    frames = [render(scene, some, threads=n, **options) for n in (1, 2)]
    assert frames[0].sha256 == frames[1].sha256 != exact.sha256
    assert frames[0].counters["groups"]["connection"] == groups["connection"]


def test_the_log_of_queries_says_that_exact_groups_are_exact(scene, tmp_path):
    import xarray

    conn = vc.connections(scene, MIXED, size=SIZE)
    path = tmp_path / "queries.nc"
    vc.record_queries(conn, vc.Aqvc(c_e=8, exact_groups=("vpl",)), path)
    with xarray.open_dataset(path, engine="h5netcdf") as queries:
        group = queries["group"].values
        wrong = queries["v"].values != queries["answer"].values
        exact = group == 4
        clusters = queries["cluster"].values[exact]
    assert exact.any() and not wrong[exact].any() and wrong[~exact].any()
    assert len(np.unique(clusters)) == len(clusters)


def test_sets_are_kept_in_the_order_of_the_groups_and_others_are_refused():
    assert vc.Aqvc(exact_groups={"vpl", "area"}) == vc.Aqvc(exact_groups=["area", "vpl"])
    assert vc.Aqvc(exact_groups={"vpl", "area"}).resolved()["exact_groups"] == ("area", "vpl")
    for given, message in (
        ("area", 'exact_groups must be "auto"'),
        (("lamp",), "exact_groups must name point, directional"),
        (3, 'exact_groups must be "auto" or a set'),
        ({"area": 1}, 'exact_groups must be "auto" or a set'),
    ):
        with pytest.raises(ValueError, match=message):
            vc.Aqvc(exact_groups=given)  # type: ignore[arg-type]
    core = vc.Aqvc().core()
    for wrong in ("area", ("lamp",)):
        with pytest.raises(ValueError, match="exact_groups must be"):
            core.exact_groups = wrong
