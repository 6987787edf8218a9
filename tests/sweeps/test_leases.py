"""Leases: who stopped loses its frames within a minute, who lives never; clocks do not count."""

import json
import logging
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from codebase.repository import environment
from viscache.frame import Frame
from viscache.sweeps import leases
from viscache.sweeps.leases import LostLeaseError
from viscache.sweeps.store import Store, picture_name

KEY = "a" * 64
#: Seconds between beats in these tests, and of silence.
BEAT_S, SILENT_S = 0.02, 0.6


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(leases, "BEAT_S", BEAT_S)
    monkeypatch.setattr(leases, "SILENT_S", SILENT_S)


def frame(value=1.0):
    return Frame(layers={"color": np.full((3, 4, 3), value)}, counters={"rays": 5})


#: Claims a key and says so; then renders it when a line comes, and tells how that ended.
OWNER = """
import sys, time
import numpy as np
from viscache.frame import Frame
from viscache.sweeps import leases
from viscache.sweeps.store import Store

leases.BEAT_S = float(sys.argv[3])
store = Store(sys.argv[1])
assert store.leases.claim(sys.argv[2])
print("claimed", flush=True)
sys.stdin.readline()
try:
    store.put(sys.argv[2], {}, Frame(layers={"color": np.full((3, 4, 3), 7.0)}))
    print("stored", flush=True)
except leases.LostLeaseError as error:
    print("lost", error, flush=True)
"""


class Owner:
    """A process that holds the lease of a key."""

    def __init__(self, folder, before, beat_s=BEAT_S):
        self.process = subprocess.Popen(
            [*before, sys.executable, "-c", OWNER, str(folder), KEY, str(beat_s)],
            env=environment(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.says() == "claimed\n"

    def says(self):
        return self.process.stdout.readline()

    def renders(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self.says()


@pytest.fixture
def owner(tmp_path):
    made = []

    def make(*before, **given):
        made.append(Owner(tmp_path, [*before], **given))
        return made[-1]

    yield make
    for one in made:
        one.process.send_signal(signal.SIGCONT)
        one.process.kill()
        one.process.communicate()


def seconds_until_claimed(store, most=10.0):
    began = time.monotonic()
    while not store.leases.claim(KEY):
        assert time.monotonic() - began < most, "the lease was not taken over"
        time.sleep(0.01)
    return time.monotonic() - began


def assert_kept(store, silences):
    """That the lease stays that of another, for so many times SILENT_S."""
    end = time.monotonic() + silences * SILENT_S
    while time.monotonic() < end:
        assert not store.leases.claim(KEY)
        time.sleep(0.01)


def change(folder, of_process=None, **columns):
    """Change the lease of the key, as another machine would have written it."""
    with sqlite3.connect(folder / "sweep.sqlite") as db:
        if of_process is not None:
            (text,) = db.execute("SELECT process FROM leases").fetchone()
            columns["process"] = json.dumps(json.loads(text) | of_process)
        for name, value in columns.items():
            db.execute(f"UPDATE leases SET {name} = ?", (value,))
    db.close()


def test_only_one_of_two_stores_gets_a_lease(tmp_path):
    with Store(tmp_path) as one, Store(tmp_path) as two:
        assert one.leases.claim(KEY) and one.leases.claim(KEY)
        assert not two.leases.claim(KEY)
        one.leases.release(KEY)
        assert two.leases.claim(KEY) and not one.leases.claim(KEY)
        two.put(KEY, {}, frame())
        assert one.get(KEY) is not None and not two.leases.holds(KEY)


def test_the_lease_of_a_killed_process_is_taken_over_at_once(tmp_path, owner, monkeypatch):
    monkeypatch.setattr(leases, "SILENT_S", 1000.0)
    killed = owner()
    with Store(tmp_path) as store:
        assert not store.leases.claim(KEY)
        killed.process.kill()
        assert seconds_until_claimed(store) < 1  # also before anybody has waited for its end
        killed.process.wait()
        assert store.leases.holds(KEY)


def test_a_store_that_could_not_give_its_lease_back_blocks_nobody_here(tmp_path):
    """As on a full disk, which refuses that, too."""
    with Store(tmp_path) as one:
        assert one.leases.claim(KEY)
        rows = one._db.execute("SELECT * FROM leases").fetchall()
    with Store(tmp_path) as two:
        two._db.executemany("INSERT INTO leases VALUES (?, ?, ?, ?, ?)", rows)
        assert two.leases.claim(KEY)


def test_a_number_of_a_process_that_runs_again_is_another_process(tmp_path, owner, monkeypatch):
    monkeypatch.setattr(leases, "SILENT_S", 1000.0)
    killed = owner()
    killed.process.kill()
    killed.process.wait()
    change(tmp_path, {"pid": os.getpid()})  # as if this process had its number
    with Store(tmp_path) as store:
        assert store.leases.claim(KEY)


def namespace(*words):
    """A command in a space of process numbers of its own, or a skip."""
    if shutil.which("unshare") is None:
        pytest.skip("unshare is not there")
    for options in (["-pf", "--mount-proc"], ["-Urpf", "--mount-proc"]):
        command = ["unshare", *options, "--kill-child"]
        if subprocess.run([*command, "true"], capture_output=True, check=False).returncode == 0:
            return [*command, *words]
    pytest.skip("unshare -pf --mount-proc is not allowed")


def test_a_killed_container_whose_numbers_run_again_blocks_nobody(tmp_path, owner):
    """In both containers the process has the number 1."""
    before = namespace()
    killed = owner(*before)
    with sqlite3.connect(tmp_path / "sweep.sqlite") as db:
        (text,) = db.execute("SELECT process FROM leases").fetchone()
    db.close()
    assert json.loads(text)["pid"] == 1
    killed.process.kill()
    killed.process.wait()
    code = (
        "import sys, time, os\nfrom viscache.sweeps import leases\n"
        "from viscache.sweeps.store import Store\n"
        "leases.BEAT_S, leases.SILENT_S = float(sys.argv[2]), float(sys.argv[3])\n"
        "store = Store(sys.argv[1])\nassert os.getpid() == 1\n"
        f"while not store.leases.claim({KEY!r}):\n    time.sleep(0.01)\n"
        "store.close()\n"
    )
    command = [*before, sys.executable, "-c", code, str(tmp_path), str(BEAT_S), str(SILENT_S)]
    subprocess.run(command, env=environment(), check=True, timeout=30)


@pytest.mark.parametrize("since", ["2100-01-01 00:00:00+00:00", "?"])
@pytest.mark.parametrize("alive", [True, False])
def test_clocks_of_other_machines_do_not_count(since, alive, tmp_path, owner):
    other = owner()
    if not alive:
        other.process.kill()
        other.process.wait()
    change(tmp_path, {"host": "elsewhere", "machine": "another"}, since=since)
    with Store(tmp_path) as store:
        if alive:
            assert_kept(store, 2)
        else:
            assert seconds_until_claimed(store) > 0.9 * SILENT_S


def test_a_living_owner_keeps_its_lease_however_slow_it_is(tmp_path, owner):
    slow = owner()
    with Store(tmp_path) as store:
        assert_kept(store, 3)
        assert slow.renders() == "stored\n"
        assert store.frame(KEY).image[0, 0, 0] == 7


@pytest.mark.parametrize("finished", [True, False])
def test_an_owner_that_wakes_after_its_lease_was_taken_overwrites_nothing(
    finished, tmp_path, owner
):
    asleep = owner()
    asleep.process.send_signal(signal.SIGSTOP)
    with Store(tmp_path) as store:
        assert seconds_until_claimed(store) > 0.9 * SILENT_S
        if finished:
            store.put(KEY, {"by": "me"}, frame(2.0))
            picture = (tmp_path / picture_name(KEY)).read_bytes()
        asleep.process.send_signal(signal.SIGCONT)
        assert asleep.renders().startswith("lost")
        if not finished:
            assert store.leases.holds(KEY) and store.get(KEY) is None
            store.put(KEY, {"by": "me"}, frame(2.0))
        else:
            assert (tmp_path / picture_name(KEY)).read_bytes() == picture
        record = store.get(KEY)
        assert record is not None and record.spec == {"by": "me"}
        assert store.frame(KEY).image[0, 0, 0] == 2
    names = [path.name for path in (tmp_path / "frames").iterdir()]
    assert names == [Path(picture_name(KEY)).name]  # nothing half written


def test_owners_that_stood_together_with_who_waits_keep_their_leases(tmp_path, owner):
    """As on a machine that slept: the first look after it counts for one beat at most."""
    asleep = owner()
    with Store(tmp_path) as store:
        assert not store.leases.claim(KEY)
        asleep.process.send_signal(signal.SIGSTOP)
        time.sleep(2 * SILENT_S)  # this process stands, too
        assert not store.leases.claim(KEY)
        asleep.process.send_signal(signal.SIGCONT)
        assert_kept(store, 2)


def test_who_waits_says_for_whom_and_since_when(tmp_path, owner, monkeypatch, caplog):
    monkeypatch.setattr(leases, "TOLD_S", 0.05)
    other = owner()
    change(tmp_path, {"host": "elsewhere\n"}, since="2026-01-02 03:04:05+00:00")
    with caplog.at_level(logging.WARNING, "viscache"), Store(tmp_path) as store:
        for _ in range(10):
            assert not store.leases.claim(KEY)
            store.leases.wait(0.02)
    (told,) = [record.getMessage() for record in caplog.records]
    for part in (
        f"process {other.process.pid} on 'elsewhere\\n'",
        "since 2026-01-02 03:04:05+00:00 of its clock",
        f"frame {KEY[:12]}",
        f"waiting since {time.strftime('%Y-', time.gmtime())}",
    ):
        assert part in told
    assert "\n" not in told


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("process", "[]"),
        ("process", "{"),
        ("process", '{"host": 1, "pid": 2, "started": 3, "machine": ""}'),
        ("process", '{"host": "", "pid": -1, "started": 3, "machine": null}'),
        ("process", b"\xff"),
        ("beats", "many"),
        ("owner", b"x"),
    ],
)
def test_a_lease_that_is_none_is_refused_by_name(column, value, tmp_path):
    with Store(tmp_path) as one, Store(tmp_path) as two:
        assert one.leases.claim(KEY)
        change(tmp_path, **{column: value})
        with pytest.raises(ValueError, match=r"sweep\.sqlite is not a sweep's store, or damaged"):
            two.leases.claim(KEY)


def test_beats_cost_less_than_a_hundredth(tmp_path):
    with Store(tmp_path) as store:
        assert all(store.leases.claim(f"{n:064x}") for n in range(64))
        began = time.thread_time()
        for _ in range(20):
            store.leases._count()
        assert (time.thread_time() - began) / 20 < 0.01 * 5.0


def test_a_sweep_renders_what_another_process_let_fall(fake_vc, tmp_path, monkeypatch):
    """A frame whose lease is lost while it is rendered is that of the process that has it."""
    from viscache.sweeps import work
    from viscache.sweeps.sweep import sweep

    given = {"over": {"c_e": [4, 8]}, "size": (32, 24), "metrics": ["rel_l1"]}
    stolen = []

    def overslept(*arguments, **options):
        made = fake_vc.fake_render(*arguments, **options)
        if not stolen:
            with Store(tmp_path) as thief, thief._door():
                stolen.extend(thief._db.execute("DELETE FROM leases RETURNING key").fetchall())
        return made

    monkeypatch.setattr(work, "render_function", overslept)
    ds = sweep("room", "whitted", directory=tmp_path, **given)
    assert stolen and len(fake_vc.CALLS) == 3 + 1
    np.testing.assert_allclose(ds.rel_l1[:, 0], [0.04, 0.08], rtol=1e-5)
    with pytest.raises(LostLeaseError), Store(tmp_path) as one, Store(tmp_path) as two:
        key = "f" * 64
        assert one.leases.claim(key)
        one._db.execute("DELETE FROM leases")
        assert two.leases.claim(key)
        one.put(key, {}, frame())
