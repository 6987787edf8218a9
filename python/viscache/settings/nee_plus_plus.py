"""Settings of Next Event Estimation++: Russian roulette with voxel-to-voxel visibility."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from viscache import _core
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.registry import registered
from viscache.settings.source_context import SourceContext

NEE = ParameterRows(_core.NeePlusPlusSettings)


@registered("visibility", "nee_plus_plus", unbiased=True, weighted=True)
@NEE.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class NeePlusPlus(RowSettings):
    """Next Event Estimation++ (Guo, Eisemann, Eisemann 2020): Russian roulette of shadow rays.

    A small frame with exact rays measures how often points of one voxel see points of another. A
    connection whose voxels see each other with probability p is traced with probability
    q = max(min_probability, p^exponent). If it is visible, its weight is 1/q. Connections that are
    not traced count as occluded. The frame is right in expectation. It has noise where only some
    points of two voxels see each other.

    With `use="correct"`, the mean visibility μ of two voxels is a control variate instead:
    μ + (V - μ)/q for the connections that are traced, μ for the others. q follows c·√(μ(1 - μ)),
    where c is the unoccluded contribution, down to 1/32 (Kugelmann, *VisCache*). It reaches 1 where
    c is `certain` of what the group could bring to the eye point and μ is 1/2. Samples of single
    eye points, and groups of at most eight shared lights, are all traced. Connections of `Bdpt`
    have q = 2·√(μ(1 - μ)). A number as in `use=vc.Correct(share=…)` is the q of all connections;
    `vc.Correct(certain=…)` sets another `certain`. This too is right in expectation.

    Frames can pass on what they have learnt: `vc.render(..., keep=vc.VoxelCounts())`.

    `frame.counters`: "rays" includes "learning_rays"; "discarded" connections were not traced.
    Not with environment="product".

    Parameters
    ----------
    {parameters}

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> frame = vc.render(scene, vc.Direct(), visibility=vc.NeePlusPlus(), size=(64, 40))
    >>> frame.counters["queries"] - frame.counters["discarded"] < frame.counters["queries"]
    True
    """

    ROWS: ClassVar[ParameterRows] = NEE
    n_voxels: int = NEE.default("n_voxels")
    n_directions: int = NEE.default("n_directions")
    learn_pixels: int = NEE.default("learn_pixels")
    relearn_pixels: int = NEE.default("relearn_pixels")
    min_probability: float = NEE.default("min_probability")
    exponent: float = NEE.default("exponent")
    certain: float = NEE.default("certain")
    symmetric: bool = NEE.default("symmetric")
    max_bytes: int = NEE.default("max_bytes")

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles."""
        return _core.RouletteSource(
            context.scene, context.caster, self.core(), seed=context.seed, keep=context.voxels
        )

    def corrected(
        self, context: SourceContext, share: float | None, certain: float | None
    ) -> _core.OracleSource:
        """The source for `use="correct"`: means of voxels as a control variate."""
        return _core.RouletteSource.correct(
            context.scene,
            context.caster,
            self.core(),
            share=share,
            certain=self.certain if certain is None else certain,
            seed=context.seed,
            lasting_seed=context.lasting_seed,
            keep=context.voxels,
        )
