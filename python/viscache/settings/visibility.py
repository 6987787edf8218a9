"""Settings of the methods that answer "does x see y?"."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, ClassVar, Literal, TypeAlias

from viscache import _core
from viscache.settings.aqvc import Aqvc, PaperForm
from viscache.settings.checks import check_types
from viscache.settings.nee_plus_plus import NeePlusPlus
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.registry import registered
from viscache.settings.source_context import SourceContext
from viscache.settings.vismaps import VisMaps

#: The methods that `viscache` has; its own list and its stub take them from here.
__all__ = ["Aqvc", "Exact", "NeePlusPlus", "PaperForm", "ShadowMap", "Unoccluded", "VisMaps"]


@registered("visibility", "exact", exact=True, unbiased=True, product=True, parts=True, audit=False)
@dataclass(frozen=True, kw_only=True, slots=True)
class Exact:
    """Exact visibility: one ray per query.

    Parameters
    ----------
    order : {"auto", "by_light", "by_pixel"}
        Rays of a packet: from 16 neighbouring eye points to one light (nearly always the fastest),
        or from one eye point to 16 lights. "auto": by light, unless packets would have fewer than
        three rays on average, as where each eye point asks for a few lights of its own.
    coherent : bool, optional
        Embree's traversal flag. By default packets to one light are traced coherently where their
        16 eye points lie close together for the scene's triangles, and all others incoherently
        (docs/performance/exact.md). Nothing is timed: every run gives the same bytes. The flag
        changes about one answer in 10⁹ by rounding.
    sky_engine : {"embree", "batch", "auto"}
        The engine for directions that all eye points share: directional lights and, with
        environment="shared", the sky. "batch": for each direction, all triangles are tested against
        all points of a tile (VLF Sec. 7). "auto": the engine with the lower predicted cost, tile by
        tile. The prediction depends on tile, scene and instruction set, not on measured time;
        `Frame.parameters["engine"]` has the shares. The engines may differ for rays that meet an
        edge within rounding.
    engine : {"packets", "shafts", "auto"}
        The engine for points that all eye points share: point lights and virtual point lights.
        "packets": 16 rays at a time. "shafts": the hull of a light and many neighbouring eye points
        is tested against the scene, and rays answer only what its bounds of rounding leave open.
        Answers are those of packets with `coherent=False`, bit for bit. It pays where eye points
        lie more densely than triangles, as with many samples per pixel (docs/performance/exact.md
        has figures). "auto": shafts, but packets in frames with too few queries to pay for the tree
        of the scene, where points ask for few lights, and where a trial of eight lights leaves many
        packets to be traced. Scenes with instances, or too large for the tree (4 GiB), keep
        packets, and so do rays other than `Embree()`. `Frame.parameters["engine"]` counts what
        shafts did.
    """

    order: Literal["auto", "by_light", "by_pixel"] = "auto"
    coherent: bool | None = None
    sky_engine: Literal["embree", "batch", "auto"] = "embree"
    engine: Literal["packets", "shafts", "auto"] = "auto"

    def __post_init__(self) -> None:
        check_types(self)

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles."""
        exact = self._rays(context)
        if context.shafts is None:
            return exact
        return _core.ShaftSource(
            context.scene, context.caster, context.shafts, exact, choose=self.engine == "auto"
        )

    def _rays(self, context: SourceContext) -> _core.OracleSource:
        """The source of oracles that trace every query."""
        order = None if self.order == "auto" else _core.PacketOrder[self.order.upper()]
        if context.batch is None:
            return _core.ExactSource(
                context.scene, context.caster, order=order, coherent=self.coherent
            )
        return _core.AlignedSource(
            context.scene,
            context.caster,
            context.batch,
            choose=self.sky_engine == "auto",
            order=order,
            coherent=self.coherent,
        )

    def parameters(self) -> dict[str, Any]:
        """Names and values."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


MAPS = ParameterRows(_core.ShadowMapSettings)


@registered("visibility", "shadow_map", bdpt=False, product=True)
@MAPS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class ShadowMap(RowSettings):
    """Shadow maps: a plain depth test without a filter, the baseline of AQVC Fig. 8.

    Point lights have a cube of six maps, directional lights one map over the scene's bounding
    sphere. The ray caster `rays` traces them before the frame. Samples of area lights, environments
    and ambient light have no fixed position for a map. Exact rays answer these, and virtual point
    lights unless `vpls` is set; `frame.counters["bypassed"]` counts them.

    Parameters
    ----------
    {parameters}

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> maps = vc.ShadowMap(resolution=256)
    >>> frame = vc.render(scene, vc.Direct(), visibility=maps, size=(32, 20))
    >>> frame.counters["rays"] == frame.counters["shadow_map_rays"] == 6 * 256**2
    True
    """

    ROWS: ClassVar[ParameterRows] = MAPS
    resolution: int = MAPS.default("resolution")
    bias: float = MAPS.default("bias")
    slope_bias: float = MAPS.default("slope_bias")
    vpls: bool = MAPS.default("vpls")
    max_bytes: int = MAPS.default("max_bytes")

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles."""
        return _core.ShadowMapSource(context.scene, context.caster, self.core())


@registered("visibility", "unoccluded", parts=True)
@dataclass(frozen=True, kw_only=True, slots=True)
class Unoccluded:
    """No shadows: every query is answered "visible" without a ray.

    The baseline that every cache must beat. It shows how much light the shadows of a scene take
    away, and with `use="correct"` it is the plainest control variate: a random share of the
    shadow rays, each with a larger weight.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> frame = vc.render(scene, vc.Direct(), visibility=vc.Unoccluded(), size=(32, 20))
    >>> frame.counters["rays"], frame.counters["occluded"]
    (0, 0)
    """

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles."""
        return _core.UnoccludedSource()

    def parameters(self) -> dict[str, Any]:
        """Names and values: none."""
        return {}


Visibility: TypeAlias = Exact | Aqvc | ShadowMap | NeePlusPlus | Unoccluded | VisMaps
