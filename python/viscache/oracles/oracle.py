"""A visibility cache as a module: arrays of points in, bits out."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.oracles.correct import check_use
from viscache.oracles.points import EyePoints, FarEnds, tiles_of, unpack
from viscache.oracles.sources import oracle_source, parameters_of, shafts_for
from viscache.oracles.written import bits_of, is_written
from viscache.settings import by_name
from viscache.settings.checks import checked_floats, checked_threads, is_whole, require
from viscache.settings.chosen_rays import check_rays
from viscache.settings.rays import is_robust
from viscache.settings.source_context import SourceContext
from viscache.settings.visibility import Aqvc, Exact, VisMaps

#: Points of a tile, as many as the renderer's tiles have eye samples (render/tiles.h): for far ends
#: in general, and for so many directions that the aligned batch can pay.
TILE_POINTS, TILE_POINTS_OF_DIRECTIONS, MANY_DIRECTIONS = 64 * 64, 128 * 128, 16


@dataclass(frozen=True, eq=False)
class BlockAnswer:
    """Visibility of shared far ends from eye points.

    Attributes
    ----------
    bits : (N, ⌈M/64⌉) uint64
        1 = visible; far end k is bit k % 64 of word k // 64. Bits that were not wanted are 0.
    weights : (N, M) float32 or None
        Weights of visible connections, for oracles that skip connections at random.
    counters, timings : dict
        Of this call: "queries", "rays", "ray_reduction", "groups", ...; as of a `Frame`.
    n_ends : int
        M.
    engine : dict
        What the engines did, as `Frame.parameters["engine"]`; with `Exact(engine=...)` queries of
        shafts and what they left to rays.
    """

    bits: npt.NDArray[np.uint64]
    n_ends: int
    weights: npt.NDArray[np.float32] | None = None
    counters: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)
    engine: dict[str, Any] = field(default_factory=dict)
    _log: npt.NDArray[Any] | None = field(default=None, repr=False)

    @property
    def visible(self) -> npt.NDArray[np.bool_]:
        """(N, M) bool, unpacked at each call."""
        return unpack(self.bits, self.n_ends)

    @property
    def clusters(self) -> npt.NDArray[Any]:
        """The cluster of every query, sorted by row and column.

        Fields: "row" and "column" of the query; "cluster", where queries with equal numbers share
        an answer; "representative", the row whose ray gave the answer; "level" of refinement, 0 is
        the coarsest; "traced", whether the query is its own representative.

        Raises
        ------
        ValueError
            The block was not asked with `clusters=True`.
        """
        if self._log is None:
            raise ValueError("clusters must be asked for: oracle.block(..., clusters=True)")
        return self._log

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.visible, dtype=dtype)


@dataclass(frozen=True, eq=False)
class PairAnswer:
    """Visibility of far ends that belong to one eye point each.

    Attributes
    ----------
    visible : (K,) bool
    weights : (K,) float32 or None
    counters, timings : dict
        As of `BlockAnswer`.
    """

    visible: npt.NDArray[np.bool_]
    weights: npt.NDArray[np.float32] | None = None
    counters: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)
    #: Of a frame's samples: the order in which they were asked, and is added up in.
    _order: tuple[Any, Any] | None = field(default=None, repr=False)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.visible, dtype=dtype)


class Oracle:
    """Answers "does x see y?" for arrays of points, as a visibility setting does; `scene.oracle`.

    Points may have any source, order and number. The oracle sorts them along a space-filling curve
    and works in tiles, so memory is bounded by the answer. Calls are independent of each other, as
    frames are: nothing is kept, and shadow maps or learned visibilities are made for every call.

    Attributes
    ----------
    scene : Scene
    visibility : Exact, Aqvc, ShadowMap, NeePlusPlus, or an oracle of your own
    """

    def __init__(
        self,
        scene: Any,
        visibility: Any,
        *,
        rays: Any = None,
        use: Any = None,
        seed: int = 0,
        spp: int = 1,
        threads: int | None = None,
    ) -> None:
        visibility = by_name.setting("visibility", visibility)
        own = is_written(visibility)
        known = own or (hasattr(visibility, "source") and not isinstance(visibility, VisMaps))
        require(
            known,
            "visibility must be vc.Exact(...), vc.Aqvc(...), vc.ShadowMap(...),"
            " vc.NeePlusPlus(...) or an object with a method block",
            visibility,
        )
        check_use(use)
        fits = is_whole(seed) and 0 <= seed < 1 << 64
        require(fits, "seed must be a whole number in [0, 2^64)", seed)
        fits = is_whole(spp) and 1 <= spp <= 1 << 20  # as of a frame
        require(fits, "spp must be a whole number in [1, 2^20]", spp)
        if isinstance(visibility, Aqvc):
            require(
                visibility.paper.storage not in ("shared", "paper_tiles"),
                'storage must be "table" or "exact" for arrays of points',
                visibility.paper.storage,
            )
        rays = check_rays(rays)
        if isinstance(visibility, Exact) and visibility.engine == "shafts":
            require(is_robust(rays), 'rays must be vc.Embree() with engine="shafts"', rays)
        self.scene, self.visibility = scene, visibility
        self._use = use
        self._threads = checked_threads(threads) or len(os.sched_getaffinity(0))
        self._context = SourceContext(
            scene=scene._core,
            caster=scene.caster(rays, threads=self._threads),
            seed=int(seed),
            spp=int(spp),
            shafts=shafts_for(scene, visibility, rays),
        )

    def block(
        self,
        eyes: EyePoints,
        lamps: FarEnds,
        wanted: Any = None,
        contributions: Any = None,
        *,
        clusters: bool | slice = False,
    ) -> BlockAnswer:
        """Visibility of every far end from every eye point.

        Parameters
        ----------
        eyes : EyePoints of N points
        lamps : FarEnds of M ends
        wanted : (N, M) bool or (N, ⌈M/64⌉) uint64, optional
            Which connections to answer; all by default.
        contributions : (N, M) float, optional
            Contribution of each connection before visibility, for `Aqvc(by_contribution=True)`.
        clusters : bool or slice
            Keep the cluster of each query (`BlockAnswer.clusters`), for all far ends or a slice of
            them: 32 bytes per query. For Exact and Aqvc.

        Returns
        -------
        BlockAnswer

        Raises
        ------
        ValueError
            Shapes that do not fit, values that are not finite.

        Examples
        --------
        >>> import numpy as np, viscache as vc
        >>> scene = vc.scenes.cube_on_plane()
        >>> oracle = scene.oracle(vc.Aqvc(c_e=8))
        >>> eyes = vc.EyePoints([(2, 0, 0), (0.0, 0, 2)], [(0, 1, 0), (0, 1, 0)])
        >>> lamps = vc.FarEnds.points([(2, 3, 0), (-2, 0.5, 0)])
        >>> oracle.block(eyes, lamps).visible.shape
        (2, 2)
        """
        eyes, lamps = self._checked(eyes, lamps)
        shape = (len(eyes), len(lamps))
        if contributions is not None:
            contributions = checked_floats(contributions, "contributions")
            good = bool(np.isfinite(contributions).all() and (contributions >= 0).all())
            require(good, "contributions must be finite and >= 0", "values that are not")
        kept = clusters if isinstance(clusters, slice) else slice(None if clusters else 0)
        begin, end, step = kept.indices(len(lamps))
        require(step == 1, "clusters must be a slice without a step", clusters)
        result = _core.ask_block(
            self._source(),
            tiles_of(eyes),
            lamps._arrays(),
            wanted=None if wanted is None else bits_of(wanted, shape, "wanted must be"),
            contributions=contributions,
            log=(begin, max(begin, end)),
            extent=self._extent,
            most=self._most(lamps),
            threads=self._threads,
        )
        return BlockAnswer(
            result["bits"],
            len(lamps),
            result.get("weights"),
            result["counters"],
            result["timings"],
            result.get("engine", {}),
            result.get("log"),
        )

    def pairs(self, eyes: EyePoints, index: Any, ends: FarEnds) -> PairAnswer:
        """Visibility of single connections: one eye point and one far end each.

        Parameters
        ----------
        eyes : EyePoints of N points
        index : (K,) int
            Connection k joins `eyes[index[k]]` with far end k.
        ends : FarEnds of K ends

        Returns
        -------
        PairAnswer

        Raises
        ------
        ValueError
            Shapes that do not fit, indices out of range.
        """
        eyes, ends = self._checked(eyes, ends)
        numbers = np.asarray(index)
        whole = numbers.ndim == 1 and np.issubdtype(numbers.dtype, np.integer)
        require(
            whole and len(numbers) == len(ends),
            f"index must be ({len(ends)},) integers",
            f"{numbers.dtype} of shape {numbers.shape}",
        )
        inside = bool(np.all((numbers >= 0) & (numbers < len(eyes))))
        require(inside, f"index must be in [0, {len(eyes)})", "values outside")
        result = _core.ask_pairs(
            self._source(),
            tiles_of(eyes),
            numbers.astype(np.uint32),
            ends._arrays(),
            extent=self._extent,
            most=self._most(ends),
            threads=self._threads,
        )
        return PairAnswer(
            result["visible"], result.get("weights"), result["counters"], result["timings"]
        )

    def __repr__(self) -> str:
        return f"Oracle({self.scene!r}, {self.visibility!r})"

    @property
    def _extent(self) -> float:
        return float(_core.scene_offset_extent(self.scene._core))

    def _source(self) -> _core.OracleSource:
        return oracle_source(self.visibility, self._use, self._context)

    def _checked(self, eyes: EyePoints, ends: FarEnds) -> tuple[EyePoints, FarEnds]:
        require(isinstance(eyes, EyePoints), "eyes must be vc.EyePoints(...)", eyes)
        require(isinstance(ends, FarEnds), "far ends must be vc.FarEnds...", ends)
        needs_density = isinstance(self.visibility, Aqvc) or is_written(self.visibility)
        return eyes.with_density() if needs_density and eyes._tiles is None else eyes, ends

    @staticmethod
    def _most(ends: FarEnds) -> int:
        directions = ends.kind == "directions" and len(ends) >= MANY_DIRECTIONS
        return TILE_POINTS_OF_DIRECTIONS if directions else TILE_POINTS

    def parameters(self) -> dict[str, Any]:
        """Names and values of the visibility setting."""
        return parameters_of(self.visibility)
