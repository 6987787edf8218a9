"""A table of the quantized cache that is kept from frame to frame."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.sharing import Turn, Uncopied
from viscache.scene import Scene
from viscache.scenes import sources
from viscache.settings.aqvc import KEYED, Aqvc
from viscache.settings.checks import is_whole, require, require_kept
from viscache.settings.spelling import spelled

#: One row of `AqvcTable.entries`.
ENTRY = np.dtype([("slot", "u4"), ("digest", "u4"), ("visible", "?"), ("current", "?")], align=True)


@spelled
class AqvcTable(Uncopied):
    """Visibility bits that frames of `vc.render(..., keep=table)` pass on to later frames.

    A frame reads the bits of earlier frames, and each tile reads its own new bits. New bits are
    written at the end of the frame, tile by tile, so the image does not depend on the number of
    threads. Camera, C_E, levels and lights may change from frame to frame, because keys depend on
    them. The geometry must stay the same unless `moved` is called.

    Parameters
    ----------
    table_bytes : int in [4, 2^33]
        4 bytes per cluster. A table with ten times as many slots as clusters loses few of them.
    check : float in [0, 1]
        Share of the reused bits that are checked with a ray; the draw depends on frame and query.
        `frame.counters` counts them: "checked_kept" and "wrong_kept" for bits of earlier frames,
        "checked_fresh" and "wrong_fresh" for bits of the frame itself. The image does not change,
        and "rays" does not include these rays.
    repair : bool
        Rays of the check answer their query, and wrong bits are corrected. Only bits of earlier
        frames are checked then, and "rays" includes their rays.

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
        self._busy = Turn("the table", waits=False)

    @property
    def frames(self) -> int:
        """Number of finished frames that used the table."""
        return self._core.frames if self._core else 0

    @property
    def epoch(self) -> int:
        """Number of calls that forgot all bits."""
        return self._core.epoch if self._core else 0

    @property
    def occupancy(self) -> float:
        """Share of occupied slots, including those of earlier epochs."""
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
        with self._busy:
            return self._core.entries()

    def forget(self) -> None:
        """Start a new epoch: no earlier bit is found again. Takes no time.

        Raises
        ------
        ValueError
            A frame is using the table.
        """
        with self._busy:
            self._next_epoch()

    def _next_epoch(self) -> None:
        if self._core:
            self._core.next_epoch()

    def moved(self, scene: Scene | str | os.PathLike[str], *, forget: bool = True) -> None:
        """Continue with `scene`, whose geometry may differ from that of earlier frames.

        Parameters
        ----------
        scene : Scene, path or str
            Scene of the next frames.
        forget : bool
            Start a new epoch. False keeps all bits. Stale ones, which are wrong now, stay until
            they are overwritten or `repair` finds them.

        Raises
        ------
        ValueError
            A frame is using the table.
        """
        geometry = sources.opened(scene).geometry_hash
        with self._busy:
            self._geometry = geometry
            if forget:
                self._next_epoch()

    def parameters(self) -> dict[str, Any]:
        """What frames record: the settings, and the number of frames so far."""
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
        """The C++ table for one frame, whose settings must match those of earlier frames."""
        with self._busy:
            core = cache.core()
            keyed = {name: getattr(core, name) for name in KEYED}
            if not core.scale_free:
                keyed["the scene's bounding sphere"] = _core.scene_sphere(scene._core)
            if self._core is None:
                self._core = _core.KeptTable(self.table_bytes, core)
                self._keyed_by = keyed
                self._geometry = self._geometry or scene.geometry_hash
            require_kept(keyed, self._keyed_by, "table's")
            require(
                scene.geometry_hash == self._geometry,
                "scene must have the geometry of the table's frames before, or be given to "
                "table.moved(scene)",
                scene,
            )
            yield self._core
