"""Storage of the finished blocks of a measurement: a folder, or memory.

    FOLDER/<key of the rows>/points.npz, rows.npy, rows-0-2048.npz …
    FOLDER/<key of the rows>/pairs-<key of the pairs>/pairs-00000.npz …, near.npz

A key is the content hash of everything that determines the numbers. So an interrupted measurement
repeats nothing, and one with other bins reuses the rows. Blocks are written atomically. Two
processes with the same folder may compute a block twice; they write the same bytes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from viscache.files import whole_file

Arrays = dict[str, npt.NDArray[Any]]


class WorkStore(Protocol):
    """Rows of bits, and finished blocks by name."""

    @property
    def bits(self) -> npt.NDArray[np.uint64]:
        """(N, W) rows, readable and writable."""

    def put(self, name: str, arrays: Arrays) -> None:
        """Store a finished block."""

    def get(self, name: str) -> Arrays | None:
        """A finished block, or None."""


class MemoryStore:
    """Keeps everything until the measurement ends."""

    def __init__(self, bits: npt.NDArray[np.uint64]) -> None:
        self.bits = bits
        self._blocks: dict[str, Arrays] = {}

    def put(self, name: str, arrays: Arrays) -> None:
        self._blocks[name] = arrays

    def get(self, name: str) -> Arrays | None:
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
        The folder contains rows of another shape.
    """

    def __init__(self, folder: Path, shape: tuple[int, int]) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / "rows.npy"
        if not self.path.exists():
            _create_rows(self.path, shape)
        self.bits = np.load(self.path, mmap_mode="r+")
        if self.bits.shape != shape or self.bits.dtype != np.uint64:
            raise ValueError(
                f"{self.path} must hold uint64 rows of shape {shape},"
                f" got {self.bits.dtype} {self.bits.shape}"
            )

    def put(self, name: str, arrays: Arrays) -> None:
        self.bits.flush()
        write_arrays(self.folder / f"{name}.npz", arrays)

    def get(self, name: str) -> Arrays | None:
        path = self.folder / f"{name}.npz"
        if not path.is_file():
            return None
        with np.load(path) as file:
            return {key: file[key] for key in file.files}


def write_arrays(path: Path, arrays: Arrays) -> None:
    """Write an npz file atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def _create_rows(path: Path, shape: tuple[int, int]) -> None:
    """Create a sparse file of zeros atomically; it takes disk space only as rows are written."""
    with whole_file(path) as partial:
        np.lib.format.open_memmap(partial, mode="w+", dtype=np.uint64, shape=shape).flush()
