"""Blocks from arrays go through shafts if asked, and give the bits of packets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import viscache as vc
from oracles.test_oracle import area_points, lamps
from reference.built import built


@pytest.fixture(scope="module")
def room() -> vc.Scene:
    return built("room?triangles=3000")


@pytest.mark.parametrize("engine", ["shafts", "auto"])
@pytest.mark.parametrize("threads", [1, 3])
def test_shafts_answer_blocks_from_arrays(room: vc.Scene, engine: Any, threads: int) -> None:
    eyes, ends = area_points(room, 20_000), lamps(room, 100)
    wanted = np.random.default_rng(3).random((len(eyes), len(ends))) < 0.6
    packets = room.oracle(vc.Exact(engine="packets")).block(eyes, ends, wanted)
    assert "shaft_queries" not in packets.engine
    found = room.oracle(vc.Exact(engine=engine), threads=threads).block(eyes, ends, wanted)
    np.testing.assert_array_equal(found.bits, packets.bits)
    work = found.engine
    assert work["shaft_queries"] + work["left_to_packets"] == wanted.sum()
    assert work["shaft_queries"] > (0.5 if engine == "auto" else 0.99) * wanted.sum()
    assert work["shaft_traced_packets"] < 0.5 * work["shaft_asked_packets"]


def test_directions_and_few_lights_stay_with_packets(room: vc.Scene) -> None:
    room.shafts().memory_bytes()  # builds the tree
    eyes = area_points(room, 3000)
    few = room.oracle(vc.Exact(engine="auto")).block(eyes, lamps(room, 4))
    assert few.engine["shaft_queries"] == 0 and few.engine["left_to_packets"] == 12_000
    sky = vc.FarEnds.directions(np.random.default_rng(1).normal(size=(70, 3)))
    found = room.oracle(vc.Exact(engine="shafts")).block(eyes, sky)
    assert "no light is a point" in found.engine["no_shafts"]
