"""Sweeps and processes: killed at any moment, several at one store, side by side or apart."""

import os
import random
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from codebase.repository import environment
from sweeps.stand_in import rows_of
from viscache.sweeps import work
from viscache.sweeps.leases import Leases
from viscache.sweeps.store import Store
from viscache.sweeps.sweep import sweep

HERE = Path(__file__).parents[1]
SMALL = {"size": (32, 24), "metrics": ("rel_l1",)}

#: A sweep of POINTS values over the stand-in renderer; every frame begun is a line of the log.
SWEEP = """
import os, sys, time
sys.path.insert(0, sys.argv[4])
from sweeps import fake_renderer as fake
from viscache.scenes import sources
from viscache.settings import by_name
from viscache.sweeps import work
from viscache.sweeps.sweep import sweep

for role, name, settings in fake.NAMES:
    by_name.NAMES[role][name] = settings
sources.open_scene = lambda spec, **_: fake.FakeScene(name=spec)
log = os.open(sys.argv[2], os.O_WRONLY | os.O_APPEND | os.O_CREAT)

def render(scene, integrator, **options):
    setting = getattr(options["visibility"], "c_e", "exact")
    os.write(log, f"begin {setting} {os.getpid()}\\n".encode())
    time.sleep(0.01)
    frame = fake.fake_render(scene, integrator, **options)
    os.write(log, f"end {setting} {os.getpid()}\\n".encode())
    return frame

work.render_function = render
apart = {"yes": True, "no": False}[sys.argv[5]]
sweep("room", "whitted", over={"c_e": list(range(1, 1 + int(sys.argv[3])))}, size=(32, 24),
      metrics=["rel_l1"], directory=sys.argv[1], apart=apart)
"""


def start(directory, log, points, apart="no"):
    words = [str(directory), str(log), str(points), str(HERE), apart]
    return subprocess.Popen([sys.executable, "-c", SWEEP, *words], env=environment())


def begun(log):
    lines = log.read_text().splitlines() if log.exists() else []
    return [line.split()[1] for line in lines if line.startswith("begin")]


@pytest.mark.slow
def test_a_sweep_killed_at_any_moment_loses_nothing_and_repeats_one_frame_at_most(tmp_path):
    log, rng, kills, points = tmp_path / "log", random.Random(5), 0, 60
    directory = tmp_path / "sweep"
    while kills < 5:
        process = start(directory, log, points)
        before = len(begun(log))
        while len(begun(log)) < before + 4 and process.poll() is None:
            time.sleep(0.005)
        time.sleep(rng.random() * 0.05)
        if process.poll() is not None:
            break
        process.send_signal(signal.SIGKILL)
        process.wait()
        kills += 1
        with Store(directory) as store:  # whatever is recorded can be read
            for key in store.finished():
                assert store.frame(key).sha256 == store.get(key).sha256
    assert kills == 5
    assert start(directory, log, points).wait(60) == 0
    rows = rows_of(directory)
    assert [float(r["c_e"]) for r in rows] == list(range(1, 1 + points))
    np.testing.assert_allclose([float(r["rel_l1"]) * 100 for r in rows], range(1, 61), rtol=1e-5)
    assert len(begun(log)) - (points + 1) <= kills  # one frame is under way at a time
    assert set(begun(log)) == {"exact", *map(str, range(1, 1 + points))}


@pytest.mark.parametrize("threads", [0, 2])
def test_a_frame_finished_between_look_up_and_claim_is_not_rendered_again(
    threads, fake_vc, tmp_path, monkeypatch
):
    """Another process finishes every frame just before this one claims it."""
    mine, other = tmp_path / "mine", tmp_path / "other"
    over = {"c_e": [4, 8]}
    sweep("room", "whitted", over=over, directory=other, **SMALL)
    fake_vc.CALLS.clear()
    claim, overtaken = Leases.claim, []

    def late(self, key):
        if not key.startswith("turn") and key not in overtaken:
            with Store(mine) as rival, Store(other) as finished:
                assert claim(rival.leases, key) and rival.adopt(key, finished)
            overtaken.append(key)
        return claim(self, key)

    monkeypatch.setattr(Leases, "claim", late)
    with ThreadPoolExecutor(2) as pool:
        executor = pool if threads else None
        ds = sweep("room", "whitted", over=over, directory=mine, executor=executor, **SMALL)
    assert len(overtaken) == 3 and not fake_vc.CALLS
    np.testing.assert_allclose(ds.rel_l1[:, 0], [0.04, 0.08], rtol=1e-5)
    with Store(mine) as store:  # no claim is left behind
        assert all(claim(store.leases, key) for key in overtaken)


def side_by_side(log):
    """The most frames that were under way at once."""
    now = most = 0
    for line in log.read_text().splitlines():
        now += 1 if line.startswith("begin") else -1
        most = max(most, now)
    return most


@pytest.mark.slow
def test_frames_that_are_timed_never_run_side_by_side(tmp_path):
    most = {}
    for apart in ("yes", "no"):
        log = tmp_path / f"log-{apart}"
        workers = [start(tmp_path / apart, log, 30, apart) for _ in range(3)]
        assert [w.wait(60) for w in workers] == [0, 0, 0]
        most[apart] = side_by_side(log)
        assert sorted(begun(log)) == sorted(["exact", *map(str, range(1, 31))])  # each once
        told = {row["alone"] for row in rows_of(tmp_path / apart)}
        assert told == {"1" if apart == "yes" else "0"}
    assert most["yes"] == 1 < most["no"]


def test_an_executor_renders_side_by_side_unless_told_otherwise(fake_vc, monkeypatch):

    running, most = [], []

    def slow(*arguments, **options):
        running.append(1)
        most.append(len(running))
        time.sleep(0.01)
        frame = fake_vc.fake_render(*arguments, **options)
        running.pop()
        return frame

    monkeypatch.setattr(work, "render_function", slow)
    over = {"c_e": list(range(1, 9))}
    with ThreadPoolExecutor(3) as pool:
        ds = sweep("room", "whitted", over=over, executor=pool, **SMALL)
        assert max(most) == 3 and not ds.alone.any()
        most.clear()
        ds = sweep("room", "whitted", over=over, executor=pool, apart=True, **SMALL)
        assert max(most) == 1 and ds.alone.all()


def test_workers_end_when_the_process_that_made_them_is_killed():
    code = (
        "import os, time\nfrom viscache.base.workers import process_pool\n"
        "if __name__ == '__main__':\n"
        "    with process_pool(2) as pool:\n"
        "        print(pool.submit(os.getpid).result(), flush=True)\n"
        "        time.sleep(60)\n"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", code], env=environment(), stdout=subprocess.PIPE, text=True
    )
    worker = int(parent.stdout.readline())
    os.kill(worker, 0)
    parent.kill()
    parent.wait()
    parent.stdout.close()
    for _ in range(100):
        try:
            state = Path(f"/proc/{worker}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return
        if state == "Z":
            return
        time.sleep(0.05)
    pytest.fail("the worker outlived the process that made it")


def test_references_are_shared_between_sweeps_by_content(fake_vc, tmp_path):
    common = {"references": tmp_path / "references", "converged": {"spp": 16}, **SMALL}
    sweep("room", "whitted", over={"c_e": [4, 8]}, directory=tmp_path / "a", **common)
    assert len(fake_vc.CALLS) == 2 + 2
    ds = sweep("room", "whitted", over={"c_e": [5, 6]}, directory=tmp_path / "b", **common)
    assert len(fake_vc.CALLS) == 4 + 2
    np.testing.assert_allclose(ds.rel_l1[:, 0], [0.05, 0.06], rtol=1e-5)
    assert ds.exact_converged_rel_l1.notnull().all()
    in_memory = sweep("room", "whitted", over={"c_e": [5]}, **common)
    assert len(fake_vc.CALLS) == 7 and in_memory.rel_l1.item() == pytest.approx(0.05, rel=1e-5)
    with Store(tmp_path / "references") as store:
        assert len(store.finished()) == 2


def test_where_the_time_went_is_told(fake_vc, tmp_path):
    import json

    ds = sweep("room", "whitted", over={"c_e": [4, 8]}, directory=tmp_path, **SMALL)
    seconds = json.loads(ds.attrs["seconds"])
    parts = seconds["frames"] + seconds["metrics"] + seconds["store"]
    assert 0 < parts <= seconds["total"] + 0.003


def test_a_scene_gets_its_environment_once_and_not_once_per_frame(tmp_path, monkeypatch):
    import viscache as vc

    made = []
    original = vc.Scene.with_environment

    def counted(self, *arguments, **options):
        made.append(1)
        return original(self, *arguments, **options)

    monkeypatch.setattr(vc.Scene, "with_environment", counted)
    scene = vc.scenes.build("cube_on_plane")
    sky = np.full((8, 16, 3), 0.5, np.float32)
    direct = vc.Direct(n_environment=4)
    ds = sweep(
        scene,
        direct,
        over={"c_e": [4, 8]},
        env=sky,
        size=(24, 16),
        metrics=["rel_l1"],
        directory=tmp_path,
    )
    assert len(made) == 1 and ds.rel_l1.notnull().all()
    for row in rows_of(tmp_path):
        alone = vc.render(
            scene, direct, visibility=vc.Aqvc(c_e=float(row["c_e"])), env=sky, size=(24, 16)
        )
        assert vc.Frame.load(tmp_path / row["frame"]).sha256 == alone.sha256


def test_a_worker_loads_a_scene_once(monkeypatch):
    import viscache as vc
    from viscache.scenes import sources

    opened = []
    original = sources.open_scene

    def counted(spec, **options):
        opened.append(spec)
        return original(spec, **options)

    monkeypatch.setattr(sources, "open_scene", counted)

    class Here(ThreadPoolExecutor):
        """Takes scenes by name, as workers in other processes do."""

        def submit(self, function, task, scene):
            return super().submit(function, task, None)

    with Here(2) as pool:
        sweep(
            "cube_on_plane",
            vc.Direct(),
            over={"c_e": [1, 2, 4, 8]},
            executor=pool,
            size=(24, 16),
            metrics=["rel_l1"],
        )
    assert opened == ["cube_on_plane"] * 2  # the sweep itself, and its workers together
