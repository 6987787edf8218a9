"""A table of the quantized cache that outlives frames."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core, sources
from viscache.scene import Scene
from viscache.settings.aqvc import KEYED, Aqvc
from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import spelled

__all__ = ["AqvcTable"]


#: One row of `AqvcTable.entries`.
ENTRY = np.dtype([("slot", "u4"), ("digest", "u4"), ("visible", "?"), ("current", "?")], align=True)


@spelled
class AqvcTable:
    """Bits of visibility that frames of `vc.render(..., keep=table)` hand on to the next ones.

    A frame reads what the frames before have left, and its tiles what they trace themselves; it
    writes at its end, tile by tile, so that pictures do not depend on threads. Camera, C_E, levels
    and lights may change from frame to frame: they are in the keys, or choose among them. The
    geometry must be the same, unless `moved` was called.

    Parameters
    ----------
    table_bytes : int in [4, 2^33]
        4 bytes per cluster. Ten times the clusters of the frames that are to be remembered lose
        few of them.
    check : float in [0, 1]
        Share of the reused bits, drawn by frame and query, whose ray is traced as well:
        `frame.counters` "checked_kept" of those from frames before and "wrong_kept" that the ray
        contradicts, "checked_fresh" and "wrong_fresh" of those from the frame itself. The picture
        stays as it is and these rays are not among "rays".
    repair : bool
        Checked rays answer their query, and what they contradict is written anew. Only bits from
        frames before are checked then, and their rays count.

    Examples
    --------
    >>> import viscache as vc
    >>> scene, table = vc.scenes.cube_on_plane(), vc.AqvcTable(table_bytes=1 << 20)
    >>> cache = vc.Aqvc(c_e=8)
    >>> first, second = (
    ...     vc.render(scene, vc.Direct(), visibility=cache, size=(32, 20), keep=table)
    ...     for _ in range(2)
    ... )
    >>> second.counters["rays"] < first.counters["rays"] // 2, table.frames
    (True, 2)
    """

    def __init__(
        self, *, table_bytes: int = 256 << 20, check: float = 0.0, repair: bool = False
    ) -> None:
        require(
            is_whole(table_bytes) and 4 <= table_bytes <= 1 << 33,
            "table_bytes must be a whole number in [4, 2^33]",
            table_bytes,
        )
        number = isinstance(check, int | float) and not isinstance(check, bool)
        require(number and 0 <= check <= 1, "check must be in [0, 1]", check)
        require(isinstance(repair, bool), "repair must be True or False", repair)
        self.table_bytes, self.check, self.repair = int(table_bytes), float(check), repair
        self._core: _core.KeptTable | None = None
        self._keyed_by: dict[str, Any] = {}
        self._geometry = ""
        self._busy = threading.Lock()

    @property
    def frames(self) -> int:
        """Frames that were finished with it."""
        return self._core.frames if self._core else 0

    @property
    def epoch(self) -> int:
        """How often everything was forgotten."""
        return self._core.epoch if self._core else 0

    @property
    def occupancy(self) -> float:
        """Share of the slots in use, those of forgotten epochs among them."""
        return self._core.occupied / self._core.slots if self._core else 0.0

    def entries(self) -> npt.NDArray[np.void]:
        """Copies of the occupied slots, in slot order.

        A slot holds a digest of a query's key and one bit of visibility, not the key itself.

        Returns
        -------
        (N,) structured array
            "slot" (uint32), "digest" (uint32), "visible" (bool), and "current" (bool): the slot was
            written in the current epoch. Slots of earlier epochs are never found again. They stay
            until they are overwritten.

        Raises
        ------
        ValueError
            A frame is using the table.

        Examples
        --------
        >>> import viscache as vc
        >>> scene, table = vc.scenes.cube_on_plane(), vc.AqvcTable(table_bytes=1 << 20)
        >>> frame = vc.render(
        ...     scene, vc.Direct(), visibility=vc.Aqvc(c_e=8), size=(32, 20), keep=table
        ... )
        >>> found = table.entries()
        >>> found.dtype.names
        ('slot', 'digest', 'visible', 'current')
        >>> len(found) == frame.counters["table_occupied"], bool(found["current"].all())
        (True, True)
        >>> table.forget()
        >>> bool(table.entries()["current"].any())
        False
        """
        if self._core is None:
            return np.zeros(0, ENTRY)
        require(self._busy.acquire(blocking=False), "the table must not be in use by a frame", self)
        try:
            return self._core.entries()
        finally:
            self._busy.release()

    def forget(self) -> None:
        """Start a new epoch: no bit from before is found again. Takes no time."""
        if self._core:
            self._core.next_epoch()

    def moved(self, scene: Scene | str | os.PathLike[str], *, forget: bool = True) -> None:
        """Go on with `scene`, whose geometry may differ from that of the frames before.

        Parameters
        ----------
        scene : Scene, path or str
            Of the next frames.
        forget : bool
            Start a new epoch. False keeps all bits: those that are wrong now (stale) stay until
            they are overwritten, or found by `repair`.
        """
        self._geometry = sources.opened(scene).geometry_hash
        if forget:
            self.forget()

    def parameters(self) -> dict[str, Any]:
        """What frames record of it: its settings, and what it had seen when they were finished."""
        return {
            "table_bytes": self.table_bytes,
            "check": self.check,
            "repair": self.repair,
            "frames": self.frames,
            "epoch": self.epoch,
        }

    def __repr__(self) -> str:
        return (
            f"AqvcTable({self.table_bytes >> 20} MiB, {self.frames} frames, epoch {self.epoch}, "
            f"{100 * self.occupancy:.1f} % in use)"
        )

    @contextmanager
    def _frame(self, scene: Scene, cache: Aqvc) -> Iterator[_core.KeptTable]:
        """The C++ table for one frame, which must fit those before."""
        require(
            self._busy.acquire(blocking=False), "keep must not be in use by another frame", self
        )
        try:
            core = cache.core()
            keyed = {name: getattr(core, name) for name in KEYED}
            if not core.scale_free:
                keyed["the scene's bounding sphere"] = _core.scene_sphere(scene._core)
            if self._core is None:
                self._core = _core.KeptTable(self.table_bytes, core)
                self._keyed_by = keyed
                self._geometry = self._geometry or scene.geometry_hash
            for name, value in keyed.items():
                require(
                    value == self._keyed_by[name],
                    f"{name} must be {self._keyed_by[name]} as in the table's frames before",
                    value,
                )
            require(
                scene.geometry_hash == self._geometry,
                "scene must have the geometry of the table's frames before, or be given to "
                "table.moved(scene)",
                scene,
            )
            yield self._core
        finally:
            self._busy.release()
