"""Bit rows of the quantized cache that are kept from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from viscache import _core
from viscache.base.sharing import Turn, Uncopied
from viscache.scene import Scene
from viscache.settings.aqvc import KEYED, LIGHT_GROUPS, Aqvc
from viscache.settings.checks import is_whole, require, require_kept
from viscache.settings.spelling import spelled


@spelled
class AqvcRows(Uncopied):
    """Visibility that frames of `vc.render(..., keep=rows)` pass on to later frames.

    For frames with the same shared lights and other eye samples, as `vc.Progressive` renders them:
    the level waves of the cache start from what earlier frames traced, cell by cell. A frame starts
    from the rows of finished frames alone, and tiles do not read each other's rows. So the bytes do
    not depend on the number of threads, nor on interrupted frames. Other lights, parameters of the
    levels or another tile grid start anew by themselves.

    Parameters
    ----------
    max_bytes : int in [2^20, 2^44]
        Room for all rows between frames. Tiles keep all of their rows or none, those of earlier
        frames and smaller ones first. The others are answered as without rows and counted
        ("tiles_not_kept").

    Examples
    --------
    >>> import viscache as vc
    >>> room, rows = vc.scenes.build("room?triangles=3000"), vc.AqvcRows()
    >>> lights = vc.Whitted(n_vpls=64)
    >>> first, second = (
    ...     vc.render(room, lights, visibility=vc.Aqvc(), size=(64, 40), keep=rows, first_sample=n)
    ...     for n in range(2)
    ... )
    >>> second.counters["rays"] < first.counters["rays"] / 2, rows.frames
    (True, 2)
    """

    def __init__(self, *, max_bytes: int = 1 << 30) -> None:
        require(
            is_whole(max_bytes) and 1 << 20 <= max_bytes <= 1 << 44,
            "max_bytes must be a whole number in [2^20, 2^44]",
            max_bytes,
        )
        self.max_bytes = int(max_bytes)
        self._core = _core.AqvcRows(self.max_bytes)
        self._keyed_by: dict[str, Any] = {}
        self._geometry = ""
        self._busy = Turn("rows", waits=False)

    @property
    def frames(self) -> int:
        """Number of finished frames."""
        return self._core.frames

    @property
    def cells(self) -> int:
        """Number of cells with rows."""
        return self._core.cells

    @property
    def bytes(self) -> int:
        """Approximate memory in use."""
        return self._core.bytes

    def clear(self) -> None:
        """Forget all rows."""
        with self._busy:
            self._core.clear()
            self._geometry = ""

    def parameters(self) -> dict[str, Any]:
        """What frames record: the settings, and the number of frames so far."""
        return {"max_bytes": self.max_bytes, "frames": self.frames}

    def __repr__(self) -> str:
        return f"AqvcRows({self.frames} frames, {self.cells} cells, {self.bytes >> 20} MiB)"

    @contextmanager
    def _frame(self, scene: Scene, cache: Aqvc) -> Iterator[_core.AqvcRows]:
        """The C++ rows for one frame, whose cells must mean the same as those of earlier frames."""
        with self._busy:
            core = cache.core()
            keyed = {name: getattr(core, name) for name in KEYED}
            if not self._geometry:
                self._keyed_by, self._geometry = keyed, scene.geometry_hash
            require_kept(keyed, self._keyed_by, "rows'")
            require(
                scene.geometry_hash == self._geometry,
                "scene must have the geometry of the rows' frames before",
                scene,
            )
            yield self._core
            self._core.commit()

    def _state(self) -> list[tuple[int, int, tuple[Any, ...]]]:
        """(tile, group, arrays) of all rows of finished frames."""
        with self._busy:
            return [
                (tile, group, state)
                for tile in range(self._core.tiles)
                for group in range(len(LIGHT_GROUPS))
                if len((state := self._core.state(tile, group))[2])
            ]

    def _restore(
        self, tiles: int, frames: int, rows: list[tuple[int, int, tuple[Any, ...]]]
    ) -> None:
        """Rows that `_state` gave; the next frame says which scene they belong to."""
        core = _core.AqvcRows(self.max_bytes)
        core.begin_restore(tiles, frames)
        for tile, group, state in rows:
            core.restore(tile, group, *state)
        with self._busy:
            self._core, self._geometry = core, ""
