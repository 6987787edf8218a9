"""Combinations that do not work: `viscache.render` refuses them, docs/limits.md lists them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from viscache.settings.audit import AuditQueries
from viscache.settings.integrators import Bdpt, Direct, Whitted
from viscache.settings.rays import is_robust
from viscache.settings.registry import classes, listed, works
from viscache.settings.visibility import Aqvc, Exact, NeePlusPlus, ShadowMap, VisMaps

__all__ = ["RULES", "Request", "Rule", "check", "table"]


@dataclass(frozen=True, kw_only=True)
class Request:
    """The settings of a frame.

    `keep` says whether something is kept from frame to frame, the next two whether it is rows, or
    voxel counts of Next Event Estimation++. `batch` says whether shared directions may be traced by
    the aligned batch.
    """

    integrator: Any
    rays: Any
    visibility: Any
    use: Any = None
    keep: bool = False
    keeps_rows: bool = False
    keeps_voxels: bool = False
    first_sample: int = 0
    parts: int = 1
    audit: Any = None
    batch: bool = False

    @property
    def environment(self) -> str:
        """How the integrator samples the environment."""
        return str(getattr(self.integrator, "environment", ""))

    @property
    def shares_directions(self) -> bool:
        """Whether ambient occlusion uses directions that all eye points share."""
        return getattr(self.integrator, "directions", "") == "shared"

    @property
    def corrects(self) -> bool:
        """Whether the answers of the oracle serve as a control variate."""
        return self.use not in (None, "replace") and not isinstance(self.visibility, VisMaps)

    @property
    def is_unbiased(self) -> bool:
        """Whether frames have the expectation of exact ones, whatever the oracle answers."""
        if isinstance(self.visibility, VisMaps):
            return bool(self.use != "replace")  # a control variate
        return self.corrects or works(self.visibility).unbiased


@dataclass(frozen=True)
class Rule:
    """One row of the table: `what` does not work with `other`.

    If `refused` is true, the error consists of `must`, what must hold, and `given`.
    """

    what: str
    other: str
    instead: str
    must: str
    refused: Callable[[Request], bool]
    given: Callable[[Request], Any] = lambda r: r.visibility


_IN_TILES = (Direct, Whitted)

RULES: tuple[Rule, ...] = (
    Rule("`VisMaps`", "`Bdpt`, `AmbientOcclusion`", "`Direct`, `Whitted`",
         "integrator must be vc.Direct(...) or vc.Whitted(...) with visibility maps",
         lambda r: isinstance(r.visibility, VisMaps) and not isinstance(r.integrator, _IN_TILES),
         lambda r: r.integrator),
    Rule("`VisMaps`", '`environment="shared"`', '`environment="product"`',
         'environment must not be "shared" with visibility maps',
         lambda r: isinstance(r.visibility, VisMaps) and r.environment == "shared",
         lambda r: "shared"),
    Rule("`VisMaps`", "`n_environment=0`", "`n_environment=16`",
         "integrator must sample the environment's light, n_environment >= 1",
         lambda r: (isinstance(r.visibility, VisMaps)
                    and getattr(r.integrator, "n_environment", 1) < 1),
         lambda r: r.integrator.n_environment),
    Rule('`VisMaps(alpha="loo")`', "points that depend on each other",
         '`Direct(points="independent")`',
         'points must be "independent" with alpha="loo"',
         lambda r: (isinstance(r.visibility, VisMaps) and r.visibility.alpha == "loo"
                    and getattr(r.integrator, "points", "even") == "even"),
         lambda r: "even"),
    Rule("`ShadowMap`", "`Bdpt`, whose connections have no map", "`Aqvc`, `NeePlusPlus`",
         f"visibility must be {classes('visibility', bdpt=True)}, or an oracle of your own"
         " with Bdpt",
         lambda r: (isinstance(r.integrator, Bdpt) and not works(r.visibility).bdpt
                    and not isinstance(r.visibility, VisMaps))),
    Rule('`PaperForm(storage="shared")`', "`Direct`, `Whitted`, `AmbientOcclusion`",
         '`storage="table"`',
         'storage must be "table", "exact" or "paper_tiles" without Bdpt',
         lambda r: (isinstance(r.visibility, Aqvc) and r.visibility.paper.storage == "shared"
                    and not isinstance(r.integrator, Bdpt)),
         lambda r: r.visibility.paper.storage),
    Rule(f"other visibility than {listed('visibility', product=True)}; `use=\"correct\"`",
         '`environment="product"`', '`environment="mis"`',
         f"visibility must be {classes('visibility', product=True)} with"
         ' environment="product", without use="correct"',
         lambda r: (isinstance(r.integrator, Direct) and r.environment == "product"
                    and (not works(r.visibility).product or r.corrects))),
    Rule("`Direct(passes=…)`", 'other than `environment="product"`', "`spp=…`",
         'passes must be 1 without environment="product"',
         lambda r: (isinstance(r.integrator, Direct) and not isinstance(r.visibility, VisMaps)
                    and r.environment != "product" and r.integrator.passes != 1),
         lambda r: r.integrator.passes),
    Rule('`AmbientOcclusion(directions="shared")`', "any rays but Embree's robust packets",
         '`directions="own"`',
         "rays must be vc.Embree() with shared directions",
         lambda r: r.shares_directions and not is_robust(r.rays),
         lambda r: r.rays),
    Rule('`AmbientOcclusion(directions="shared")`', 'any cache, `use="correct"`',
         '`directions="own"`',
         "visibility must be vc.Exact(...) with shared directions",
         lambda r: r.shares_directions and (not isinstance(r.visibility, Exact) or r.corrects)),
    Rule("`Exact(sky_engine=…)`", "any rays but Embree's robust packets", '`sky_engine="embree"`',
         'rays must be vc.Embree() with sky_engine="batch" or "auto"',
         lambda r: (isinstance(r.visibility, Exact) and r.visibility.sky_engine != "embree"
                    and not is_robust(r.rays)),
         lambda r: r.rays),
    Rule("`Exact(sky_engine=…)`", "`Bdpt`, `AmbientOcclusion`", '`sky_engine="embree"`',
         "integrator must be vc.Direct(...) or vc.Whitted(...) with sky_engine",
         lambda r: (isinstance(r.visibility, Exact) and r.visibility.sky_engine != "embree"
                    and not isinstance(r.integrator, _IN_TILES)),
         lambda r: r.integrator),
    Rule('`Exact(engine="shafts")`', "any rays but Embree's robust packets", '`engine="auto"`',
         'rays must be vc.Embree() with engine="shafts"',
         lambda r: (isinstance(r.visibility, Exact) and r.visibility.engine == "shafts"
                    and not is_robust(r.rays)),
         lambda r: r.rays),
    Rule("`keep=AqvcTable(...)`, `AqvcRows(...)`", "any visibility but `Aqvc`", "`Aqvc`",
         "visibility must be vc.Aqvc(...) with keep",
         lambda r: r.keep and not r.keeps_voxels and not isinstance(r.visibility, Aqvc)),
    Rule("`keep=VoxelCounts()`", "any visibility but `NeePlusPlus`", "`NeePlusPlus`",
         "visibility must be vc.NeePlusPlus(...) with keep=vc.VoxelCounts()",
         lambda r: r.keeps_voxels and not isinstance(r.visibility, NeePlusPlus)),
    Rule("`keep=AqvcTable(...)`, `AqvcRows(...)`", "`Bdpt`, `AmbientOcclusion`",
         "`Direct`, `Whitted`",
         "integrator must be vc.Direct(...) or vc.Whitted(...) with keep",
         lambda r: r.keep and not r.keeps_voxels and not isinstance(r.integrator, _IN_TILES),
         lambda r: r.integrator),
    Rule("`keep=AqvcRows(...)`", '`PaperForm(form="pairs")`', "`keep=AqvcTable(...)`",
         'form must be "waves" with keep=vc.AqvcRows(...)',
         lambda r: (r.keeps_rows and isinstance(r.visibility, Aqvc)
                    and r.visibility.paper.form != "waves"),
         lambda r: r.visibility.paper.form),
    Rule("`first_sample=…`", "`Bdpt`", "`seed=…`",
         "first_sample must be 0 with Bdpt",
         lambda r: r.first_sample != 0 and isinstance(r.integrator, Bdpt),
         lambda r: r.first_sample),
    Rule("frames in parts", "`keep=…`", "one machine",
         "keep must be left out for parts of a frame",
         lambda r: r.parts > 1 and r.keep,
         lambda r: "rows" if r.keeps_rows else "counts" if r.keeps_voxels else "a table"),
    Rule("frames in parts", f"other visibility than {listed('visibility', parts=True)}",
         "one machine",
         f"visibility must be {classes('visibility', parts=True)} for parts of a frame",
         lambda r: r.parts > 1 and not works(r.visibility).parts),
    Rule("frames in parts", "`Bdpt`, shared directions of ambient occlusion", "one machine",
         "integrator must not be Bdpt nor share directions for parts of a frame",
         lambda r: r.parts > 1 and (isinstance(r.integrator, Bdpt) or r.shares_directions),
         lambda r: r.integrator),
    Rule("frames in parts", '`PaperForm(storage="paper_tiles")`', '`storage="table"`',
         'storage must be "table" or "exact" for parts of a frame',
         lambda r: (r.parts > 1 and isinstance(r.visibility, Aqvc)
                    and r.visibility.paper.storage == "paper_tiles")),
    Rule("frames in parts", "shared directions with another `sky_engine`",
         '`sky_engine="embree"`',
         'visibility must be vc.Exact(sky_engine="embree") for parts of a frame with shared'
         " directions",
         lambda r: r.parts > 1 and r.batch),
    Rule("`audit=…`", listed("visibility", audit=False), "`Aqvc`, ...",
         "visibility must be an approximation other than visibility maps with audit",
         lambda r: r.audit is not None and not works(r.visibility).audit),
    Rule("`audit=…`", '`use="correct"`, whose counters tell the share of wrong answers',
         '`use="replace"`',
         'use must be "replace" with audit',
         lambda r: r.audit is not None and r.corrects,
         lambda r: r.use),
    Rule("`audit=…`", "`Bdpt`", "`Direct`, `Whitted`, `AmbientOcclusion`",
         "integrator must not be Bdpt with audit",
         lambda r: r.audit is not None and isinstance(r.integrator, Bdpt),
         lambda r: r.integrator),
    Rule("`audit=…`", '`environment="product"`', '`environment="mis"`',
         'environment must not be "product" with audit',
         lambda r: (r.audit is not None and r.environment == "product"
                    and isinstance(r.visibility, ShadowMap)),
         lambda r: r.environment),
    Rule("`audit=AuditQueries(...)`", "`NeePlusPlus`, whose answers have weights",
         "`AuditPixels`",
         "audit must be vc.AuditPixels(...) with vc.NeePlusPlus(...)",
         lambda r: isinstance(r.audit, AuditQueries) and works(r.visibility).weighted,
         lambda r: r.audit),
)  # fmt: skip


def check(request: Request) -> None:
    """Refuse combinations that do not work; ValueError says what must hold, and what was given."""
    for rule in RULES:
        if rule.refused(request):
            raise ValueError(f"{rule.must}, got {rule.given(request)!r}")


def table() -> str:
    """The rules as a table in Markdown, for docs/limits.md."""
    rows = [f"| {rule.what} | {rule.other} | {rule.instead} |" for rule in RULES]
    return "\n".join(["| this | does not work with | use instead |", "| --- | --- | --- |", *rows])
