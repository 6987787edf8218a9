"""A table per thread, kept over the tiles of 32² pixels that the thread works on."""

import itertools

import pytest

import viscache as vc
from render.quantized import exact, rel_l1, render, scene

SIZE = (96, 80)
LAMPS = vc.Whitted(n_vpls=16, n_area=0, n_environment=0, n_brdf=0)
PAIRS = {"form": "pairs", "table_bytes": 16 << 20, "size": SIZE}


def room():
    return scene("room", triangles=3000)


def kept(threads, **given):
    return render(room(), LAMPS, storage="paper_tiles", threads=threads, **{**PAIRS, **given})


def test_a_frame_is_the_same_for_the_same_number_of_threads():
    for threads in (1, 2, 3):
        first, again = kept(threads), kept(threads)
        assert first.sha256 == again.sha256 and first.counters == again.counters
        assert first.parameters["tile_edge_px"] == 32
    assert kept(1).sha256 != kept(3).sha256


def test_one_kept_table_traces_a_key_once_in_all_tiles():
    """Without refinement a key costs a ray. Tables that are cleared trace some keys in several."""
    options = {"c_e": 8, "refinement": "off"}
    cleared = render(room(), LAMPS, storage="exact", **{**PAIRS, **options})
    assert cleared.parameters["tile_edge_px"] == 32  # as in the paper
    counters = kept(1, **options).counters
    assert counters["rays"] < 0.95 * cleared.counters["rays"]
    # A table kept over frames counts the keys of all tiles once
    pairs = vc.Aqvc(paper=vc.PaperForm(form="pairs", scale_free=False), exact_groups=(), **options)
    table = vc.AqvcTable(table_bytes=64 << 20)
    every = vc.render(room(), LAMPS, visibility=pairs, size=SIZE, keep=table).counters
    again = counters["rays"] - every["table_occupied"]
    assert 0 <= again <= counters["evictions"] + every["evictions"] < 0.005 * counters["rays"]
    # Each thread traces the keys it meets
    rays = [kept(n, **options).counters["rays"] for n in (1, 2, 4)]
    assert all(a < b for a, b in itertools.pairwise(rays)) and rays[-1] < 1.5 * rays[0]


def test_a_table_is_counted_once_per_thread():
    slots = kept(1).counters["table_slots"]
    assert slots <= (16 << 20) // 4
    assert kept(3).counters["table_slots"] == 3 * slots


def test_errors_are_those_of_tables_that_are_cleared():
    reference = exact(room(), LAMPS, SIZE).image
    cleared = render(room(), LAMPS, c_e=8, **PAIRS)
    errors = [rel_l1(frame.image, reference) for frame in (kept(2, c_e=8), cleared)]
    assert 0.7 < errors[0] / errors[1] < 1.4 and errors[0] < 0.15


def test_one_table_of_the_frame_and_parts_of_a_frame_refuse_it():
    with pytest.raises(ValueError, match=r"storage must be table, exact or shared .* paper_tiles"):
        tiles = vc.Aqvc(paper=vc.PaperForm(storage="paper_tiles"))
        vc.render(room(), vc.Bdpt(), size=(4, 4), visibility=tiles)
