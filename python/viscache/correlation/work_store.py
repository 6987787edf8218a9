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
import os
import uuid
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from viscache.array_digests import arrays_digest
from viscache.files import DAMAGED_ARRAYS, inside, named, whole_file

Arrays = dict[str, npt.NDArray[Any]]

#: Name of the hash among the arrays of a block.
DIGEST = "sha256"


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
    """Keeps rows and blocks in files.

    Parameters
    ----------
    folder : path
        Created if missing.
    shape : (N, W)
        Shape of the rows; a file of another shape is refused.

    Raises
    ------
    ValueError
        The folder contains rows of another shape, or links in the place of files.
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
        try:
            self.bits = np.load(self.path, mmap_mode="r+")
        except DAMAGED_ARRAYS as error:
            raise ValueError(
                f"{self.path} cannot be read: {error}; delete it, and its blocks are computed again"
            ) from error
        if self.bits.shape != shape or self.bits.dtype != np.uint64:
            raise ValueError(
                f"{self.path} must hold uint64 rows of shape {shape},"
                f" got {self.bits.dtype} {self.bits.shape}"
            )

    def put(self, name: str, arrays: Arrays, rows: slice | None = None) -> None:
        self.bits.flush()
        digest = np.array(self._digest(name, arrays, rows))
        write_arrays(inside(self.folder, f"{name}.npz"), {**arrays, DIGEST: digest})

    def get(self, name: str, rows: slice | None = None) -> Arrays | None:
        path = inside(self.folder, f"{name}.npz")
        if not path.is_file():
            return None
        try:
            with path.open("rb") as opened, np.load(opened) as file:
                arrays = {key: file[key] for key in file.files}
            given = str(arrays.pop(DIGEST, None))
            reason = "its content does not fit its hash"
        except DAMAGED_ARRAYS as error:
            arrays, given = {}, ""
            reason = str(error)
        if given == self._digest(name, arrays, rows):
            return arrays
        self.mended.append(f"{path} is damaged ({reason}): computed again")
        return None

    def _digest(self, name: str, arrays: Arrays, rows: slice | None) -> str:
        of_rows = b"" if rows is None else np.ascontiguousarray(self.bits[rows]).tobytes()
        return arrays_digest(name.encode(), arrays, of_rows)


def write_arrays(path: Path, arrays: Arrays) -> None:
    """Write an npz file atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def _reserve(path: Path) -> None:
    """Take the room of a file on the disk, so that no write to mapped memory finds it full.

    Such a write would end the process (SIGBUS).

    Raises
    ------
    OSError
        There is not enough room.
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
