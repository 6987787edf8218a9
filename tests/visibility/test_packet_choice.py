"""How exact rays share packets, and Embree's flag: from geometry, never by timing."""

import re
from pathlib import Path

import numpy as np
import pytest

import viscache as vc
from core import testing

#: Packets wider than this many triangle sizes are traced incoherently.
WIDEST = 6
CPP = Path(__file__).parents[2] / "cpp"


def squares(size, placed=None):
    """100 squares of two triangles, whose area has the root `size`; placed by scale, if given."""
    corner = np.random.default_rng(3).uniform(0, 50 * size, (100, 1, 3))
    corner[0], corner[1] = 0, 50 * size
    square = np.sqrt(2) * size * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(100)[:, None, None]
    description = vc.SceneDescription()
    description.add_mesh(
        (corner + square).reshape(-1, 3), faces.reshape(-1, 3), in_world=placed is None
    )
    if placed is not None:
        description.add_instance([0], np.diag([placed, placed, placed, 1.0]))
    return vc.Scene.from_description(description)


def coherent(scene, origins, ends):
    """Whether rays between two boxes with these half diagonals are traced coherently."""
    box = np.random.default_rng(1).uniform(-1, 1, (16, 3)) / np.sqrt(3)
    box[3], box[9] = -1 / np.sqrt(3), 1 / np.sqrt(3)
    towards = float(np.abs(scene.bounds).max()) / 2
    return testing.coherent_between(scene.caster(), origins * box, towards + ends * box[::-1])


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e9])
def test_packets_that_are_wide_for_the_triangles_are_incoherent(size):
    scene = squares(size)
    below, above = 0.99 * WIDEST * size, 1.01 * WIDEST * size
    assert coherent(scene, below, below) and coherent(scene, 0, 0)
    assert not coherent(scene, above, 0) and not coherent(scene, 0, above)


@pytest.mark.parametrize("scale", [0.25, 8.0])
def test_triangles_count_as_large_as_they_are_placed(scale):
    scene = squares(1.0, placed=scale)
    assert coherent(scene, 0.99 * WIDEST * scale, 0)
    assert not coherent(scene, 1.01 * WIDEST * scale, 0)


def test_scenes_without_area_have_an_answer():
    line = vc.Scene.from_arrays([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]])
    assert coherent(line, 0, 0) and not coherent(line, 1, 1)


def test_rows_that_share_few_lights_are_traced_by_pixel():
    by_light = testing.by_light
    assert by_light(np.ones((16, 100), bool)) and by_light(np.ones((3, 100), bool))
    assert not by_light(np.ones((2, 100), bool))
    # Each light is asked for by as many neighbours
    for neighbours, light in ((1, False), (2, False), (3, True), (16, True)):
        lane = np.arange(16)[:, None] - np.arange(80) % 16
        assert by_light(lane % 16 < neighbours) == light
    # At random: a light is asked for by 8, and by 2 of 16
    some = np.random.default_rng(1).random((16, 300))
    assert by_light(some < 8 / 16) and not by_light(some < 2 / 16)
    assert by_light(np.zeros((16, 64), bool))


#: Files that read a clock. All of them report times; `gil.cpp` waits for Python.
CLOCKS = """
bindings/bind_aqvc_levels.cpp bindings/gil.cpp viscache/math/cpu_time.h viscache/math/wall_clock.h
viscache/render/aligned_ambient.cpp viscache/render/bdpt.cpp
viscache/render/environment_product.cpp viscache/render/frame.cpp viscache/render/frame.h
viscache/render/stage_clock.h viscache/oracles/roulette_source.cpp
viscache/oracles/shadow_map_source.cpp viscache/shafts/shaft_matrix.cpp
viscache/shafts/shaft_source.cpp
"""


def test_no_choice_is_timed():
    """Where the clock chooses how rays are traced, two runs can differ by a byte."""
    clock = re.compile(r"clock_gettime|_clock::|rdtsc|(cpu_time|wall_clock|stage_clock)\.h")
    found = {str(p.relative_to(CPP)) for p in CPP.rglob("*.[ch]*") if clock.search(p.read_text())}
    assert found == set(CLOCKS.split())
