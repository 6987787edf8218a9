"""Settings of the quantized visibility cache.

`cpp/viscache/aqvc/parameters.h` defines ranges, defaults and meanings of the parameters. The
classes here read them from there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from numbers import Real
from typing import Any, Literal

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.not_given import NotGiven, not_given, plain
from viscache.settings.parameter_rows import ParameterRows
from viscache.settings.registry import registered
from viscache.settings.source_context import SourceContext
from viscache.settings.spelling import setting

#: In the order of the core (`visibility/counters.h`).
LIGHT_GROUPS = (
    "point",
    "directional",
    "area",
    "environment",
    "vpl",
    "ambient",
    "connection",
    "camera",
)

ROWS = ParameterRows(_core.aqvc.AqvcParameters)
#: Parameters on which keys, or what is kept under them, depend.
KEYED = tuple(name for name, row in ROWS.by_name.items() if row["keyed"])
#: Parameters that are mappings by light group.
BY_GROUP = ("c_e_groups", "refinement")

#: What the presets change of the defaults (docs/deviations.md tells why).
PRESETS: dict[str, dict[str, Any]] = {
    "default": {},
    # Fewer and larger clusters, more rays for large contributions (docs/aqvc.md)
    "fast": {"c_n": 2, "c_z": 1.0, "c_r": 2.0, "by_contribution": True, "level_step": 2.0},
    "paper": {
        "c_z": 8.0,
        "c_finest": "log2",
        "level_step": 2.0,
        "vpl_key": "surface",
        "refinement": "on",
        "exact_groups": (),
        "form": "pairs",
        "batch": 1,
    },
}
PRESETS["as_printed"] = PRESETS["paper"] | {
    "normal_mode": "floor",
    "grid_offset": False,
    "tangent_neighbours": False,
    "hash": "scheme1",
    "env_rule": "printed",
}


def _default(name: str) -> Any:
    """The C++ default, marked as not given."""
    return not_given(ROWS.default(name))


def _fill(settings: Any, preset: Mapping[str, Any]) -> None:
    """Where nothing was given: the preset's value, or the default."""
    for f in fields(settings):
        if f.name in ROWS.by_name and isinstance(getattr(settings, f.name), NotGiven):
            value = preset.get(f.name, plain(f.default))
            object.__setattr__(settings, f.name, not_given(value))


def _group_set(given: Any) -> Any:
    """Light groups in their order, or "auto"."""
    if isinstance(given, str) and given == "auto":
        return given
    names = isinstance(given, Collection) and not isinstance(given, str | Mapping)
    require(names, 'exact_groups must be "auto" or a set of light groups', given)
    for group in given:
        known = group in LIGHT_GROUPS
        require(known, f"exact_groups must name {', '.join(LIGHT_GROUPS)}", group)
    return tuple(group for group in LIGHT_GROUPS if group in given)


#: Defaults where rays correct the errors and rows are kept, so that misses cost more than errors.
CORRECTED_PASSES: dict[str, Any] = {"c_e": 16.0, "c_n": 2, "c_z": 1.0, "c_r": 2.0}


@setting
@ROWS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class PaperForm:
    """More parameters, for the paper's form of the cache: `Aqvc(paper=PaperForm(...))`.

    Given values override those of the preset.

    Parameters
    ----------
    {parameters}

    Examples
    --------
    >>> import viscache as vc
    >>> exact_table = vc.PaperForm(form="pairs", storage="exact")
    >>> vc.Aqvc(preset="paper", paper=exact_table).paper.vpl_key
    'surface'
    """

    form: Literal["waves", "pairs"] = _default("form")
    storage: Literal["table", "exact", "shared", "paper_tiles"] = _default("storage")
    batch: int = _default("batch")
    queue: int = _default("queue")
    scale_free: bool = _default("scale_free")
    grid_seed: int = _default("grid_seed")
    c_w: int = _default("c_w")
    order: Literal["hm", "scanline", "random"] = _default("order")
    c_pg: float = _default("c_pg")
    hash: Literal["scheme2", "scheme1", "scheme1_mixed"] = _default("hash")
    digest_bits: int = _default("digest_bits")
    normal_mode: Literal["round", "floor", "octahedral", "single"] = _default("normal_mode")
    grid_offset: bool = _default("grid_offset")
    tangent_neighbours: bool = _default("tangent_neighbours")
    env_rule: Literal["derived", "printed"] = _default("env_rule")
    cell_density: Literal["light", "mixture"] = _default("cell_density")
    vpl_key: Literal["point", "surface"] = _default("vpl_key")

    def __post_init__(self) -> None:
        check_types(self)
        ROWS.core(self)


@registered("visibility", "aqvc", parts=True)
@ROWS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Aqvc:
    """Adaptive quantization visibility caching (Popov, Georgiev, Slusallek, Dachsbacher 2013).

    Given values override those of the preset. The defaults shown are those of "default".

    Parameters
    ----------
    preset : {"default", "fast", "paper", "as_printed"}
        "fast": fewer and larger cells, and C_E by contribution. At the same C_E it has fewer rays
        and more error. It is better with many lights and in foliage, not with few lamps.
        "paper": the parameters of the paper with our corrections; queries go through the hash
        table one by one. "as_printed": without the corrections (docs/deviations.md).
    {parameters}
    paper : PaperForm
        Parameters of the paper's form.

    Examples
    --------
    >>> import viscache as vc
    >>> vc.Aqvc(c_e=8).c_z, vc.Aqvc(preset="paper").c_z, vc.Aqvc(preset="paper", c_z=2).c_z
    (4.0, 8.0, 2.0)
    """

    preset: Literal["default", "fast", "paper", "as_printed"] = "default"
    c_e: float = _default("c_e")
    c_e_groups: Mapping[str, float] = field(default_factory=dict, hash=False)
    c_l: float = _default("c_l")
    c_n: int = _default("c_n")
    c_z: float = _default("c_z")
    c_r: float = _default("c_r")
    refinement: Mapping[str, str] | Literal["auto", "on", "off"] = field(
        default=_default("refinement"), hash=False
    )
    exact_groups: Collection[str] | Literal["auto"] = _default("exact_groups")
    level_step: float = _default("level_step")
    c_finest: float | Literal["log2"] = _default("c_finest")
    by_contribution: bool = _default("by_contribution")
    bright: float = _default("bright")
    table_bytes: int = _default("table_bytes")
    paper: PaperForm = PaperForm()

    def __post_init__(self) -> None:
        check_types(self)
        table = isinstance(self.c_e_groups, Mapping)
        require(table, "c_e_groups must map light groups to numbers", self.c_e_groups)
        for group, value in self.c_e_groups.items():
            require(group in LIGHT_GROUPS, f"c_e_groups must name {', '.join(LIGHT_GROUPS)}", group)
            number = isinstance(value, Real) and not isinstance(value, bool)
            require(
                number and 0 < value < float("inf"),
                f"c_e_groups[{group!r}] must be > 0 and finite",
                value,
            )
        self._check_refinement()
        if not isinstance(self.exact_groups, NotGiven):
            object.__setattr__(self, "exact_groups", _group_set(self.exact_groups))
        require(isinstance(self.paper, PaperForm), "paper must be vc.PaperForm(...)", self.paper)
        _fill(self, PRESETS[self.preset])
        paper = replace(self.paper)
        _fill(paper, PRESETS[self.preset])
        object.__setattr__(self, "paper", paper)
        self.core()

    def _check_refinement(self) -> None:
        given, words = self.refinement, '"auto", "on" or "off"'
        if isinstance(given, str):
            return
        table = isinstance(given, Mapping)
        require(table, f"refinement must be {words}, or map light groups to these", given)
        for group, value in given.items():
            known = group in LIGHT_GROUPS
            require(known, f"refinement must name {', '.join(LIGHT_GROUPS)}", group)
            fits = value in ("auto", "on", "off")
            require(fits, f"refinement[{group!r}] must be {words}", value)

    def core(self) -> _core.aqvc.AqvcParameters:
        """The C++ struct with the preset and what was given."""
        core: _core.aqvc.AqvcParameters = ROWS.core(self, self.paper)
        return core

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles."""
        scene, caster, spp = context.scene, context.caster, context.spp
        if context.kept is not None:
            table, check, repair = context.kept
            return _core.KeptTableSource(
                scene, caster, self.core(), table, spp=spp, check=check, repair=repair
            )
        if context.bidirectional:
            return _core.FrameTableSource(scene, caster, self.core(), spp=spp)
        exact: _core.OracleSource | None = None
        if context.shafts is not None:
            packets = _core.ExactSource(scene, caster)
            exact = _core.ShaftSource(scene, caster, context.shafts, packets, choose=True)
        if context.rows is not None:
            return _core.AqvcRowsSource(
                scene, caster, self.core(), context.rows, spp=spp, exact=exact
            )
        return _core.AqvcSource(scene, caster, self.core(), spp=spp, exact=exact)

    def for_frame_table(self) -> Aqvc:
        """With the defaults for `Bdpt`: no refinement (Sec. 4.2), 256 MiB.

        In the default preset also C_R = 2 (docs/deviations.md, A35).
        """
        own: dict[str, Any] = {"table_bytes": 256 << 20, "refinement": "off"}
        if self.preset == "default":
            own["c_r"] = 2.0
        return self._unless_given(own, {})

    def for_kept_table(self) -> Aqvc:
        """With the defaults for a table that is kept: one query at a time, scale-free cells."""
        made = self._unless_given({}, {"form": "pairs", "storage": "table", "scale_free": True})
        form, storage = made.paper.form, made.paper.storage
        require(form == "pairs", 'form must be "pairs" with keep', form)
        require(storage == "table", 'storage must be "table" with keep', storage)
        return made

    def for_corrected_passes(self) -> Aqvc:
        """With the defaults for `vc.Progressive(use="correct")`: fewer and larger cells.

        In the default preset (docs/performance/progressive.md).
        """
        return self._unless_given(CORRECTED_PASSES, {}) if self.preset == "default" else self

    def _unless_given(self, own: Mapping[str, Any], paper: Mapping[str, Any]) -> Aqvc:
        """With these values, where nothing was given."""
        papers = {n: v for n, v in paper.items() if isinstance(getattr(self.paper, n), NotGiven)}
        values = {n: v for n, v in own.items() if isinstance(getattr(self, n), NotGiven)}
        return replace(self, **values, paper=replace(self.paper, **papers))

    def resolved(self) -> dict[str, Any]:
        """Every parameter's value, those of `paper` under their own names."""
        own = {f.name: plain(getattr(self, f.name)) for f in fields(self) if f.name != "paper"}
        own |= {n: dict(own[n]) for n in BY_GROUP if isinstance(own[n], Mapping)}
        return own | {f.name: plain(getattr(self.paper, f.name)) for f in fields(self.paper)}

    def parameters(self) -> dict[str, Any]:
        """Names and values as used: `resolved`."""
        return self.resolved()
