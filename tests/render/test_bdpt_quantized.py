"""Bidirectional path tracing through the quantized cache: one table for the frame, Eq. 6."""

from functools import cache

import numpy as np
import pytest

import viscache as vc
from render import bdpt_scenes as scenes
from render.quantized import energy, rel_l1
from viscache.settings.by_name import replaced

SIZE = (64, 48)
MIB = 1 << 20
#: Without connections to the camera every query goes through the cache.
PLAIN = vc.Bdpt(max_depth=5, camera_connections="off")


@cache
def room():
    return scenes.ROOM.to_viscache()


def cached(integrator=PLAIN, scene=None, spp=4, seed=0, threads=None, **aqvc):
    visibility = replaced(vc.Aqvc(table_bytes=16 * MIB), aqvc, "visibility")
    given = {"size": SIZE, "spp": spp, "seed": seed, "threads": threads}
    return vc.render(scene or room(), integrator, visibility=visibility, **given)


@cache
def exact(integrator=PLAIN, spp=4, seed=0):
    return vc.render(room(), integrator, size=SIZE, spp=spp, seed=seed)


def test_the_lossy_table_answers_as_the_map_of_full_keys_where_nothing_is_evicted():
    table, full = cached(table_bytes=256 * MIB), cached(storage="exact")
    assert table.counters["evictions"] < 0.01 * table.counters["table_writes"]
    assert rel_l1(table.image, full.image) < 2e-3
    assert table.counters["rays"] == pytest.approx(full.counters["rays"], rel=0.01)


@pytest.mark.stat
def test_racing_threads_are_wrong_no_more_often_than_one_at_a_time():
    """Share of wrong bits of 8 races against 8 frames of the deterministic mode, by other seeds."""

    def wrong(seed, storage):
        frame = cached(spp=2, seed=seed, threads=4, storage=storage)
        return rel_l1(frame.image, exact(spp=2, seed=seed).image)

    races = np.array([wrong(s, "shared") for s in range(8)])
    alone = np.array([wrong(s, "table") for s in range(8)])
    error = (races - alone).std(ddof=1) / np.sqrt(8)
    # Rounds hide what a race sees at once: the races reuse a little more
    assert abs((races - alone).mean()) < 3 * error + 0.1 * alone.mean()
    assert alone.min() > 1e-4


def test_racing_threads_count_what_they_trace():
    race, table = cached(threads=8, storage="shared"), cached(threads=8)
    for frame in (race, table):
        c = frame.counters
        assert c["rays"] == c["table_writes"] + c["bypassed"] < c["queries"]
        assert c["table_occupied"] + c["evictions"] + c["duplicates"] == c["table_writes"]
        assert 0 < c["occupancy"] < 1
        assert c["lookups"] == c["queries"] - c["bypassed"]
    assert race.counters["queries"] == table.counters["queries"]
    assert table.counters["duplicates"] > 0


def test_larger_clusters_trace_less_and_err_more():
    frames = [cached(c_e=c_e, spp=8) for c_e in (2, 6, 18)]
    rays = [f.counters["rays"] for f in frames]
    errors = [rel_l1(f.image, exact(spp=8).image) for f in frames]
    assert rays[0] > 1.5 * rays[1] > 2 * rays[2]
    assert errors[0] < errors[1] < errors[2]
    assert abs(energy(frames[1].image, exact(spp=8).image)) < 0.01


def test_connections_with_the_camera_pass_by_the_cache_unless_they_are_keyed():
    """See deviation A27."""
    bypassing = cached(vc.Bdpt(max_depth=4, camera_connections="bypass"))
    keyed = cached(vc.Bdpt(max_depth=4))
    camera = bypassing.counters["groups"]["camera"]
    assert camera["queries"] == camera["rays"] == bypassing.counters["bypassed"] > 0
    reference = exact(vc.Bdpt(max_depth=4))
    np.testing.assert_array_equal(bypassing.layers["camera"], reference.layers["camera"])
    other = keyed.counters["groups"]["camera"]
    assert other["queries"] == camera["queries"] and other["rays"] < 0.8 * camera["rays"]
    assert 0 < rel_l1(keyed.layers["camera"], reference.layers["camera"]) < 0.2
    assert keyed.counters["bypassed"] == 0


def test_mirrors_and_glass_lie_between_clusters():
    scene = scenes.CAUSTICS.to_viscache()
    integrator = vc.Bdpt(max_depth=6)
    reference = vc.render(scene, integrator, size=SIZE, spp=8)
    frame = cached(integrator, scene, spp=8, c_e=6)
    assert frame.counters["rays"] < 0.7 * frame.counters["queries"]
    assert rel_l1(frame.image, reference.image) < 0.05


def test_what_is_not_given_is_what_the_paper_takes_for_this_renderer():
    used = vc.render(room(), PLAIN, visibility=vc.Aqvc(), size=SIZE).parameters["visibility"]
    assert (used["refinement"], used["c_r"]) == ("off", 2)
    assert used["table_bytes"] == 256 * MIB
    paper = vc.Aqvc(preset="paper").for_frame_table().resolved()
    assert paper["refinement"] == "off"
    assert (paper["c_z"], paper["c_r"]) == (8, pytest.approx(1.2))
    assert vc.Aqvc(c_r=1.5).for_frame_table().c_r == 1.5


@pytest.mark.release
@pytest.mark.parametrize("name", ["the closed room", "the Cornell box"])
def test_clusters_of_12_trace_a_sixth_of_the_rays(name):
    """The paper's figure for this renderer (Sec. 5), with the defaults."""
    scene = room() if name == "the closed room" else vc.scenes.cornell_box()
    options = {"size": (96, 96), "spp": 64}
    reference = vc.render(scene, vc.Bdpt(), **options)
    frame = vc.render(scene, vc.Bdpt(), visibility=vc.Aqvc(c_e=12), **options)
    assert frame.counters["ray_reduction"] > 6
    assert rel_l1(frame.image, reference.image) < 0.02
    assert abs(energy(frame.image, reference.image)) < 0.005


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_frames_without_queries_are_answered(depth):
    dark = scenes.OUTSIDE.to_viscache()
    frame = cached(vc.Bdpt(max_depth=depth), dark)
    assert frame.counters["queries"] == frame.counters["rays"] == 0 and not frame.image.any()
