"""A real dask scheduler with two local worker processes, one of which is killed."""

import json
import os
import shlex
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
import xarray

import viscache as vc
from viscache import cli
from viscache.base import workers
from viscache.sweeps.store import Store
from viscache.sweeps.sweep import sweep

sys.path.insert(0, str(Path(__file__).parent))
from logged import Logged

pytest.importorskip("distributed", reason="dask comes with the test extra")
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default")]  # warnings of dask itself

SCENE = "room?triangles=3000"
#: Until a worker has finished its first tasks, on a slow machine with other work.
SLOWEST_START_S = 120.0


@dataclass
class Cluster:
    """The processes of a cluster."""

    folder: Path
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def address(self):
        return str(json.loads((self.folder / "scheduler.json").read_text())["address"])

    def wait_for_address(self):
        file = self.folder / "scheduler.json"
        for _ in range(1200):  # it is there before it is written
            if file.exists() and file.read_text().rstrip().endswith("}"):
                return
            time.sleep(0.05)
        raise AssertionError((self.folder / "scheduler.log").read_text())

    def add_worker(self):
        words = shlex.split("worker --no-nanny --nthreads 1 --host 127.0.0.1")
        words += ["--name", str(len(self.workers)), "--local-directory", str(self.folder)]
        self.workers.append(_dask(self.folder, *words))

    @contextmanager
    def losing_a_worker(self, run, after):
        """Kill a worker while the block runs; afterwards the list has its process."""
        killed = []
        killer = threading.Thread(
            target=lambda: killed.append(self._kill_within_a_task(run, after)),
            daemon=True,  # a block that fails does not wait for it
        )
        killer.start()
        yield killed
        killer.join()
        assert killed, "a worker must have been killed within a task"

    def _kill_within_a_task(self, run, after):
        """Kill a worker that is in a task, once `after` tasks were finished; its process."""
        until = time.monotonic() + SLOWEST_START_S
        while time.monotonic() < until:
            lines = run.lines()
            ended = [pid for word, pid in lines if word == "end"]
            busy = [pid for word, pid in lines if word == "begin"]
            for worker in self.workers:
                if len(ended) >= after and busy.count(worker.pid) > ended.count(worker.pid):
                    worker.kill()
                    worker.wait()
                    return worker.pid
            time.sleep(0.002)
        raise AssertionError("no worker was within a task")


def _dask(folder, *words):
    here = [str(Path(__file__).parent), *(p for p in sys.path if p)]
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(here),
        "DASK_DISTRIBUTED__WORKER__MEMORY__TERMINATE": "0",
    }
    command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
    command += ["--scheduler-file", str(folder / "scheduler.json")]
    with (folder / f"{words[0]}.log").open("ab") as log:
        return subprocess.Popen(command, env=environment, stdout=log, stderr=log)


@pytest.fixture
def cluster(tmp_path):
    folder = tmp_path / "cluster"
    folder.mkdir()
    made = Cluster(folder, _dask(folder, "scheduler", "--host", "127.0.0.1", "--port", "0"))
    made.add_worker()
    made.add_worker()
    made.wait_for_address()
    yield made
    for process in [*made.workers, made.scheduler]:
        process.kill()
        process.wait()


@pytest.fixture
def run(cluster, tmp_path):
    with workers.dask_executor(cluster.address) as executor:
        executor._client.wait_for_workers(2, timeout=60)
        yield Logged(executor, tmp_path / "tasks.log")


def test_a_sweep_loses_nothing_and_has_nothing_twice_when_a_worker_is_killed(
    cluster, run, tmp_path
):
    arguments = {
        "over": {"c_e": [4, 6, 8, 10, 12, 16]},
        "repeats": 3,
        "size": (48, 32),
        "threads": 1,
        "metrics": ["rel_l1", "rmse"],
    }
    whitted = vc.Whitted(n_vpls=32)
    here = sweep(SCENE, whitted, **arguments)
    steps = []
    with cluster.losing_a_worker(run, after=6) as killed:
        there = sweep(
            SCENE,
            whitted,
            executor=run,
            directory=tmp_path / "sweep",
            progress=lambda done, total: steps.append(done),
            **arguments,
        )
    frames = 3 + 18
    assert steps == list(range(1, 1 + frames)) and run.submitted == frames
    lines = run.lines()
    begun = [pid for word, pid in lines if word == "begin"]
    ended = [pid for word, pid in lines if word == "end"]
    assert begun.count(killed[0]) > ended.count(killed[0])
    # Only running tasks of the dead worker, and results not handed over, are repeated
    assert 1 <= len(begun) - frames <= 3
    assert len(set(begun)) == 2
    for name in ("rel_l1", "rmse", "rays", "queries"):
        xarray.testing.assert_equal(here[name], there[name])
    with Store(tmp_path / "sweep") as store:
        assert len(store.finished()) == frames
        assert store._db.execute("SELECT count(*) FROM leases").fetchone() == (0,)


def test_the_command_line_sweeps_on_a_scheduler(cluster, tmp_path, capsys):
    file = tmp_path / "a.toml"
    file.write_text(
        f'scene = "{SCENE}"\nintegrator = {{name = "whitted", n_vpls = 16}}\nsize = [32, 24]\n'
        'metrics = ["rel_l1"]\nthreads = 1\n[over]\nc_e = [4, 8]\n'
    )
    words = ["sweep", str(file), "-o", str(tmp_path / "out"), "--dask", cluster.address, "--json"]
    assert cli.main(words) == 0
    assert json.loads(capsys.readouterr().out)["sizes"]["c_e"] == 2
    with Store(tmp_path / "out") as store:
        assert len(store.finished()) == 3


def test_an_address_where_nobody_answers_is_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(workers, "DASK_TIMEOUT", "1s")
    file = tmp_path / "a.toml"
    file.write_text('scene = "room"\n[over]\nc_e = [4]\n')
    words = ["sweep", str(file), "-o", str(tmp_path / "out"), "--dask", "tcp://127.0.0.1:9"]
    assert cli.main(words) == 2
    assert "no dask scheduler answers at tcp://127.0.0.1:9" in capsys.readouterr().err
