"""Objects in several threads: the same object, the same bytes, or a clear refusal."""

import copy
import os
import pickle
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import viscache as vc
from codebase.repository import sources
from viscache import _core
from viscache.base.sharing import MadeOnce, Newest, Turn

SMALL = {"size": (16, 10), "threads": 1}
LAZILY = "@cached_property"
FIELD = vc.Vlf(n_directions=9, n_tiles=4)


@pytest.fixture
def quick_switches():
    """Threads change at almost every step."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def at_once(calls):
    """What calls return that begin at the same time, each in its own thread."""
    start = threading.Barrier(len(calls))

    def one(call):
        start.wait()
        return call()

    with ThreadPoolExecutor(len(calls)) as pool:
        return list(pool.map(one, calls))


@pytest.mark.parametrize("kept", [MadeOnce, Newest])
def test_threads_get_one_object(kept):
    cache, calls = kept(), []

    def make():
        calls.append(1)
        time.sleep(0.02)
        return object()

    made = at_once([lambda: cache.get("a", make)] * 8)
    assert len(calls) == 1 and len(set(map(id, made))) == 1


def test_what_is_made_may_ask_for_another_and_a_failure_leaves_nothing():
    cache = MadeOnce()
    assert cache.get("a", lambda: cache.get("b", lambda: 1) + 1) == 2 and "b" in cache
    with pytest.raises(ZeroDivisionError):
        cache.get("c", lambda: 1 // 0)
    assert "c" not in cache and cache.get("c", lambda: 3) == 3


def test_the_newest_alone_is_kept():
    cache = Newest()
    assert (cache.get(1, lambda: 2), cache.get(2, lambda: 4)) == (2, 4)
    assert 1 not in cache and 2 in cache


LAZY = {
    "embree": lambda scene: scene.caster(vc.Embree(watertight=True)),
    "bsp": lambda scene: scene.caster("bsp"),
    "aligned": lambda scene: scene.aligned_batch(),
    "shafts": lambda scene: scene.shafts(),
    "warnings": lambda scene: scene.warnings,
    "hash": lambda scene: scene.content_hash,
    "geometry": lambda scene: scene.geometry_hash,
    "coplanar": lambda scene: scene.coplanar_share,
}


@pytest.mark.parametrize("name", LAZY)
def test_a_scene_makes_each_of_its_parts_once(name, quick_switches):
    scene = vc.scenes.cube_on_plane()
    made = at_once([lambda: LAZY[name](scene)] * 6)
    assert len(set(map(id, made))) == 1


def test_casters_in_turns_are_the_ones_asked_for(quick_switches):
    """The scene keeps one of them at a time."""
    scene = vc.scenes.cube_on_plane()
    kinds = {vc.Bsp(): _core.visibility.BspCaster, FIELD: _core.vlf.VisibilityField}

    def ask(rays):
        return lambda: all(type(scene.caster(rays, threads=1)) is kinds[rays] for _ in range(40))

    assert all(at_once([ask(rays) for rays in kinds] * 2))


def test_no_property_is_made_twice_by_two_threads():
    """`functools.cached_property` has no lock from Python 3.12 on. The lab has one thread."""
    files = sources(".py", under="python/viscache/")
    assert [path for path, text in files.items() if LAZILY in text] == []


def test_turns_are_taken_in_order():
    """A thread that comes again at once does not keep out one that waits."""
    turn, order = Turn("it"), []

    def other():
        with turn:
            order.append("other")

    thread = threading.Thread(target=other)
    with turn:
        thread.start()
        time.sleep(0.05)
    for _ in range(3):
        with turn:
            order.append("first")
    thread.join()
    assert order == ["other", "first", "first", "first"]


def test_calls_within_a_call_are_let_in_or_refused():
    with (again := Turn("it", again=True)), again:
        pass
    turn = Turn("it")
    with turn, pytest.raises(ValueError, match="it must not be in use by another call"), turn:
        pass
    at_once([turn.__enter__])  # it is free again


def test_a_turn_that_does_not_wait_is_refused():
    turn = Turn("it", waits=False)
    with turn, pytest.raises(ValueError, match="it must not be in use by another call"):
        at_once([turn.__enter__])
    with turn:
        pass


def in_child(call):
    """What a call says in a forked child, which must end within five seconds."""
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            signal.alarm(5)
            os.write(writes, call().encode())
        finally:
            os._exit(0)
    os.close(writes)
    with os.fdopen(reads, "rb") as answer:
        said = answer.read().decode()
    assert os.waitpid(child, 0)[1] == 0
    return said


def refusal(call):
    try:
        call()
    except (ValueError, TypeError) as error:
        return str(error)
    return "done"


def test_a_child_that_was_forked_meanwhile_is_refused_and_does_not_hang():
    cache = vc.VisibilityMapCache(vc.scenes.cube_on_plane(), vc.MapSettings(m=4, n_startup=5))
    other = vc.VisibilityMapCache(cache.scene, cache.settings)
    began, end = threading.Event(), threading.Event()

    def wait(done, total):
        began.set()
        end.wait()

    thread = threading.Thread(target=lambda: cache.update(size=(8, 6), progress=wait, threads=1))
    thread.start()
    try:
        assert began.wait(5)
        told = in_child(lambda: refusal(cache.records) + "; " + refusal(other.records))
    finally:
        end.set()
        thread.join()
    assert told.startswith("the cache must not be in use by another thread when the process forks")
    assert told.endswith("; done")
    assert len(cache) > 0 and in_child(lambda: refusal(cache.records)) == "done"


def test_a_child_makes_what_another_thread_was_making():
    cache, began, end = MadeOnce(), threading.Event(), threading.Event()

    def make():
        began.set()
        end.wait()
        return "made"

    thread = threading.Thread(target=lambda: cache.get("a", make))
    thread.start()
    try:
        assert began.wait(5)
        assert in_child(lambda: str(cache.get("a", lambda: "made here"))) == "made here"
    finally:
        end.set()
        thread.join()
    assert cache.get("a", make) == "made"


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_objects_with_a_state_are_not_copied(copied):
    scene = vc.scenes.cube_on_plane()
    for one in (
        vc.Progressive(scene, "direct", **SMALL),
        vc.VisibilityMapCache(scene),
        vc.AqvcRows(),
        vc.AqvcTable(),
        vc.VoxelCounts(),
        vc.vlf.DynamicField(scene, FIELD),
    ):
        with pytest.raises(TypeError, match=f"{type(one).__name__} must not be copied or pickled"):
            copied(one)


PICTURES = {
    "rows": {"integrator": vc.Whitted(n_vpls=8), "visibility": vc.Aqvc()},
    "counts": {"integrator": vc.Whitted(n_vpls=8), "visibility": vc.NeePlusPlus(n_voxels=4)},
    "maps": {
        "integrator": vc.Direct(environment="product", n_environment=2),
        "visibility": vc.VisMaps(m=4, n_startup=5),
        "env": 1.0,
    },
}


@pytest.mark.parametrize("kind", PICTURES)
def test_a_picture_is_saved_whole_while_it_is_rendered(kind, tmp_path, quick_switches):
    scene, path = vc.scenes.cube_on_plane(), tmp_path / "state.npz"

    def picture():
        return vc.Progressive(scene, **PICTURES[kind], **SMALL)

    shared, saved, seen, ended = picture(), [], [], threading.Event()
    shared.passes(1)

    def render():
        try:
            while len(saved) < 3 and shared.n_passes < 100:
                shared.passes(1)
        finally:
            ended.set()

    def save():
        while not ended.is_set():
            shared.save(path)
            again = picture()
            again.load(path)
            saved.append((again.n_passes, again.frame.sha256))

    def look():
        while not ended.is_set():
            frame = shared.frame
            seen.append((frame.parameters["passes"], frame.sha256))
            time.sleep(0.005)

    at_once([render, save, look])
    alone = picture()
    shas = [(n + 1, alone.passes(1).sha256) for n in range(shared.n_passes)]
    assert set(saved) | set(seen) <= set(shas) and saved == sorted(saved)
    again = picture()
    again.load(path)
    assert again.passes(shared.n_passes - again.n_passes).sha256 == shared.frame.sha256


def test_threads_that_render_one_picture_render_each_pass_once():
    def picture():
        return vc.Progressive(vc.scenes.cube_on_plane(), vc.Whitted(n_vpls=8), **SMALL)

    shared = picture()
    at_once([lambda: shared.passes(2)] * 3)
    assert shared.frame.sha256 == picture().passes(6).sha256


def test_a_save_within_a_pass_is_refused(tmp_path):
    """As from a handler of a signal, which runs in the thread of the pass."""
    picture = vc.Progressive(vc.scenes.cube_on_plane(), vc.Direct(), **SMALL)
    picture.passes(1)
    with picture._turn:
        told = refusal(lambda: picture.save(tmp_path / "state.npz"))
        assert picture.frame.sha256  # which reads finished passes alone
    assert told == "the picture must not be in use by another call"
    assert list(tmp_path.iterdir()) == []


def test_all_objects_in_threads_give_the_same_bytes(quick_switches):
    scene, lights = vc.scenes.cube_on_plane(), vc.Whitted(n_vpls=8)
    rng = np.random.default_rng(1)
    eyes = vc.EyePoints(rng.uniform(-2, 2, (50, 3)), np.tile([0, 1.0, 0], (50, 1)))
    ends = vc.FarEnds.points(rng.uniform(-2, 3, (20, 3)))
    oracle, field = scene.oracle(vc.Aqvc(c_e=8)), vc.VisibilityField(scene, 9, 4)
    asked = vc.connections(scene, lights, **SMALL)
    cache = vc.VisibilityMapCache(scene, vc.MapSettings(m=4, n_startup=5))
    cache.update(size=(8, 6))
    relighting = vc.Relighting(cache, size=(8, 6), threads=1)
    moving = vc.vlf.DynamicField(scene, vc.Vlf(n_directions=9, n_tiles=4, head_room=3.0))
    up = np.tile([0, 1.0, 0], (50, 1))

    def move():
        one = moving.insert([[0, 2, 0], [1, 2, 0], [0, 2, 1]], [[0, 1, 2]])
        moving.transform(one, np.eye(4))
        moving.delete(one)
        return b""

    calls = [
        lambda: vc.render(scene, lights, visibility="aqvc", **SMALL).sha256,
        lambda: vc.render(scene, lights, visibility=vc.ShadowMap(resolution=16), **SMALL).sha256,
        lambda: oracle.block(eyes, ends).bits.tobytes(),
        lambda: asked.frame(asked.answers(vc.Aqvc())).sha256,
        lambda: field.occluded(eyes.positions, up).tobytes(),
        lambda: scene.visible(eyes.positions, eyes.positions[::-1], rays=FIELD).tobytes(),
        lambda: scene.visible(eyes.positions, eyes.positions[::-1], rays="bsp").tobytes(),
        lambda: cache.lookup(eyes.positions, up, 1.0).ids.tobytes(),
        lambda: relighting.under(1.0).sha256,
        lambda: moving.occluded(eyes.positions - [0, 9, 0], -up).tobytes(),
        move,
    ]
    expected = [call() for call in calls]

    def repeat(call):
        return lambda: [call() for _ in range(4)]

    for one, found in zip(expected, at_once([repeat(call) for call in calls]), strict=True):
        assert found == [one] * 4
