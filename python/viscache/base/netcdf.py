"""Writing NetCDF files that are complete or absent, whatever the disk does."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache.base.files import whole_file

if TYPE_CHECKING:
    import xarray


class TakesAll(io.RawIOBase):
    """A file that never refuses a write, because HDF5 ends the process some time after it did.

    From the first write on that the disk refuses, `error` is set and all content goes to memory.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("w+b", buffering=0)
        self._at = self._end = 0
        self._kept: list[tuple[int, bytes]] = []
        self.error: OSError | None = None

    def check(self) -> None:
        """Raise what the disk said: then no more should be written."""
        if self.error is not None:
            raise self.error

    def write(self, data: Any) -> int:
        """Bytes at the place of the file, which moves to their end."""
        rest, n, at = memoryview(data).cast("B"), memoryview(data).nbytes, self._at
        try:
            while rest and self.error is None:
                done = os.pwrite(self._file.fileno(), rest, at)
                rest, at = rest[done:], at + done
        except (OSError, ValueError) as error:  # ValueError: closed, as a second Ctrl-C came
            self.error = error if isinstance(error, OSError) else OSError(str(error))
        if rest:
            self._kept.append((at, bytes(rest)))
        self._at += n
        self._end = max(self._end, self._at)
        return n

    def readinto(self, buffer: Any) -> int:
        """What was written, from the disk and from memory."""
        into = memoryview(buffer).cast("B")
        n = min(len(into), max(0, self._end - self._at))
        found = os.pread(self._file.fileno(), n, self._at)
        into[:n] = found.ljust(n, b"\0")
        for start, piece in self._kept:
            first, last = max(start, self._at), min(start + len(piece), self._at + n)
            if first < last:
                into[first - self._at : last - self._at] = piece[first - start : last - start]
        self._at += n
        return n

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move the place of the file."""
        self._at = offset + (0, self._at, self._end)[whence]
        return self._at

    def truncate(self, size: int | None = None) -> int:
        """Set the length of the file."""
        self._end = self._at if size is None else size
        if self.error is None:
            try:
                os.ftruncate(self._file.fileno(), self._end)
            except OSError as error:
                self.error = error
        return self._end

    def tell(self) -> int:
        """The place of the file."""
        return self._at

    def readable(self) -> bool:
        """As asked by `io`."""
        return True

    def writable(self) -> bool:
        """As asked by `io`."""
        return True

    def seekable(self) -> bool:
        """As asked by `io`."""
        return True

    def close(self) -> None:
        """Close the file of the disk."""
        if not self.closed:
            self._file.close()
        super().close()


@contextmanager
def netcdf_file(
    target: Path, trailer: Callable[[bytes], bytes] | None = None
) -> Iterator[Callable[[Callable[[Any], object]], None]]:
    """Gives a function that runs a job on an `h5netcdf.File`, which replaces the target at the end.

    If the block, a job or the disk fails (OSError), the target does not change. The memory of a job
    that the disk fails is that of what it writes. All jobs run in a thread of their own, where no
    Ctrl-C comes between HDF5 and its file. `trailer` gives bytes after the content, which HDF5 does
    not read.
    """
    import h5netcdf  # type: ignore[import-untyped,unused-ignore]

    with whole_file(target) as partial, TakesAll(partial) as disk, ThreadPoolExecutor(1) as thread:
        file = thread.submit(h5netcdf.File, disk, "w").result()

        def run(job: Callable[[Any], object]) -> None:
            thread.submit(job, file).result()
            disk.check()

        try:
            yield run
        finally:
            thread.submit(file.close).result()
        disk.check()
        if trailer is not None:
            disk.seek(0)
            disk.write(trailer(disk.readall() or b""))
            disk.check()


def write_netcdf(
    dataset: xarray.Dataset, target: Path, trailer: Callable[[bytes], bytes] | None = None
) -> None:
    """Write a dataset: completely or not at all. Parameters and errors as `netcdf_file`."""
    from xarray.backends import H5NetCDFStore

    with netcdf_file(target, trailer) as run:
        run(lambda file: dataset.dump_to_store(H5NetCDFStore(file)))
