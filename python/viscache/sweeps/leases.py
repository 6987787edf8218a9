"""Leases: which process renders which frame of a store, and what becomes of frames if it stops.

An owner counts up the beats of its leases every `BEAT_S`. Who wants one of them looks whether that
number changes. If it has stood still for `SILENT_S` of looking, the lease is taken over. So clocks
of two machines are never compared, and one that stood still or jumped means nothing. A process of
this machine that has ended is known by its number and its start, and loses its leases at once.

An owner that was stopped, as on a laptop that slept, may wake after its lease was taken over. The
name of an owner is never used twice, so it is the token that a result needs: `check` refuses it in
the transaction that stores it.
"""

from __future__ import annotations

import datetime
import json
import logging
import os
import socket
import sqlite3
import threading
import time
import uuid
import weakref
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

#: Seconds between two beats of an owner.
BEAT_S = 5.0
#: Seconds without a beat after which a lease is taken over.
SILENT_S = 30.0
#: Seconds of waiting after which `wait` says for whom.
TOLD_S = 5.0

TABLE = """
CREATE TABLE IF NOT EXISTS leases (
    key TEXT PRIMARY KEY, owner TEXT NOT NULL, process TEXT NOT NULL, since TEXT NOT NULL,
    beats INTEGER NOT NULL);
"""
#: Owners of this process.
_OPEN: weakref.WeakValueDictionary[str, Leases] = weakref.WeakValueDictionary()
_LOG = logging.getLogger("viscache")


class LostLeaseError(Exception):
    """A result came after its lease was taken over: it is not stored."""


@dataclass(slots=True)
class _Watched:
    """What was last seen of the lease of another owner."""

    owner: str
    beats: int
    at: float
    silent_s: float = 0.0


@dataclass(slots=True)
class _Waiting:
    """Since when this process waits, by its own clock, and for whom it has told."""

    at: float
    since: str
    told: str = ""


class Leases:
    """The leases of one store; `opened` gives the database, for one thread at a time."""

    def __init__(self, opened: Callable[[], AbstractContextManager[sqlite3.Connection]]) -> None:
        self.owner, self._opened = uuid.uuid4().hex, opened
        _OPEN[self.owner] = self
        self._held: set[str] = set()
        self._watched: dict[str, _Watched] = {}
        self._waiting: _Waiting | None = None
        self._blocked_by: tuple[str, str, str] | None = None
        self._stop = threading.Event()
        self._heart: threading.Thread | None = None

    def claim(self, key: str) -> bool:
        """Take a lease, or that of an owner that has ended or is silent; else False."""
        with self._opened() as db:
            # Most looks find a living owner: without a transaction they do not hold up its beats
            found = self._lease(db, key)
            if found is not None and not self._is_over(key, found):
                return False
            with db:
                db.execute("BEGIN IMMEDIATE")
                now = self._lease(db, key)
                if now is not None and now != found and now[0] != self.owner:
                    return False  # it beats again, or another process was faster
                row = (key, self.owner, json.dumps(_this_process()), _time_of_day(), 0)
                db.execute("INSERT OR REPLACE INTO leases VALUES (?, ?, ?, ?, ?)", row)
        self._held.add(key)
        self._watched.pop(key, None)
        self._waiting = None
        if self._heart is None:
            beat = (weakref.ref(self), self._stop, BEAT_S)
            self._heart = threading.Thread(target=_beat, args=beat, name="leases", daemon=True)
            self._heart.start()
        return True

    def release(self, key: str) -> None:
        """Give a lease back without a result."""
        self._held.discard(key)
        with self._opened() as db:
            db.execute("DELETE FROM leases WHERE key = ? AND owner = ?", (key, self.owner))

    def holds(self, key: str) -> bool:
        """Whether a lease is still this owner's."""
        with self._opened() as db:
            found = self._lease(db, key)
        return found is not None and found[0] == self.owner

    def check(self, db: sqlite3.Connection, key: str) -> None:
        """In the transaction that stores a result: end its lease.

        LostLeaseError if this owner had the lease, and another one has or had it since.
        """
        if key in self._held:
            self._held.discard(key)
            found = self._lease(db, key)
            if found is None or found[0] != self.owner:
                raise LostLeaseError(f"the lease of {key} was taken over while this process stood")
        db.execute("DELETE FROM leases WHERE key = ?", (key,))

    def close(self) -> None:
        """Give all leases back. Where the disk refuses that, they are over for this process."""
        self._stop.set()
        _OPEN.pop(self.owner, None)
        self._held.clear()
        with self._opened() as db:
            db.execute("DELETE FROM leases WHERE owner = ?", (self.owner,))

    def wait(self, seconds: float) -> None:
        """Sleep after a claim that failed; a warning says for whom this process waits."""
        now = time.monotonic()
        if self._waiting is None:
            self._waiting = _Waiting(now, _time_of_day())
        if self._blocked_by is not None and now - self._waiting.at >= TOLD_S:
            key, owner, who = self._blocked_by
            if self._waiting.told != owner:
                self._waiting.told = owner
                what = key if key.startswith("turn") else f"frame {key[:12]}"
                _LOG.warning("waiting since %s for the %s, at %s", self._waiting.since, what, who)
        time.sleep(seconds)

    def _lease(self, db: sqlite3.Connection, key: str) -> tuple[str, str, str, int] | None:
        """(owner, process, since, beats) of a key."""
        query = "SELECT owner, process, since, beats FROM leases WHERE key = ?"
        found = db.execute(query, (key,)).fetchone()
        if found is None:
            return None
        kinds = (str, str, str, int)
        if not all(isinstance(value, kind) for value, kind in zip(found, kinds, strict=True)):
            raise sqlite3.DataError(f"a lease must have three texts and a number, got {found!r}")
        return (found[0], found[1], found[2], found[3])

    def _is_over(self, key: str, lease: tuple[str, str, str, int]) -> bool:
        """Whether a lease may be taken: it is this owner's, its owner has ended, or is silent."""
        owner, text, since, beats = lease
        if owner == self.owner:
            return True
        process = _process(text)
        now, seen = time.monotonic(), self._watched.get(key)
        if seen is None or (seen.owner, seen.beats) != (owner, beats):
            seen = self._watched[key] = _Watched(owner, beats, now)
        # A look counts for one beat at most: if all processes stood, their owners beat first
        seen.silent_s += min(now - seen.at, BEAT_S)
        seen.at = now
        self._blocked_by = (key, owner, f"{_words(process)} since {since} of its clock")
        closed = process == _this_process() and owner not in _OPEN
        return seen.silent_s >= SILENT_S or closed or _has_ended(process)

    def _count(self) -> None:
        """One beat of all leases; one that the disk refuses is left out."""
        if not self._held:
            return
        with suppress(ValueError, OSError), self._opened() as db:
            db.execute("UPDATE leases SET beats = beats + 1 WHERE owner = ?", (self.owner,))


def _beat(of: weakref.ref[Leases], stop: threading.Event, every_s: float) -> None:
    """Beat until the store is closed or forgotten."""
    while not stop.wait(every_s):
        leases = of()
        if leases is None:
            return
        leases._count()
        del leases


def _time_of_day() -> str:
    """Of this machine's clock, for people to read."""
    return datetime.datetime.now(datetime.timezone.utc).isoformat(" ", "seconds")


def _this_process() -> dict[str, Any]:
    return _about(os.getpid())


@cache
def _about(pid: int) -> dict[str, Any]:
    """A process of this machine, as leases name it; a forked child has another number."""
    return {
        "host": socket.gethostname(),
        "pid": pid,
        "started": _start_of(pid),
        "machine": _machine(),
    }


def _process(text: str) -> dict[str, Any]:
    """The process of a lease; another program may have written it."""
    found = json.loads(text)
    kinds = {"host": str, "pid": int, "started": int | None, "machine": str | None}
    if (
        not isinstance(found, dict)
        or not all(name in found and isinstance(found[name], kind) for name, kind in kinds.items())
        or found["pid"] < 1
    ):
        raise sqlite3.DataError(f"a lease must name a process, got {text[:60]!r}")
    return found


def _words(process: dict[str, Any]) -> str:
    return f"process {process['pid']} on {process['host']!r}"


def _has_ended(process: dict[str, Any]) -> bool:
    """Whether a process of this machine has ended, also where its number runs again."""
    if process["machine"] is None or process["machine"] != _machine():
        return False
    try:
        os.kill(process["pid"], 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return _start_of(process["pid"]) not in (None, process["started"])


@cache
def _machine() -> str | None:
    """Run of this machine and space of process numbers; None where the system does not tell."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()
        return f"{boot} {Path('/proc/self/ns/pid').readlink()}"
    except (OSError, UnicodeDecodeError):
        return None


def _start_of(pid: int) -> int | None:
    """When a process started, in ticks since the machine did; -1 if it only waits to be buried.

    None where the system does not tell.
    """
    try:
        # The name of the program, in brackets, may hold anything
        fields = Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()
        return -1 if fields[0] in (b"Z", b"X") else int(fields[19])
    except (OSError, IndexError, ValueError):
        return None
