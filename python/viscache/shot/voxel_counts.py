"""Voxel-to-voxel visibility of Next Event Estimation++ that is kept from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.sharing import Turn, Uncopied
from viscache.scene import Scene
from viscache.settings.checks import require, require_kept
from viscache.settings.nee_plus_plus import NeePlusPlus
from viscache.settings.spelling import spelled

#: Settings that say which pairs of voxels the counts belong to.
CELLS = ("n_voxels", "n_directions", "symmetric")


@spelled
class VoxelCounts(Uncopied):
    """What frames of `vc.render(..., keep=counts)` with `NeePlusPlus` learn for later frames.

    The first frame learns from a small frame of `learn_pixels`. Each later one adds another of
    `relearn_pixels`, with new samples where `first_sample` or the seed is new. What a frame learns
    does not depend on its own random choices, so all frames are right in expectation. Counts depend
    on finished frames alone: not on the number of threads, nor on interrupted frames.

    Examples
    --------
    >>> import viscache as vc
    >>> room, counts = vc.scenes.build("room?triangles=3000"), vc.VoxelCounts()
    >>> lights, roulette = vc.Whitted(n_vpls=64), vc.NeePlusPlus()
    >>> frames = [
    ...     vc.render(
    ...         room, lights, visibility=roulette, size=(64, 40), keep=counts, first_sample=n
    ...     )
    ...     for n in range(2)
    ... ]
    >>> frames[1].counters["learning_rays"] < frames[0].counters["learning_rays"] / 4
    True
    >>> counts.frames
    2
    """

    def __init__(self) -> None:
        self._core = _core.KeptVoxels()
        self._cells: dict[str, Any] = {}
        self._geometry = ""
        self._busy = Turn("counts", waits=False)

    @property
    def frames(self) -> int:
        """Number of finished frames."""
        return self._core.frames

    @property
    def pairs(self) -> int:
        """Number of pairs of voxels, or of voxels and directions, with at least one ray."""
        return self._core.pairs_tested

    @property
    def bytes(self) -> int:
        """Bytes of the counts; pages without counts take no memory."""
        return self._core.bytes

    def clear(self) -> None:
        """Forget all counts."""
        with self._busy:
            self._core, self._geometry = _core.KeptVoxels(), ""

    def parameters(self) -> dict[str, Any]:
        """What frames record: the number of frames so far."""
        return {"frames": self.frames}

    def __repr__(self) -> str:
        return f"VoxelCounts({self.frames} frames, {self.pairs} pairs)"

    @contextmanager
    def _frame(self, scene: Scene, settings: NeePlusPlus) -> Iterator[_core.KeptVoxels]:
        """The C++ counts for one frame, whose voxels must be those of earlier frames."""
        with self._busy:
            cells = {name: getattr(settings, name) for name in CELLS}
            if not self._geometry:
                self._cells, self._geometry = cells, scene.geometry_hash
            require_kept(cells, self._cells, "counts'")
            require(
                scene.geometry_hash == self._geometry,
                "scene must have the geometry of the counts' frames before",
                scene,
            )
            finished = False
            try:
                yield self._core
                finished = True
            finally:
                if finished:
                    self._core.commit()
                else:
                    self._core.roll_back()
                    if not self.frames:
                        self._geometry = ""

    def _state(self) -> dict[str, npt.NDArray[Any]]:
        """Arrays of all pairs with counts."""
        with self._busy:
            place, tested, seen = self._core.state()
            return {"place": place, "tested": tested, "seen": seen, "frames": np.array(self.frames)}

    def _restore(
        self, scene: Scene, settings: NeePlusPlus, state: dict[str, npt.NDArray[Any]]
    ) -> None:
        """Counts that `_state` gave. Nothing changes if they do not fit."""
        core = _core.KeptVoxels()
        if len(state["place"]) or int(state["frames"]):
            core.restore(
                scene._core,
                settings.core(),
                int(state["frames"]),
                state["place"],
                state["tested"],
                state["seen"],
            )
        with self._busy:
            self._core, self._geometry = core, ""
