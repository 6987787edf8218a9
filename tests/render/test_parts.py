"""Frames in parts have the bytes of one piece; tiles are small and follow from the frame alone."""

import math
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest

import viscache as vc
from viscache.shot import tiles
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot

SCENE = "room?triangles=3000"
#: 16 samples: tiles of 64 × 64 pixels, 3 × 2 of them.
SIZE = {"size": (140, 70), "spp": 16, "seed": 3}


@pytest.fixture(scope="module")
def scene():
    return vc.scenes.build(SCENE)


@cache
def in_one_piece(scene, integrator, visibility):
    return vc.render(scene, integrator, visibility=visibility, **SIZE)


def assert_same(a, b):
    assert {n: p.tobytes() for n, p in a.layers.items()} == {
        n: p.tobytes() for n, p in b.layers.items()
    }
    # Every part draws audited pixels of its own
    one, other = ({n: c for n, c in f.counters.items() if n != "audit"} for f in (a, b))
    assert one == other and a.parameters == b.parameters
    assert ("audit" in a.counters) == ("audit" in b.counters)


@pytest.mark.parametrize(
    ("visibility", "parts"),
    [
        *((vc.Exact(), parts) for parts in (1, 5, 9)),
        *((vc.Aqvc(c_e=8), parts) for parts in (2, 9)),
        (vc.Aqvc(paper=vc.PaperForm(form="pairs")), 4),
    ],
)
def test_any_number_of_parts_gives_the_same_bytes(scene, visibility, parts):
    whitted = vc.Whitted(n_vpls=8)
    whole = in_one_piece(scene, whitted, visibility)
    found = tiles.render(scene, whitted, visibility=visibility, parts=parts, **SIZE)
    assert_same(whole, found)
    assert whole.counters["light_rays"] > 0


def test_parts_join_where_only_some_processes_have_the_tree_of_shafts():
    scenes = [vc.scenes.build(SCENE) for _ in range(2)]
    scenes[1].shafts().memory_bytes()  # builds the tree
    small = {"size": (300, 40), "seed": 3}  # at least two tiles
    whitted = vc.Whitted(n_vpls=40)
    for first in (0, 1):
        cut = [
            tiles.cut(
                render_part(BareShot(scenes[(first + i) % 2], whitted, **small), (i, 2)), i, 2
            )
            for i in range(2)
        ]
        joined = tiles.merge(cut)
        assert joined.sha256 == vc.render(scenes[0], whitted, **small).sha256
        assert [("engine" in part.frame.parameters) for part in cut] == [first == 1, first == 0]
        work = joined.parameters["engine"]
        assert work["shaft_queries"] + work["left_to_packets"] > 0


def test_workers_give_the_same_bytes_in_whatever_order_they_finish():
    import multiprocessing

    ao = vc.AmbientOcclusion(n_samples=2, max_distance=None)
    whole = vc.render(vc.scenes.build(SCENE), ao, **SIZE)
    with ThreadPoolExecutor(3) as pool:
        assert_same(whole, tiles.render(SCENE, ao, executor=pool, parts=7, **SIZE))
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert_same(whole, tiles.render(SCENE, ao, executor=pool, threads=1, **SIZE))


def test_parts_in_any_order_make_the_frame_and_a_missing_or_double_one_is_refused(scene):
    shot = BareShot(scene, vc.Direct(), **SIZE)
    cut = [tiles.cut(render_part(shot, (i, 4)), i, 4) for i in range(4)]
    assert_same(tiles.merge(cut), tiles.merge(cut[::-1]))
    assert_same(tiles.merge(cut), vc.render(scene, vc.Direct(), **SIZE))
    for wrong in (cut[:3], [*cut[:3], cut[2]], []):
        with pytest.raises(ValueError, match="parts must"):
            tiles.merge(wrong)


def test_boxes_of_all_parts_cover_every_pixel_once():
    for size, edge, parts in (((150, 140), 64, 5), ((1, 1), 4, 3), ((640, 400), 128, 20)):
        seen = np.zeros(size[::-1], int)
        for i in range(parts):
            for x0, y0, x1, y1 in tiles.tile_boxes(size, edge, i, parts):
                seen[y0:y1, x0:x1] += 1
        assert (seen == 1).all()


def test_a_live_view_sees_the_frame_grow(scene):
    seen = []

    def show(frame, done, total):
        seen.append((float((frame.layers["coverage"] > 0).mean()), done, total))

    frame = tiles.render(scene, vc.Direct(), parts=3, show=show, **SIZE)
    shares = [share for share, _, _ in seen]
    assert [s[1:] for s in seen] == [(1, 3), (2, 3), (3, 3)]
    assert 0 < shares[0] < shares[1] < shares[2] == (frame.layers["coverage"] > 0).mean()


def test_a_part_out_of_range_is_refused(scene):
    for part in ((2, 2), (-1, 2), (0, 0), (0, True)):
        with pytest.raises(ValueError, match=r"parts? must be in"):
            render_part(BareShot(scene, vc.Direct(), size=(8, 8)), part)
    with pytest.raises(ValueError, match="parts must be in"):
        tiles.render(scene, vc.Direct(), parts=-1, size=(8, 8))
    with pytest.raises(ValueError, match="must not be Bdpt"):
        tiles.render(scene, vc.Bdpt(), parts=2, size=(8, 8))


OWN_SKY = vc.Direct(n_area=0, n_environment=1, n_brdf=0)
SHARED_SKY = vc.Direct(n_area=0, environment="shared", n_environment=16)
FEW_DIRECTIONS = vc.Direct(n_area=0, environment="shared", n_environment=8)


@pytest.fixture(scope="module")
def cube():
    return vc.scenes.build("cube_on_plane").with_environment(1.0)


def edge(cube, size, spp=1, **options):
    frame = vc.render(cube, options.pop("integrator", OWN_SKY), size=size, spp=spp, **options)
    return int(frame.parameters["tile_edge_px"])


@pytest.mark.parametrize(
    ("size", "spp", "pixels"),
    [((512, 512), 1, 64), ((511, 448), 1, 32), ((192, 192), 1, 32), ((128, 128), 16, 16)],
)
def test_a_tile_has_64_squared_eye_samples_in_frames_of_64_tiles_or_more(cube, size, spp, pixels):
    assert edge(cube, size, spp) == pixels
    assert math.prod(math.ceil(n / pixels) for n in size) >= 36


def test_tiles_of_many_shared_directions_are_larger(cube):
    """The aligned batch sorts triangles once for all points of a tile."""
    sizes = ((256, 256), (512, 512), (1024, 1024))
    assert [edge(cube, size, integrator=SHARED_SKY) for size in sizes] == [64, 128, 256]
    assert edge(cube, (512, 512), integrator=FEW_DIRECTIONS) == 64


def test_tiles_depend_on_no_oracle_and_no_threads(cube):
    for visibility in ("exact", vc.Aqvc(exact_groups=()), vc.Exact(sky_engine="batch")):
        for threads in (1, 3):
            options = {"visibility": visibility, "threads": threads, "integrator": SHARED_SKY}
            assert edge(cube, (512, 512), **options) == 128
