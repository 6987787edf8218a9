"""Ctrl-C and progress while rendering; what is left afterwards is clean.

Each case runs in a process of its own: a timer sends SIGINT in the middle of a render that takes
far longer, and the process prints how long KeyboardInterrupt took. The promise is half a second on
an idle machine; tests share their cores with others, so the best of three counts.
"""

import subprocess
import sys
from pathlib import Path

import pytest

import viscache as vc
from render.mitsuba_scene import busy_scene

PROGRAM = """
import os, signal, sys, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
sys.path.insert(0, {tests!r})
from render.mitsuba_scene import busy_scene
import viscache as vc

SIZE = (2048, 2048)
many = vc.Whitted(n_vpls=1 << 13)
scene = busy_scene()
scene.caster()
small = vc.render(scene, vc.Direct(), size=(8, 8)).sha256
sent = []
def interrupt():
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
def attempt():
    sent.clear()
    timer = threading.Timer({delay}, interrupt)
    timer.start()
    try:
        {call}
    except KeyboardInterrupt:
        took = time.perf_counter() - sent[0]
        assert threading.active_count() <= 2, "threads are left over"
        return took
    timer.cancel()
    sys.exit("the render ended before the interruption: the test proves nothing")
took = [attempt()]
while min(took) >= {limit} and len(took) < 3:
    took.append(attempt())
assert vc.render(scene, vc.Direct(), size=(8, 8)).sha256 == small, "the state is not clean"
print(min(took))
"""


LIMIT = 0.5  # seconds from Ctrl-C to KeyboardInterrupt


def quickest_stop(call, delay=0.6):
    """The best of at most three tries: other work on the machine only ever makes a try slower."""
    best = float("inf")
    tests = str(Path(__file__).parents[1])
    program = PROGRAM.format(tests=tests, call=call, delay=delay, limit=LIMIT)
    for _ in range(3):
        command = [sys.executable, "-c", program]
        run = subprocess.run(command, capture_output=True, text=True, timeout=240)
        assert run.returncode == 0, run.stderr
        best = min(best, float(run.stdout))
        if best < LIMIT:
            break
    return best


CALLS = {
    "area samples": "vc.Direct(n_area=256), size=SIZE, spp=16",
    "65536 samples an eye point": "vc.Direct(n_area=65536), size=(512, 512)",
    "making VPLs": "vc.Whitted(n_vpls=1 << 14), size=SIZE",
    "rows of VPLs": "many, size=SIZE",
    "rows by pixel": "many, size=SIZE, visibility=vc.Exact(order='by_pixel', engine='packets')",
    "quantized": "many, size=SIZE, visibility=vc.Aqvc()",
    "bidirectional": "vc.Bdpt(), size=SIZE, spp=4",
    "the paper's form": "vc.Whitted(n_vpls=1024), size=SIZE, visibility=vc.Aqvc(preset='paper')",
    "ambient": "vc.AmbientOcclusion(n_samples=4096), size=(1024, 1024)",
    "camera rays": "vc.Direct(n_area=0, n_environment=0, n_brdf=0), size=(64, 64), spp=1 << 16",
    "with a bar": "vc.Direct(n_area=256), size=SIZE, spp=16, progress=True",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_ctrl_c_stops_a_render_soon(name):
    assert quickest_stop(f"vc.render(scene, {CALLS[name]})") < LIMIT


def test_ctrl_c_stops_a_long_query_soon():
    call = (
        "import numpy as np; x = np.random.default_rng(0).uniform(-3, 3, (4_000_000, 3));"
        " x = x.astype('f4'); [scene.visible(x, x[::-1]) for _ in range(250)]"
    )
    assert quickest_stop(call, delay=1.5) < LIMIT


def test_progress_counts_tiles_to_the_end():
    seen = []
    given = {"size": (64, 64), "spp": 16, "progress": lambda *at: seen.append(at)}
    vc.render(busy_scene(), vc.Direct(n_area=1), **given)
    done, total = zip(*seen, strict=True)
    assert done[-1] == total[-1] > 1 and list(done) == sorted(done)
    assert len(set(total) - {0}) == 1


def test_an_error_in_progress_ends_the_render_and_comes_back():
    def broken(done, total):
        raise RuntimeError("no more")

    scene = busy_scene()
    with pytest.raises(RuntimeError, match="no more"):
        vc.render(scene, vc.Direct(n_area=256), size=(1024, 1024), spp=16, progress=broken)
    assert vc.render(scene, vc.Direct(), size=(8, 8)).image.any()


def test_other_python_threads_run_while_rendering():
    import threading

    scene, ticks, stop = busy_scene(), [0], threading.Event()

    def count():
        while not stop.wait(0.01):
            ticks[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    frame = vc.render(scene, vc.Direct(n_area=16), size=(128, 128), spp=8)
    stop.set()
    counter.join()
    # One tick takes 10 ms; a held lock would let none through
    assert ticks[0] > frame.timings["total_s"] / 0.01 / 20
