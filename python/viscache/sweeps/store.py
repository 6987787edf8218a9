"""The store of a sweep: SQLite and image files. Several processes may use it at a time.

A directory has `sweep.sqlite` (write-ahead log), `frames/<key>.exr`, `table.csv`, `table.nc`,
and `report.html` if a report was written. The key of a
frame is a hash of everything that determines its pixels. So an interrupted sweep repeats no frame,
and a changed sweep renders only the frames that changed.

A store may come from somebody else. So names of files follow from keys and are never read; links in
the place of its files are refused, and so is a database with more than tables. Each row is the head
of a format, with its hash.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache.base.array_digests import changed_layers, layer_digests
from viscache.base.files import inside, whole_file
from viscache.base.formats import Format, FormatError
from viscache.sweeps import leases
from viscache.sweeps.records import COMPARISON, FRAME, SWEEP, VERSION

if TYPE_CHECKING:
    from viscache.frame import Frame

#: Files of SQLite by their ends, after the name of the database.
DATABASE_FILES = ("", "-wal", "-shm", "-journal")
#: Last bytes of a journal of SQLite that names another file; SQLite would delete that file.
JOURNAL_OF_SEVERAL = bytes.fromhex("d9d505f920a163d7")

#: Number in the head of the database that tells stores from others.
APPLICATION = 0x76697363
#: What to do about a store that cannot be used.
ADVICE = "delete it and run the sweep again"

#: The column `file` is for people who look for a picture; nothing here reads it.
_SCHEMA = f"""
CREATE TABLE IF NOT EXISTS sweep (id INTEGER PRIMARY KEY CHECK (id = 0), record TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS frames (
    key TEXT PRIMARY KEY, record TEXT NOT NULL, file TEXT NOT NULL, finished REAL NOT NULL);
CREATE TABLE IF NOT EXISTS comparisons (
    key TEXT NOT NULL, reference TEXT NOT NULL, record TEXT NOT NULL,
    PRIMARY KEY (key, reference));
{leases.TABLE}
PRAGMA application_id = {APPLICATION};
PRAGMA user_version = {VERSION};
"""


def picture_name(key: str) -> str:
    """Name of a frame's picture in the folder of a store; ValueError if the key is no hash."""
    if not isinstance(key, str) or re.fullmatch("[0-9a-f]{64}", key) is None:
        raise ValueError(f"the key of a frame must be 64 hexadecimal digits, got {key!r}")
    return f"frames/{key[:20]}.exr"


@dataclass(frozen=True, kw_only=True, slots=True)
class Record:
    """A finished frame without its pixels; `layers` has the hash of each layer."""

    key: str
    spec: dict[str, Any]
    counters: dict[str, Any]
    timings: dict[str, float]
    parameters: dict[str, Any]
    provenance: dict[str, Any]
    layers: dict[str, str]

    @property
    def sha256(self) -> str:
        """The hash of the colour."""
        return self.layers.get("color", "")

    def changed(self, frame: Frame) -> list[str]:
        """Names of the layers in which a frame differs from the finished one."""
        return changed_layers(layer_digests(frame.layers), self.layers)


class Store:
    """Finished frames and their comparisons; every method is one atomic transaction.

    The directory is created; without one, everything is in memory and lost with the object.
    ValueError if its store cannot be read, has links in the place of files, or more than tables.
    """

    def __init__(self, directory: str | os.PathLike[str] | None) -> None:
        self.directory = None if directory is None else Path(directory)
        self._memory: dict[str, Frame] = {}
        self._lock = threading.RLock()
        #: Which process renders which frame.
        self.leases = leases.Leases(self._opened)
        self._where = ":memory:" if directory is None else str(Path(directory) / "sweep.sqlite")
        if self.directory is not None:
            _check_files(self.directory)
            (self.directory / "frames").mkdir(parents=True, exist_ok=True)
        with self._door():
            self._db = sqlite3.connect(
                self._where, timeout=60.0, isolation_level=None, check_same_thread=False
            )
            try:
                self._db.execute("PRAGMA trusted_schema=OFF")
                made = self._check_tables()
                self._db.execute("PRAGMA journal_mode=WAL")
                self._db.execute("PRAGMA synchronous=NORMAL")
                if not made:
                    self._db.executescript(f"BEGIN IMMEDIATE; {_SCHEMA} COMMIT;")
            except BaseException:
                self._db.close()
                raise

    @contextmanager
    def _door(self) -> Iterator[None]:
        """One thread at a time; errors of SQLite and damaged records name the file."""
        try:
            with self._lock:
                yield
        except sqlite3.OperationalError as error:
            if (hint := _hint(str(error))) is None:
                raise ValueError(f"{self._where} is not a sweep's store: {error}") from error
            raise OSError(f"{self._where}: {error}; {hint}") from error
        except (sqlite3.Error, UnicodeDecodeError, json.JSONDecodeError) as error:
            raise ValueError(
                f"{self._where} is not a sweep's store, or damaged: {error};"
                f" {ADVICE}; pictures are rendered anew"
            ) from error

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        with self._door():
            yield self._db

    def _check_tables(self) -> bool:
        """Whether there are tables.

        Refused are databases of others and of before, and what runs by itself in one: views,
        triggers and virtual tables.
        """
        row = self._db.execute(
            "SELECT type, name FROM sqlite_master WHERE NOT (type = 'table' AND sql LIKE"
            " 'CREATE TABLE %' OR type = 'index' AND sql IS NULL)"
        ).fetchone()
        if row is not None:
            raise ValueError(
                f"{self._where} is not a sweep's store: it must have tables only,"
                f" got the {row[0]} {row[1]!r}"
            )
        if self._db.execute("SELECT count(*) FROM sqlite_master").fetchone() == (0,):
            return False
        (application,) = self._db.execute("PRAGMA application_id").fetchone()
        (version,) = self._db.execute("PRAGMA user_version").fetchone()
        if (application, version) != (APPLICATION, VERSION):
            given = version if application == APPLICATION else "a database without that version"
            raise FormatError(
                f"{self._where} must be a sweep's store of version {VERSION}, got {given};"
                " run the sweep in another folder"
            )
        return True

    def _picture(self, key: str) -> Path | None:
        """Where the picture of a frame is, or would be; None in memory."""
        name = picture_name(key)
        return None if self.directory is None else inside(self.directory, name)

    @staticmethod
    def exists(directory: str | os.PathLike[str]) -> bool:
        """Whether a sweep ran in this directory."""
        return (Path(directory) / "sweep.sqlite").is_file()

    def close(self) -> None:
        """Give back this store's leases and close it."""
        with self._door():
            self.leases.close()
            self._db.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _one(self, form: Format, query: str, *given: str) -> dict[str, Any] | None:
        """The fields of a row; None if there is none."""
        with self._door():
            row = self._db.execute(query, given).fetchone()
        if row is None:
            return None
        try:
            fields = form.opened(f"{self._where}: {' '.join(given)[:20] or 'a row'}", row[0])
            wanted = dict(zip(("key", "reference"), given, strict=False))
            for name, key in wanted.items():
                if fields[name] != key:
                    raise form.refusal(self._where, f"{name} must be {key}, got {fields[name]}")
        except FormatError as error:
            raise FormatError(f"{error}; {ADVICE}") from error
        return fields

    def define(self, definition: Mapping[str, Any]) -> None:
        """Store the description of the sweep; the newest one counts."""
        with self._door():
            self._db.execute(
                "INSERT OR REPLACE INTO sweep VALUES (0, ?)", (SWEEP.sealed(definition),)
            )

    def definition(self) -> dict[str, Any]:
        """The newest description; ValueError if there is none."""
        found = self._one(SWEEP, "SELECT record FROM sweep")
        if found is None:
            raise ValueError(f"{self.directory} holds no sweep")
        lengths = {dim: len(values) for dim, values in found["coords"].values()}
        shape = [lengths.get(dim, 0) for dim in found["dims"]]
        for point in found["points"]:
            inside_ = len(point["index"]) == len(shape) + 1 and all(
                i < n for i, n in zip(point["index"], [*shape, found["repeats"]], strict=True)
            )
            if not inside_:
                raise SWEEP.refusal(self._where, f"{point['index']} is no place in {shape}")
        return found

    def get(self, key: str) -> Record | None:
        """The finished frame of a key whose picture is there, else None."""
        found = self._one(FRAME, "SELECT record FROM frames WHERE key = ?", key)
        path = self._picture(key)
        if found is None or (path is not None and not path.is_file()):
            return None
        return Record(**found)

    def frame(self, key: str) -> Frame:
        """The frame of a key; KeyError if it is not finished.

        FormatError if its picture cannot be read, or its layers do not have the hashes in the
        store.
        """
        from viscache.frame import Frame

        if key in self._memory:
            return self._memory[key]
        record = self.get(key)
        path = None if record is None else self._picture(key)
        if record is None or path is None:
            raise KeyError(key)
        try:
            frame = Frame.load(path)
        except (ValueError, OSError) as error:
            raise FormatError(f"{error}; {ADVICE}") from error
        if changed := record.changed(frame):
            where = ", ".join(changed)
            raise FormatError(
                f"{path} is not the picture that was stored (layers {where}); {ADVICE}"
            )
        return frame

    def put(self, key: str, spec: Mapping[str, Any], frame: Frame) -> None:
        """Store a finished frame: first the complete file, then its row.

        LostLeaseError if this store had the frame's lease, which was taken over. Nothing changes
        then.
        """
        path = self._picture(key)
        if path is None:
            with self._storing(key, spec, frame):
                self._memory[key] = frame
        else:
            frame._save(path, within=self._storing(key, spec, frame))

    def replace_picture(self, key: str, frame: Frame) -> None:
        """Write the picture of a finished frame once more; its row and comparisons stay."""
        path = self._picture(key)
        if path is not None:
            frame.save(path)

    @contextmanager
    def _storing(self, key: str, spec: Mapping[str, Any], of: Frame | Record) -> Iterator[None]:
        """The transaction of a finished frame, in which its picture takes its place."""
        fields = {
            "key": key,
            "spec": spec,
            **{n: getattr(of, n) for n in ("counters", "timings", "parameters", "provenance")},
            "layers": of.layers if isinstance(of, Record) else layer_digests(of.layers),
        }
        row = (key, FRAME.sealed(fields), picture_name(key), time.time())
        with self._door(), self._db:
            self._db.execute("BEGIN IMMEDIATE")
            self.leases.check(self._db, key)
            yield
            self._db.execute("INSERT OR REPLACE INTO frames VALUES (?, ?, ?, ?)", row)
            self._db.execute("DELETE FROM comparisons WHERE key = ? OR reference = ?", (key, key))

    def finished(self) -> set[str]:
        """The keys of all frames whose pictures are there."""
        with self._door():
            keys = {key for (key,) in self._db.execute("SELECT key FROM frames")}
        if self.directory is None:
            return keys
        there = {f"frames/{entry.name}" for entry in os.scandir(self.directory / "frames")}
        return {key for key in keys if picture_name(key) in there}

    def adopt(self, key: str, other: Store) -> bool:
        """Take over a finished frame of another store; False where neither has it.

        The picture is linked, or copied where the two lie on different disks.
        """
        if self.get(key) is not None:
            return True
        record = other.get(key)
        if record is None:
            return False
        source, target = other._picture(key), self._picture(key)
        if source is None or target is None:
            self.put(key, record.spec, other.frame(key))
            return True
        with whole_file(target, self._storing(key, record.spec, record)) as partial:
            try:
                os.link(source, partial)
            except OSError:
                shutil.copyfile(source, partial)
        return True

    def forget_pixels(self, key: str) -> None:
        """Free the pixels of a frame that is only in memory; its record stays."""
        self._memory.pop(key, None)

    def compared(self, key: str, reference: str) -> dict[str, float | None]:
        """The metrics already known of a frame against a reference."""
        query = "SELECT record FROM comparisons WHERE key = ? AND reference = ?"
        found = self._one(COMPARISON, query, key, reference)
        return {} if found is None else found["values"]

    def put_comparison(self, key: str, reference: str, values: Mapping[str, float | None]) -> None:
        """Keep metrics of a frame against a reference."""
        with self._door(), self._db:
            self._db.execute("BEGIN IMMEDIATE")
            known = self.compared(key, reference) | dict(values)
            fields = {"key": key, "reference": reference, "values": known}
            row = (key, reference, COMPARISON.sealed(fields))
            self._db.execute("INSERT OR REPLACE INTO comparisons VALUES (?, ?, ?)", row)


def _check_files(directory: Path) -> None:
    """Refuse links in the place of a store's files, and a journal that names another file."""
    inside(directory, "frames")
    files = [inside(directory, f"sweep.sqlite{end}") for end in DATABASE_FILES]
    try:
        left = files[-1].read_bytes()
    except FileNotFoundError:
        return
    if left.endswith(JOURNAL_OF_SEVERAL):
        raise ValueError(
            f"{files[-1]} must be a journal of this store alone, got one that names another file;"
            " remove it"
        )


def _hint(error: str) -> str | None:
    """What to do about an error of SQLite that is not the file's fault."""
    known = {
        "full": "make room and run again: finished frames are kept",
        "readonly": "the folder must be writable",
        "unable to open": "the folder must be writable",
        "locked": "another program holds it; run again when that has ended",
        "disk I/O": "look after the disk and run again: finished frames are kept",
    }
    return next((hint for part, hint in known.items() if part in error), None)
