"""The frame for which a visibility setting makes oracles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from viscache import _core


@dataclass(frozen=True, kw_only=True)
class SourceContext:
    """One frame, as the source of its oracles sees it.

    The caster traces every ray. `spp` is 1 for arrays of points. `lasting_seed` is the same for all
    frames of other `first_sample`s, `seed` is this frame's. `bidirectional` frames join eye paths
    with light paths: threads share one table. `batch` traces directions that all eye points share;
    `shafts` has the scene's triangles for `Exact(engine=…)`. `kept` (with check and repair), `rows`
    and `voxels` are kept from frame to frame. `octaves` is what corrections learnt (`PassMemory`).
    """

    scene: _core.Scene
    caster: _core.RayCaster
    spp: int = 1
    seed: int = 0
    lasting_seed: int = 0
    bidirectional: bool = False
    batch: _core.vlf.AlignedBatch | None = None
    shafts: _core.ShaftScene | None = None
    kept: tuple[_core.KeptTable, float, bool] | None = None
    rows: _core.AqvcRows | None = None
    octaves: list[list[int]] | None = None
    voxels: _core.KeptVoxels | None = None


class MakesOracles(Protocol):
    """A visibility setting: it makes the oracles of a frame, and says what it is."""

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles."""

    def parameters(self) -> dict[str, Any]:
        """Names and values."""
