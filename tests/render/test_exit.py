"""The interpreter ends while other threads are in long calls: the process ends without a word."""

import subprocess
import sys
from pathlib import Path

import pytest

# A daemon thread starts a call that would take minutes; the program ends in the middle of it.
PROGRAM = """
import sys, threading, time
sys.path.insert(0, {tests!r})
from render.mitsuba_scene import busy_scene
import viscache as vc

class Slow:
    def block(self, eyes, lamps, wanted):
        begun.set()
        time.sleep({pause})
        return eyes.trace(lamps, wanted)

scene = busy_scene()
scene.caster()
BIG = dict(size=(2048, 2048), spp=64)
begun = threading.Event()

def work():
    {body}

for _ in range({n}):
    threading.Thread(target=work, daemon=True).start()
begun.wait(20)
time.sleep(0.2)
print("end", flush=True)
"""

RENDER = "begun.set(); vc.render(scene, vc.Direct(n_area=64), **BIG)"
PROGRESS = "vc.render(scene, vc.Direct(n_area=64), progress=lambda *_: begun.set(), **BIG)"
ORACLE = "vc.render(scene, vc.Whitted(n_vpls=64), visibility=Slow(), threads=2, **BIG)"
STUBBORN = """
    while True:
        try:
            begun.set()
            vc.render(scene, vc.Direct(n_area=64), **BIG)
        except BaseException:
            pass
"""
QUICK = """
    while True:
        begun.set()
        scene.visible([[0, 1, 2]], [[0, 1, 1]])
"""
BUILD = "begun.set(); scene.caster(vc.Vlf(n_directions=2049, n_tiles=512))"


def run(body, *, n=1, pause=0, before="", daemon=True):
    program = before + PROGRAM.replace("daemon=True", f"daemon={daemon}").format(
        tests=str(Path(__file__).parents[1]), body=body, n=n, pause=pause
    )
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.parametrize(
    ("body", "n", "pause"),
    [
        pytest.param(RENDER, 3, 0, id="three frames"),
        pytest.param(PROGRESS, 1, 0, id="a frame with progress"),
        pytest.param(ORACLE, 2, 0, id="an oracle written in Python"),
        pytest.param(STUBBORN, 2, 0, id="a thread that takes every exception"),
        pytest.param(QUICK, 2, 0, id="short calls in a loop"),
        pytest.param(BUILD, 1, 0, id="a structure that is being built"),
        pytest.param(ORACLE, 1, 1000, id="a call that never ends", marks=pytest.mark.slow),
    ],
)
def test_the_process_ends_quietly_while_a_daemon_works(body, n, pause):
    ended = run(body, n=n, pause=pause)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "end\n", "")


def test_the_thread_that_ends_the_interpreter_may_still_render():
    # Hooks that were registered before the import run after ours.
    before = """if True:
    import atexit
    @atexit.register
    def last():
        import viscache as vc
        print(vc.render(vc.scenes.cube_on_plane(), vc.Direct(), size=(8, 8)).image.shape)
    """
    ended = run(RENDER, before=before)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "end\n(8, 8, 3)\n", "")


def test_a_forked_process_does_not_wait_for_the_threads_of_its_parent():
    fork = """
    begun.set()
    vc.render(scene, vc.Direct(n_area=64), **BIG)
import os, warnings
warnings.simplefilter("ignore")
def forked():
    begun.wait(20)
    time.sleep(0.2)
    start = time.perf_counter()
    if child := os.fork():
        status = os.waitpid(child, 0)[1]
        print("child", status, time.perf_counter() - start < 4)
    else:
        os._exit = sys.exit
        sys.exit(0)
import atexit
atexit.register(forked)
"""
    ended = run(fork)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines()[-1] == "child 0 True"


def test_a_thread_that_is_no_daemon_ends_its_frame_first():
    frame = "vc.render(scene, vc.Direct(n_area=64), size=(128, 128), threads=1)"
    ended = run(f"begun.set(); print({frame}.image.shape)", daemon=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.splitlines()[-1] == "(128, 128, 3)"
