"""Shafts give the bits of packets: on all scenes, at edges, ends and needles, on every CPU.

Blocks and frames here; matrices of the same scenes in test_shaft_matrix.py.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from oracles.test_oracle import area_points, lamps
from reference.built import built
from reference.isas import AVAILABLE
from viscache import _core

Array = npt.NDArray[Any]
SCENES = os.environ.get("VISCACHE_SCENES")
PACKETS = vc.Exact(engine="packets")


@dataclass(frozen=True)
class Shafts:
    """Shafts with another instruction set, or with smaller bounds."""

    isa: str | None = None
    bounds: float = 1.0

    def source(self, context):
        exact = _core.ExactSource(context.scene, context.caster)
        shafts = _core.ShaftScene(context.scene)
        assert shafts.refusal == ""
        return _core.ShaftSource(
            context.scene, context.caster, shafts, exact, isa=self.isa, bounds=self.bounds
        )

    def parameters(self):
        return {}


def visible(scene, setting, eyes, ends, **more):
    return np.asarray(scene.oracle(setting, **more).block(eyes, ends).visible)


def count_of_differences(scene, eyes, ends, setting=None):
    packets = visible(scene, PACKETS, eyes, ends)
    shafts = visible(scene, setting or vc.Exact(engine="shafts"), eyes, ends)
    return int(np.count_nonzero(packets != shafts))


def differences(scene, x, y, **more):
    """Number of bits of a matrix that are not those of packets."""
    shafts = _core.ShaftScene(scene._core)
    bits, work = _core.shaft_matrix(shafts, scene.caster(), x, y, **more)
    assert work["shaft_queries"] == len(x) * len(y)
    packets = scene.visible_matrix(x, y, engine="packets")
    return int(np.unpackbits((bits ^ packets).view(np.uint8)).sum())


def positions(points):
    return np.asarray(points.positions)


def scene_of(corners):
    """Triangles (n, 3, 3)."""
    corners = np.asarray(corners, dtype=np.float32)
    return vc.Scene.from_arrays(
        corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3).astype(np.uint32)
    )


def grid(n, height, keep=None):
    """A triangulated square of n × n unit cells with integer corners."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    at = np.stack([i, np.full(n * n, height), j], axis=1).astype(np.float64)
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    lower = np.stack([at, at + x, at + x + z], axis=1)
    upper = np.stack([at, at + x + z, at + z], axis=1)
    triangles = np.concatenate([lower, upper])
    return triangles if keep is None else triangles[keep]


def some_of_a_grid(n=8):
    """Half of the triangles of a grid: rays between points of a grid meet its edges and corners."""
    keep = np.random.default_rng(3).random(2 * n * n) < 0.5
    return scene_of(np.concatenate([grid(n, 1.0, keep), grid(n, 0.0)]))


def grid_points(n, height, normal):
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    places = np.stack([i, np.full(n * n, height), j], axis=1)
    return vc.EyePoints(places, np.broadcast_to([0.0, normal, 0], places.shape))


def needles(n=400):
    """Long thin triangles, triangles without area, and twice the same triangle."""
    random = np.random.default_rng(5)
    a = random.uniform(-1, 1, (n, 3))
    along = random.uniform(-1, 1, (n, 3))
    aside = random.uniform(-1, 1, (n, 3)) * 10.0 ** random.uniform(-9, -2, (n, 1))
    thin = np.stack([a, a + along, a + aside], axis=1)
    line = np.stack([a, a + along, a + along * 0.5], axis=1)[: n // 4]
    point = np.repeat(a[: n // 8, None], 3, axis=1)
    large = random.uniform(-1, 1, (20, 3, 3))
    return scene_of(np.concatenate([thin, line, point, large, large]))


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("spec", ["room?triangles=3000", "cornell_box", "random_triangles"])
def test_bits_are_those_of_packets_on_every_instruction_set(spec, isa):
    scene = built(spec)
    eyes = area_points(scene, 1500)
    for ends in (lamps(scene, 40), surfaces(scene, 70)):
        assert count_of_differences(scene, eyes, ends, Shafts(isa=isa)) == 0
        assert differences(scene, positions(eyes), positions(ends), isa=isa) == 0


def surfaces(scene, count):
    """Virtual point lights on the scene's own surfaces."""
    points = area_points(scene, count, seed=9)
    return vc.FarEnds.surfaces(points.positions, points.normals)


def through_corners():
    """Rays of which most pass exactly through edges and corners, half of them beside a hole."""
    lights = np.asarray(grid_points(9, 2.0, 1.0).positions) + np.array([0, 1e-6, 0])
    return some_of_a_grid(), grid_points(9, 0.0, 1.0), vc.FarEnds.points(lights)


def sure_packets(scene, eyes, ends):
    """Answers of packets, and where they are the same for every order and flag.

    Exactly at a corner, Embree's answer depends on the packet: its boxes are tested in another way.
    """
    answers = [
        visible(scene, vc.Exact(order=o, coherent=c, engine="packets"), eyes, ends)
        for o in ("by_light", "by_pixel")
        for c in (True, False)
    ]
    return answers[0], np.all([a == answers[0] for a in answers], axis=0)


@pytest.mark.parametrize("isa", AVAILABLE)
def test_rays_through_edges_and_corners_are_those_of_packets(isa):
    scene, eyes, ends = through_corners()
    packets, is_sure = sure_packets(scene, eyes, ends)
    shafts = visible(scene, Shafts(isa=isa), eyes, ends)
    assert np.count_nonzero((shafts != packets) & is_sure) == 0
    assert is_sure.mean() > 0.9
    assert 0.2 < packets.mean() < 0.8
    low, high, above = (positions(grid_points(9, y, 1.0)) for y in (0.0, 1.0, 2.0))
    for x, y in ((low, above), (above, low), (low, high), (high, high + np.float32(1e-3))):
        assert differences(scene, x, y, isa=isa) == 0


def test_without_bounds_rays_at_edges_differ():
    """The negative control: tests at edges notice bounds of zero."""
    scene, eyes, ends = through_corners()
    packets, is_sure = sure_packets(scene, eyes, ends)
    shafts = visible(scene, Shafts(bounds=0.0), eyes, ends)
    assert np.count_nonzero((shafts != packets) & is_sure) > 20
    assert differences(scene, positions(eyes), positions(grid_points(9, 2, 1)), bounds=0.0) > 30


@pytest.mark.parametrize("isa", AVAILABLE)
def test_needles_and_triangles_without_area_are_those_of_packets(isa):
    scene = needles()
    eyes, others = area_points(scene, 800), positions(area_points(scene, 130, seed=4))
    assert count_of_differences(scene, eyes, vc.FarEnds.points(others), Shafts(isa=isa)) == 0
    assert differences(scene, positions(eyes), others, isa=isa) == 0


def test_eyes_and_lights_in_one_plane_are_those_of_packets():
    scene = some_of_a_grid()
    for height in (0.0, 1.0):
        eyes = grid_points(9, height, 1.0)
        points = grid_points(9, height, 1.0)
        ends = vc.FarEnds.surfaces(points.positions, points.normals)
        assert count_of_differences(scene, eyes, ends) == 0
        on_plane = vc.FarEnds.points(np.asarray(points.positions) + np.array([0.3, 0, 0.1]))
        assert count_of_differences(scene, eyes, on_plane) == 0


@pytest.mark.parametrize(
    ("n_eyes", "n_lights"), [(1, 1), (1, 70), (15, 3), (17, 64), (65, 65), (4097, 65)]
)
def test_any_numbers_of_points_and_lights_have_the_bits_of_packets(n_eyes, n_lights):
    scene = built("room?triangles=3000")
    eyes, ends = area_points(scene, n_eyes), lamps(scene, n_lights)
    assert count_of_differences(scene, eyes, ends) == 0
    x, y = positions(eyes), positions(ends).copy()
    y[-1] = x[0]  # a pair without length
    assert differences(scene, x, y) == 0
    if rest := n_lights % 64:
        bits = scene.visible_matrix(x, y, engine="shafts")
        assert not (bits[:, -1] >> np.uint64(rest)).any()


def test_a_tree_beyond_the_limit_is_not_built():
    scene = built("room?triangles=3000")
    assert "max_bytes" in _core.ShaftScene(scene._core, max_bytes=1000).refusal
    assert 0 < _core.ShaftScene(scene._core).memory_bytes() < 200 * scene.triangles


WHITTED = vc.Whitted(n_vpls=150)


@pytest.mark.parametrize(("engine", "threads"), [("shafts", 1), ("auto", 2), ("shafts", 3)])
def test_frames_have_the_bytes_of_packets(engine, threads):
    scene = built("room?triangles=3000")
    given = {"size": (150, 90), "spp": 2}
    packets = vc.render(scene, WHITTED, visibility=PACKETS, **given)
    exact = vc.Exact(engine=engine)
    shafts = vc.render(scene, WHITTED, visibility=exact, threads=threads, **given)
    assert shafts.sha256 == packets.sha256
    assert shafts.counters == packets.counters
    work = shafts.parameters["engine"]
    assert work["shaft_queries"] > 0
    assert work["shaft_doubted"] + work["shaft_long_lists"] < work["shaft_queries"]


@pytest.mark.parametrize(("engine", "threads"), [("shafts", 1), ("auto", 3)])
def test_blocks_from_arrays_have_the_bits_of_packets(engine, threads):
    room = built("room?triangles=3000")
    eyes, ends = area_points(room, 20_000), lamps(room, 100)
    wanted = np.random.default_rng(3).random((len(eyes), len(ends))) < 0.6
    packets = room.oracle(PACKETS).block(eyes, ends, wanted)
    assert "shaft_queries" not in packets.engine
    found = room.oracle(vc.Exact(engine=engine), threads=threads).block(eyes, ends, wanted)
    np.testing.assert_array_equal(found.bits, packets.bits)
    work = found.engine
    assert work["shaft_queries"] + work["left_to_packets"] == wanted.sum()
    assert work["shaft_queries"] > (0.5 if engine == "auto" else 0.99) * wanted.sum()
    assert work["shaft_traced_packets"] < 0.5 * work["shaft_asked_packets"]


def test_directions_and_few_lights_stay_with_packets():
    room = built("room?triangles=3000")
    room.shafts().memory_bytes()  # builds the tree
    eyes = area_points(room, 3000)
    few = room.oracle(vc.Exact(engine="auto")).block(eyes, lamps(room, 4))
    assert few.engine["shaft_queries"] == 0 and few.engine["left_to_packets"] == 12_000
    sky = vc.FarEnds.directions(np.random.default_rng(1).normal(size=(70, 3)))
    found = room.oracle(vc.Exact(engine="shafts")).block(eyes, sky)
    assert "no light is a point" in found.engine["no_shafts"]


def work_of(scene, integrator=WHITTED, **options):
    """What the engine of a default frame did; None if packets answered it all."""
    frame = vc.render(scene, integrator, **{"size": (150, 90), "spp": 2} | options)
    packets = vc.render(
        scene, integrator, visibility=PACKETS, **{"size": (150, 90), "spp": 2} | options
    )
    assert frame.sha256 == packets.sha256
    return frame.parameters.get("engine")


def test_by_default_the_tree_is_built_where_queries_pay_for_it():
    scene = vc.scenes.build("room?triangles=3000")  # a scene without a tree
    assert work_of(scene, size=(40, 24)) is None  # 1920 points x 150 lights < 256 x 3000 triangles
    assert work_of(scene)["shaft_queries"] > 0
    # Now the tree is there
    assert work_of(scene, size=(40, 24))["shaft_queries"] > 0


def test_by_default_packets_answer_points_that_ask_for_few_lights():
    scene = built("room?triangles=3000&lights=4")
    scene.shafts().memory_bytes()  # builds the tree
    work = work_of(scene, vc.Direct())
    assert work["shaft_queries"] == 0 < work["left_to_packets"]


def test_by_default_packets_answer_where_a_trial_leaves_many_rays():
    """Points farther apart than triangles: a node of 64 points has more of them than a list."""
    scene = built("random_triangles")
    scene.shafts().memory_bytes()
    tried = work_of(scene, size=(60, 40), spp=1)
    assert 0 < tried["shaft_queries"] < tried["left_to_packets"]
    assert tried["shaft_traced_packets"] > 0.33 * tried["shaft_asked_packets"]


def test_rays_that_are_not_robust_keep_packets_by_default():
    scene = built("room?triangles=3000")
    fast = vc.Embree(robust=False)
    frame = vc.render(scene, WHITTED, size=(150, 90), rays=fast)
    assert "engine" not in frame.parameters
    with pytest.raises(ValueError, match='engine="shafts"'):
        vc.render(scene, WHITTED, size=(150, 90), rays=fast, visibility=vc.Exact(engine="shafts"))


def test_exact_groups_of_the_quantized_cache_go_through_shafts():
    scene = built("room?triangles=3000&lights=24")
    options = {"size": (150, 90), "spp": 4}
    cache = vc.Aqvc(exact_groups=("point",))
    cold = vc.render(scene, WHITTED, visibility=cache, **options)
    assert cold.parameters["engine"]["shaft_queries"] == cold.counters["groups"]["point"]["queries"]
    lamps_alone = vc.render(scene, WHITTED, visibility=PACKETS, **options).layers["point"]
    assert np.array_equal(cold.layers["point"], lamps_alone)
    for threads in (1, 3):
        again = vc.render(scene, WHITTED, visibility=cache, threads=threads, **options)
        assert again.sha256 == cold.sha256


def leaves(**holes):
    """Large triangles in a closed box, half of them with holes."""
    random = np.random.default_rng(3)
    d = vc.SceneDescription()
    if "alpha_texture" in holes:
        holes["alpha_texture"] = d.add_image(random.random((64, 64, 1)).astype(np.float32))
    for material in (d.add_material(**holes), d.add_material()):
        corners = random.uniform(-1, 1, (60, 1, 3)) + random.normal(0, 0.3, (60, 3, 3))
        d.add_mesh(
            corners.reshape(-1, 3),
            np.arange(180).reshape(-1, 3),
            material=material,
            uvs=random.random((180, 2)),
        )
    return vc.Scene.from_description(d)


@pytest.mark.parametrize("holes", [{"alpha_texture": 0, "alpha_cutoff": 0.5}, {"opacity": 0.5}])
def test_holes_are_left_to_rays(holes):
    scene = leaves(**holes)
    eyes, ends = area_points(scene, 1500), lamps(scene, 64)
    assert count_of_differences(scene, eyes, ends) == 0
    assert differences(scene, positions(eyes), positions(ends)) == 0
    # The power of it: many answers hang on the holes
    solid = visible(leaves(), PACKETS, eyes, ends)
    assert np.count_nonzero(solid != visible(scene, PACKETS, eyes, ends)) > 1000


def same_bytes(scene, size, spp):
    """Of frames; of matrices between points on surfaces and in space."""
    cuts = vc.correlation.surface_points(scene, 3000, seed=3).positions
    space = np.random.default_rng(2).uniform(*scene.bounds, (2000, 3)).astype(np.float32)
    found = []
    for engine in ("packets", "shafts"):
        exact = vc.Exact(engine=engine)
        made = vc.render(scene, WHITTED, size=size, spp=spp, visibility=exact).sha256
        pairs = ((cuts, positions(area_points(scene, 130))), (space, cuts[:130]))
        matrices = [scene.visible_matrix(x, y, engine=exact.engine).tobytes() for x, y in pairs]
        found.append((made, *matrices))
    assert found[0] == found[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.release if n in ("hairball", "garden") else ())
        for n in sorted(vc.scenes.SCENES)
    ],
)
def test_built_in_scenes_have_the_bytes_of_packets(name):
    same_bytes(vc.scenes.build(name), (128, 96), 2)


def shared_scenes():
    folder = Path(SCENES or "/nonexistent")
    found = []
    for place in sorted(folder.iterdir()) if folder.is_dir() else []:
        files = [f for e in ("xml", "pbrt", "obj", "gltf", "glb") for f in place.glob(f"*.{e}")]
        found += sorted(files)[:1]
    return found


@pytest.mark.slow
@pytest.mark.skipif(not SCENES, reason="VISCACHE_SCENES is not set")
@pytest.mark.parametrize("path", shared_scenes(), ids=lambda p: p.parent.name)
def test_shared_scenes_have_the_bytes_of_packets(path):
    same_bytes(vc.load_scene(path, missing="skip"), (320, 200), 1)
