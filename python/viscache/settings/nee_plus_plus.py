"""Settings of Next Event Estimation++: Russian roulette with voxel-to-voxel visibility."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.source_context import SourceContext
from viscache.settings.spelling import setting

__all__ = ["NeePlusPlus"]


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class NeePlusPlus:
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
    n_voxels : int in [1, 64]
        Voxels along an edge of the scene's bounding box.
    n_directions : int in [1, 256]
        Cells along an edge of the octahedral square: far ends of light from infinity.
    learn_pixels : int in [1, 2^30]
        The map is learnt from a frame of so many pixels, at most those of the frame itself, with
        one sample per pixel.
    relearn_pixels : int in [0, 2^30]
        The same of each later frame, if frames pass on what they have learnt.
    min_probability : float in [0.001, 1]
        Every connection is traced at least that often. 1: the exact frame. Not with
        `use="correct"`.
    exponent : float in [0, 4]
        1: in proportion to the visibility, as the paper does. 0: the exact frame. Not with
        `use="correct"`.
    certain : float > 0
        For `use="correct"`. Half as much draws up to twice as many rays.
    symmetric : bool
        V(a, b) and V(b, a) are learnt together.
    max_bytes : int >= 1
        Refuse a map that would take more: 8 bytes for each pair of voxels, and for each voxel with
        a cell of directions.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> frame = vc.render(scene, vc.Direct(), visibility=vc.NeePlusPlus(), size=(64, 40))
    >>> frame.counters["queries"] - frame.counters["discarded"] < frame.counters["queries"]
    True
    """

    n_voxels: int = 16
    n_directions: int = 16
    learn_pixels: int = 4096
    relearn_pixels: int = 256
    min_probability: float = 0.05
    exponent: float = 1.0
    certain: float = 1 / 256
    symmetric: bool = True
    max_bytes: int = 1 << 30

    def __post_init__(self) -> None:
        check_types(self)
        for name, most in (("n_voxels", 64), ("n_directions", 256), ("learn_pixels", 1 << 30)):
            value = getattr(self, name)
            require(1 <= value <= most, f"{name} must be in [1, {most}]", value)
        fits = 0 <= self.relearn_pixels <= 1 << 30
        require(fits, "relearn_pixels must be in [0, 1073741824]", self.relearn_pixels)
        require(1 <= self.max_bytes < 1 << 63, "max_bytes must be in [1, 2^63)", self.max_bytes)
        self.core().validate()

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

    def core(self) -> _core.NeePlusPlusSettings:
        """The C++ struct."""
        core = _core.NeePlusPlusSettings()
        for name, value in self.parameters().items():
            setattr(core, name, value)
        return core

    def parameters(self) -> dict[str, Any]:
        """Names and values."""
        return {f.name: getattr(self, f.name) for f in fields(self)}
