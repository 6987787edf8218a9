"""The store of a sweep: SQLite and image files. Several processes may use it at a time.

A directory has `sweep.sqlite` (write-ahead log), `frames/<key>.exr`, `table.csv`, `table.nc`,
`table.parquet` if pyarrow is installed, and `report.html` if a report was written. The key of a
frame is a hash of everything that determines its pixels. So an interrupted sweep repeats no frame,
and a changed sweep renders only the frames that changed.

A store may come from somebody else. So names of files follow from keys and are never read; links in
the place of its files are refused, and so is a database with more than tables.
"""

from __future__ import annotations

import hashlib
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

from viscache.array_digests import changed_layers, layer_digests
from viscache.files import inside, whole_file
from viscache.sweeps import leases

if TYPE_CHECKING:
    from viscache.frame import Frame

#: Files of SQLite by their ends, after the name of the database.
DATABASE_FILES = ("", "-wal", "-shm", "-journal")
#: Last bytes of a journal of SQLite that names another file; SQLite would delete that file.
JOURNAL_OF_SEVERAL = bytes.fromhex("d9d505f920a163d7")

_SCHEMA = """
CREATE TABLE IF NOT EXISTS sweep (
    id INTEGER PRIMARY KEY CHECK (id = 0), definition TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS frames (
    key TEXT PRIMARY KEY, spec TEXT NOT NULL, counters TEXT NOT NULL, timings TEXT NOT NULL,
    parameters TEXT NOT NULL, provenance TEXT NOT NULL, sha256 TEXT NOT NULL, file TEXT NOT NULL,
    finished REAL NOT NULL);
CREATE TABLE IF NOT EXISTS hashes (key TEXT PRIMARY KEY, layers TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS comparisons (
    key TEXT NOT NULL, reference TEXT NOT NULL, metric TEXT NOT NULL, value REAL,
    PRIMARY KEY (key, reference, metric));
"""


def content_key(spec: Mapping[str, Any]) -> str:
    """Hex digest of a JSON-able description, whatever the order of its names."""
    text = json.dumps(spec, sort_keys=True, separators=(",", ":"), allow_nan=True)
    return hashlib.sha256(text.encode()).hexdigest()


def picture_name(key: str) -> str:
    """Name of a frame's picture in the folder of a store.

    Raises
    ------
    ValueError
        The key is no hash.
    """
    if not isinstance(key, str) or re.fullmatch("[0-9a-f]{64}", key) is None:
        raise ValueError(f"the key of a frame must be 64 hexadecimal digits, got {key!r}")
    return f"frames/{key[:20]}.exr"


class DamagedPictureError(ValueError):
    """A picture of a store that cannot be read, or is not the one that was stored."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Record:
    """A finished frame without its pixels.

    `layers` has the hash of each layer; None in rows of older stores, which have that of the colour
    layer alone.
    """

    key: str
    spec: dict[str, Any]
    counters: dict[str, Any]
    timings: dict[str, float]
    parameters: dict[str, Any]
    provenance: dict[str, Any]
    sha256: str
    layers: dict[str, str] | None

    def changed(self, frame: Frame) -> list[str]:
        """Names of the layers in which a frame differs from the finished one."""
        wanted = {"color": self.sha256} if self.layers is None else self.layers
        names = frame.layers if self.layers is not None else ("color",)
        return changed_layers(layer_digests({n: frame.layers[n] for n in names}), wanted)


class Store:
    """Finished frames and their comparisons; every method is one atomic transaction.

    Parameters
    ----------
    directory : path, optional
        Created if it does not exist. None: everything is in memory and lost with the object.

    Raises
    ------
    ValueError
        The directory's store cannot be read; or it has links in the place of files, or more than
        tables.
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
                self._check_tables()
                self._db.execute("PRAGMA journal_mode=WAL")
                self._db.execute("PRAGMA synchronous=NORMAL")
                self._db.executescript(_SCHEMA + leases.TABLE)
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
                f"{self._where} is not a sweep's store, or damaged: {error}."
                " Delete it and run the sweep again; pictures are rendered anew"
            ) from error

    @contextmanager
    def _opened(self) -> Iterator[sqlite3.Connection]:
        with self._door():
            yield self._db

    def _check_tables(self) -> None:
        """Refuse what runs by itself in a database: views, triggers, virtual tables."""
        row = self._db.execute(
            "SELECT type, name FROM sqlite_master WHERE NOT (type = 'table' AND sql LIKE"
            " 'CREATE TABLE %' OR type = 'index' AND sql IS NULL)"
        ).fetchone()
        if row is not None:
            raise ValueError(
                f"{self._where} is not a sweep's store: it must have tables only,"
                f" got the {row[0]} {row[1]!r}"
            )

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

    def define(self, definition: Mapping[str, Any]) -> None:
        """Store the description of the sweep; the newest one counts."""
        with self._door():
            self._db.execute(
                "INSERT OR REPLACE INTO sweep VALUES (0, ?)", (json.dumps(definition),)
            )

    def definition(self) -> dict[str, Any]:
        """The newest description; ValueError if there is none."""
        with self._door():
            row = self._db.execute("SELECT definition FROM sweep").fetchone()
        if row is None:
            raise ValueError(f"{self.directory} holds no sweep")
        with self._door():
            return _object(row[0])

    def get(self, key: str) -> Record | None:
        """The finished frame of a key whose picture is there, else None."""
        columns = "spec, counters, timings, parameters, provenance, sha256"
        with self._door():
            row = self._db.execute(f"SELECT {columns} FROM frames WHERE key = ?", (key,)).fetchone()
        if row is None:
            return None
        path = self._picture(key)
        if path is not None and not path.is_file():
            return None
        with self._door():
            parts = [_object(text) for text in row[:5]]
            hashes = self._db.execute("SELECT layers FROM hashes WHERE key = ?", (key,)).fetchone()
            layers = None if hashes is None else _object(hashes[0])
        return Record(
            key=key,
            spec=parts[0],
            counters=parts[1],
            timings=parts[2],
            parameters=parts[3],
            provenance=parts[4],
            sha256=row[5],
            layers=layers,
        )

    def frame(self, key: str) -> Frame:
        """The frame of a key; its layers are compared with their hashes in the store.

        Raises
        ------
        KeyError
            The frame is not finished.
        DamagedPictureError
            Its picture cannot be read, or is another one.
        """
        from viscache.frame import Frame

        if key in self._memory:
            return self._memory[key]
        record = self.get(key)
        path = None if record is None else self._picture(key)
        if record is None or path is None:
            raise KeyError(key)
        advice = "delete it and run the sweep again"
        try:
            frame = Frame.load(path)
        except (ValueError, OSError) as error:
            raise DamagedPictureError(f"{error}; {advice}") from error
        if changed := record.changed(frame):
            where = ", ".join(changed)
            raise DamagedPictureError(
                f"{path} is not the picture that was stored (layers {where}); {advice}"
            )
        return frame

    def put(self, key: str, spec: Mapping[str, Any], frame: Frame) -> None:
        """Store a finished frame: first the complete file, then its row.

        Raises
        ------
        LostLeaseError
            This store had the frame's lease, which was taken over. Nothing changes.
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
        records = (spec, of.counters, of.timings, of.parameters, of.provenance)
        hashes = of.layers if isinstance(of, Record) else layer_digests(of.layers)
        # The name of the picture is for readers of the table; nothing here reads it
        texts = (json.dumps(record) for record in records)
        row = (key, *texts, of.sha256, picture_name(key), time.time())
        columns = "key, spec, counters, timings, parameters, provenance, sha256, file, finished"
        with self._door(), self._db:
            self._db.execute("BEGIN IMMEDIATE")
            self.leases.check(self._db, key)
            yield
            marks = ",".join("?" * len(row))
            self._db.execute(f"INSERT OR REPLACE INTO frames ({columns}) VALUES ({marks})", row)
            self._db.execute("DELETE FROM hashes WHERE key = ?", (key,))
            if hashes is not None:
                self._db.execute("INSERT INTO hashes VALUES (?, ?)", (key, json.dumps(hashes)))
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
        query = "SELECT metric, value FROM comparisons WHERE key = ? AND reference = ?"
        with self._door():
            found = self._db.execute(query, (key, reference)).fetchall()
            for metric, value in found:
                if not isinstance(metric, str) or not isinstance(value, float | None):
                    given = f"got {metric!r} = {value!r}"
                    raise sqlite3.DataError(f"a metric must have a name and a number, {given}")
            return dict(found)

    def put_comparison(self, key: str, reference: str, values: Mapping[str, float | None]) -> None:
        """Keep metrics of a frame against a reference."""
        rows = [(key, reference, metric, value) for metric, value in values.items()]
        with self._door(), self._db:
            self._db.execute("BEGIN IMMEDIATE")
            self._db.executemany("INSERT OR REPLACE INTO comparisons VALUES (?, ?, ?, ?)", rows)


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


def _object(text: str) -> dict[str, Any]:
    """A JSON object of a record."""
    value = json.loads(text)
    if not isinstance(value, dict):
        raise json.JSONDecodeError("not an object", str(text)[:20], 0)
    return value


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
