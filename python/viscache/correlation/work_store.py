"""Storage of the finished blocks of a measurement: a folder, or memory.

    FOLDER/<key of the rows>/points.npz, rows.npy, rows-0-2048.npz …
    FOLDER/<key of the rows>/pairs-<key of the pairs>/pairs-00000.npz …, near.npz

A key is the content hash of everything that determines the numbers. So an interrupted measurement
repeats nothing, and one with other bins reuses the rows. Blocks are written atomically. Two
processes with the same folder may compute a block twice; they write the same bytes. Each block has
the SHA-256 of its content, and a block of rows that of its rows too. A block that does not fit its
hash is computed again, and a line of `FolderStore.mended` says so.
"""

from __future__ import annotations

import errno
import hashlib
import os
import uuid
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from viscache.base.files import DAMAGED_ARRAYS, inside, named
from viscache.base.formats import TEXT, ArrayField, Field, Format, FormatError, is_digest
from viscache.correlation.pair_table import SUMS

Arrays = dict[str, npt.NDArray[Any]]

#: A block has its name, so that it is not taken for another one, and the hash of its rows.
_OF_BLOCK = {
    "name": TEXT,
    "rows": Field("a SHA-256 or null", lambda value: value is None or is_digest(value)),
}
_NUMBER = {"i8": ArrayField("i8", ()), "f8": ArrayField("f8", ())}
ROWS = Format(
    kind="a block of rows of a correlation",
    version=1,
    fields=_OF_BLOCK,
    arrays={"n_rays": _NUMBER["i8"], "batch_rays": _NUMBER["i8"], "seconds": _NUMBER["f8"]},
)
PAIRS = Format(
    kind="a block of pairs of a correlation",
    version=1,
    fields=_OF_BLOCK,
    arrays={
        "pair": ArrayField("i8", ("pairs", 2)),
        **dict.fromkeys(SUMS, ArrayField("i8", ("pairs", "D", "A"))),
        "evaluated": _NUMBER["i8"],
        "seconds": _NUMBER["f8"],
    },
)


class WorkStore(Protocol):
    """Rows of bits, and finished blocks by name."""

    @property
    def bits(self) -> npt.NDArray[np.uint64]:
        """(N, W) rows, readable and writable."""

    #: A line for each damaged block that was found.
    mended: list[str]

    def put(self, name: str, arrays: Arrays, rows: slice | None = None) -> None:
        """Store a finished block, and the hash of some rows with it."""

    def get(self, name: str, rows: slice | None = None) -> Arrays | None:
        """A finished block that fits its hash and that of its rows, or None."""


class MemoryStore:
    """Keeps everything until the measurement ends."""

    def __init__(self, bits: npt.NDArray[np.uint64]) -> None:
        self.bits = bits
        self.mended: list[str] = []
        self._blocks: dict[str, Arrays] = {}

    def put(self, name: str, arrays: Arrays, rows: slice | None = None) -> None:
        self._blocks[name] = arrays

    def get(self, name: str, rows: slice | None = None) -> Arrays | None:
        return self._blocks.get(name)


class FolderStore:
    """Keeps rows of the shape (N, W) and blocks in files of a folder, which is created if missing.

    ValueError if it has rows of another shape, or links in the place of files.
    """

    def __init__(self, folder: Path, shape: tuple[int, int]) -> None:
        self.folder = folder
        self.mended: list[str] = []
        inside(folder.parent, folder.name)
        folder.mkdir(parents=True, exist_ok=True)
        self.path = inside(folder, "rows.npy")
        if not self.path.exists():
            _create_rows(self.path, shape)
        _reserve(self.path)  # also of files that took room only as rows were written
        self.bits = self._mapped = mapped_rows(self.path, "r+")
        if self.bits.shape != shape:
            raise FormatError(
                f"{self.path} must hold rows of shape {shape}, got {self.bits.shape};"
                " delete it, and its blocks are computed again"
            )

    def put(self, name: str, arrays: Arrays, rows: slice | None = None) -> None:
        self._mapped.flush()
        path = inside(self.folder, f"{name}.npz")
        path.parent.mkdir(parents=True, exist_ok=True)
        form = PAIRS if rows is None else ROWS
        form.write_npz(path, {"name": name, "rows": self._rows_digest(rows)}, arrays)

    def get(self, name: str, rows: slice | None = None) -> Arrays | None:
        path = inside(self.folder, f"{name}.npz")
        if not path.is_file():
            return None
        form = PAIRS if rows is None else ROWS
        try:
            fields, arrays = form.read_npz(path)
            if fields != {"name": name, "rows": self._rows_digest(rows)}:
                raise form.refusal(path, "it is of another name, or of other rows")
        except (FormatError, OSError) as error:
            self.mended.append(f"{' '.join(str(error).split())}: computed again")
            return None
        return arrays

    def _rows_digest(self, rows: slice | None) -> str | None:
        if rows is None:
            return None
        return hashlib.sha256(np.ascontiguousarray(self.bits[rows]).tobytes()).hexdigest()


def mapped_rows(path: Path, mode: Literal["r", "r+"]) -> np.memmap[Any, np.dtype[np.uint64]]:
    """The rows of a file, mapped to memory; FormatError if there are none."""
    try:
        bits = np.load(path, mmap_mode=mode)
        if not isinstance(bits, np.memmap) or bits.ndim != 2 or bits.dtype != np.uint64:
            given = f"{getattr(bits, 'dtype', None)} {getattr(bits, 'shape', None)}"
            raise ValueError(f"it must hold rows of uint64, got {given}")
    except DAMAGED_ARRAYS as error:
        raise FormatError(
            f"{path} cannot be read: {error}; delete it, and its blocks are computed again"
        ) from error
    return bits


def _reserve(path: Path) -> None:
    """Take the room of a file on the disk; OSError if there is not enough.

    Without it, a write to mapped memory that finds the disk full would end the process (SIGBUS).
    """
    if not hasattr(os, "posix_fallocate"):
        return
    with path.open("r+b") as file:
        try:
            if size := os.fstat(file.fileno()).st_size:
                os.posix_fallocate(file.fileno(), 0, size)
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL):  # disks that cannot tell
                raise named(error, path) from error


def _create_rows(path: Path, shape: tuple[int, int]) -> None:
    """Create a file of zeros atomically.

    A file that another process has made meanwhile stays, as that process writes its rows there.
    """
    partial = path.with_name(f".{path.name}.{uuid.uuid4().hex}.part")
    try:
        try:
            np.lib.format.open_memmap(partial, mode="w+", dtype=np.uint64, shape=shape).flush()
            _reserve(partial)
        except OSError as error:
            raise named(error, path) from error
        try:
            os.link(partial, path)
        except FileExistsError:
            pass
        except OSError:  # a disk without links
            partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
