"""Settings of the quantized visibility cache."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from numbers import Real
from typing import Any, Literal

from viscache import _core
from viscache.settings.checks import check_types, require

__all__ = ["Aqvc"]

LIGHT_GROUPS = (
    "point", "directional", "area", "environment", "vpl", "ambient", "connection", "camera",
)  # fmt: skip

#: Parameters of `Aqvc` that are mappings by light group.
BY_GROUP = ("c_e_groups", "refinement_groups")

#: What the presets change of the C++ defaults (docs/deviations.md tells why).
PRESETS: dict[str, dict[str, Any]] = {
    "default": {},
    # Fewer and larger clusters, rays where they count (docs/aqvc.md)
    "fast": {
        "c_n": 2,
        "c_z": 1.0,
        "c_r": 2.0,
        "by_contribution": True,
        "level_step": 2.0,
    },
    "paper": {
        "c_z": 8.0,
        "level_rule": "log2",
        "level_step": 2.0,
        "vpl_key": "surface",
        "refinement": "on",
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


@dataclass(frozen=True, kw_only=True, slots=True)
class Aqvc:
    """Adaptive quantization visibility caching (Popov, Georgiev, Slusallek, Dachsbacher 2013).

    Every parameter but `preset` and `c_e` may be None: the preset's value. What is given wins.

    Parameters
    ----------
    preset : {"default", "fast", "paper", "as_printed"}
        "fast": fewer, larger cells and C_E by contribution: at one C_E fewer rays and more error.
        It pays with many lights and in foliage, not with few lamps.
        "paper": the paper's parameters with our corrections, one query at a time through the hash
        table. "as_printed": with its slips too (docs/deviations.md).
    c_e : float > 0
        C_E: a cluster spans about C_E × C_E eye samples. The error knob.
    c_e_groups : mapping of light group to float > 0
        C_E of single groups: point, directional, area, environment, vpl, ambient; of `Bdpt` also
        connection (two surfaces) and camera.
    c_l : float in [0.001, 1000]
        C_L: and about C_L × C_L light samples at the far end (Eq. 7 and 9), where that is a surface
        or the sky. 1, the paper's. Below 1: finer light cells, for an error of the sky or of area
        lights that C_E does not bring down. Not with res_rule "eq6", whose C_E is both ends'.
    c_n : int in [1, 64]
        C_N: normal bins per axis (Eq. 4). 8.
    c_z : float in [0.01, 1024]
        C_Z: cells are this much thinner along the normal. 4; the paper: 8.
    c_r : float in [1.001, 16]
        C_R: ratio of the ladder of resolutions (Eq. 8). 1.2; with `Bdpt` 2.
    normal_mode : {"round", "floor", "octahedral", "single"}
        Bins of normals: to the nearest on a cube's lattice, or down (the paper); about as many on
        the octahedral map; or one grid for all normals, which lets light through thin walls.
    grid_offset : bool
        Shift the grids by irrational amounts, so that no plane lies on a cell face.
    scale_free : bool
        Cells are C_R^k units of length wide and count from the origin, instead of dividing the
        scene's bounding sphere: they stay the same when the scene grows or moves.
    grid_seed : int >= 0
        Another shift per number, and another random order.
    tangent_neighbours : bool
        Neighbour cells follow the tangent plane instead of keeping v_z.
    jitter : bool
        Move every eye point along its tangent plane by up to half a cell before it is quantised,
        by `grid_seed`: the edges of cells become noise. A point stays where it is if no eye point
        of the tile lies in the cell it would come to. Not with res_rule "eq6".
    res_rule : {"eq7", "eq6"}
        Cells of surface–surface connections: Eq. 7; with `Bdpt` Eq. 6.
    env_rule : {"derived", "printed"}
        Eq. 9 with 4π on the right side, or as printed.
    cell_density : {"mixture", "light"}
        Density that the light cells of samples of each pixel's own follow: of all techniques
        together, which differs between pixels where the BRDF is sampled too, or of light sampling
        alone, so that all pixels have the same cells: fewer rays, more error.
    vpl_key : {"point", "surface"}
        One column per VPL, or VPLs quantised as surface points.
    refinement : {"auto", "on", "off"}
        Alg. 2. Auto: for point, directional and VPL groups unless C_E² <= spp; off with `Bdpt`.
    refinement_groups : mapping of light group to {"auto", "on", "off"}
        The same for single groups, named as in `c_e_groups`.
    nil_refine : float in [0, 1]
        Share of the cells that refine where two or more of their four neighbours are unknown; an
        unknown neighbour agrees otherwise. 0.
    level_rule : {"finest", "log2"}
        Levels C_E, C_E/level_step … down to c_finest, or max(1, ceil(log2 C_E)) of them.
    level_step, c_finest : float
        See level_rule. 4 and 4.
    max_levels : int >= 0
        Cuts the list of levels; 0 = no limit.
    by_contribution : bool
        C_E of each connection by what it would carry unoccluded: C_E·(mean f / f)^(1/p). Only where
        refinement is on and in the form "waves"; others ignore it.
    contribution_power : float in [0.1, 100]
        The exponent p, 2.5: brighter connections get cells as much finer as errors count more.
    contribution_lift : float in [1, 1024]
        The coarsest level is this many C_E. 2.
    contribution_slack : int in [0, 32]
        Levels a connection may be refined past the first that asked it. 1.
    hash : {"scheme2", "scheme1", "scheme1_mixed"}
        Hash of the table (Eq. 10). Scheme 1 collides on point lights; kept to show that.
    digest_bits : int in [1, 31]
        Bits of the digest beside the visibility bit.
    table_bytes : int
        Size of the table: of one tile, 4 MiB; with `Bdpt` of the frame, 256 MiB. Bit rows of
        samples of each pixel's own take up to 16 times that before the table steps in.
    order : {"hm", "scanline", "random"}
        Processing order of `pairs` and rows: Halton–Morton (Sec. 4.3) or comparisons.
    c_pg : float
        C_PG: growth of the order's segments. 3.7.
    form : {"waves", "rows", "pairs"}
        How groups of shared lights run: level waves, rows in pixel order, one query at a time.
        Samples of each pixel's own go through rows of bits by light cell, or with "pairs" through
        the table.
    storage : {"table", "exact", "shared", "paper_tiles"}
        The lossy table of Sec. 4.1, or a map of full keys. With `Bdpt` all threads share one, which
        takes up what was traced between rounds of work: the same values for any number of threads.
        "shared", with `Bdpt` alone: threads read and write it at once; which of a cluster's
        segments is traced is chance. "paper_tiles", without `Bdpt`: tiles of 32² pixels dealt out
        to the threads, each of which keeps its table over all of its own, as the paper does on the
        CPU; the same bytes for the same number of threads alone.
    batch : int >= 0
        Eye points that are processed together; 0 = the form's own, 1 = one query at a time.
    queue : int in [0, 1024], even
        Of the table, instead of batches: length of the queue of postponed rays (Sec. 4.4). Half as
        many queries look up their values at a time, a warp; when more than half of it is taken, its
        first half is traced. 0 = no queue; the paper: 64.
    c_w : int in [1, 1024]
        C_W: where at least so many rays of a warp are missing, they are traced at once. 31.

    Examples
    --------
    >>> import viscache as vc
    >>> vc.Aqvc(c_e=8).resolved()["c_z"], vc.Aqvc(preset="paper").resolved()["c_z"]
    (4.0, 8.0)
    """

    preset: Literal["default", "fast", "paper", "as_printed"] = "default"
    c_e: float = 12.0
    c_e_groups: Mapping[str, float] = field(default_factory=dict, hash=False)
    c_l: float | None = None
    c_n: int | None = None
    c_z: float | None = None
    c_r: float | None = None
    normal_mode: Literal["round", "floor", "octahedral", "single"] | None = None
    grid_offset: bool | None = None
    scale_free: bool | None = None
    grid_seed: int | None = None
    tangent_neighbours: bool | None = None
    jitter: bool | None = None
    res_rule: Literal["eq7", "eq6"] | None = None
    env_rule: Literal["derived", "printed"] | None = None
    cell_density: Literal["mixture", "light"] | None = None
    vpl_key: Literal["point", "surface"] | None = None
    refinement: Literal["auto", "on", "off"] | None = None
    refinement_groups: Mapping[str, str] = field(default_factory=dict, hash=False)
    nil_refine: float | None = None
    level_rule: Literal["finest", "log2"] | None = None
    level_step: float | None = None
    c_finest: float | None = None
    max_levels: int | None = None
    by_contribution: bool | None = None
    contribution_power: float | None = None
    contribution_lift: float | None = None
    contribution_slack: int | None = None
    hash: Literal["scheme2", "scheme1", "scheme1_mixed"] | None = None
    digest_bits: int | None = None
    table_bytes: int | None = None
    order: Literal["hm", "scanline", "random"] | None = None
    c_pg: float | None = None
    form: Literal["waves", "rows", "pairs"] | None = None
    storage: Literal["table", "exact", "shared", "paper_tiles"] | None = None
    batch: int | None = None
    queue: int | None = None
    c_w: int | None = None

    def __post_init__(self) -> None:
        check_types(self)
        table = isinstance(self.c_e_groups, Mapping)
        require(table, "c_e_groups must map light groups to numbers", self.c_e_groups)
        for group, value in self.c_e_groups.items():
            require(group in LIGHT_GROUPS, f"c_e_groups must name {', '.join(LIGHT_GROUPS)}", group)
            number = isinstance(value, Real) and not isinstance(value, bool)
            require(
                number and 0 < value < float("inf"),
                f"c_e_groups[{group!r}] must be > 0 and finite", value,
            )  # fmt: skip
        self._check_refinement_groups()
        self.core()

    def _check_refinement_groups(self) -> None:
        given = self.refinement_groups
        table = isinstance(given, Mapping)
        require(table, 'refinement_groups must map light groups to "auto", "on" or "off"', given)
        for group, value in given.items():
            known = group in LIGHT_GROUPS
            require(known, f"refinement_groups must name {', '.join(LIGHT_GROUPS)}", group)
            require(value in ("auto", "on", "off"),
                    f'refinement_groups[{group!r}] must be "auto", "on" or "off"',
                    value)  # fmt: skip

    def core(self) -> _core.aqvc.AqvcParameters:
        """The C++ struct with the preset and what was given.

        Raises
        ------
        ValueError
            A value out of range.
        """
        values = dict(PRESETS[self.preset])
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name not in BY_GROUP and f.name != "preset" and value is not None:
                values[f.name] = value
        core = _core.aqvc.AqvcParameters()
        for name, value in values.items():
            try:
                setattr(core, name, value)
            except TypeError as error:
                raise ValueError(f"{name} must be a number in range, got {value!r}") from error
        core.c_e_group = [float(self.c_e_groups.get(g, 0.0)) for g in LIGHT_GROUPS]
        core.refinement_group = [self.refinement_groups.get(g) for g in LIGHT_GROUPS]
        core.validate()
        return core

    def for_frame_table(self) -> Aqvc:
        """With what `Bdpt` takes by default: Eq. 6, no refinement (Sec. 4.2), 256 MiB.

        In the default preset also C_R = 2 (docs/deviations.md, A35).
        """
        return replace(
            self,
            c_r=2.0 if self.c_r is None and self.preset == "default" else self.c_r,
            res_rule=self.res_rule or "eq6",
            refinement=self.refinement or "off",
            table_bytes=256 << 20 if self.table_bytes is None else self.table_bytes,
        )

    def for_kept_table(self) -> Aqvc:
        """With what a table kept over frames needs: one query at a time, scale-free cells."""
        form, storage = self.form or "pairs", self.storage or "table"
        require(form == "pairs", 'form must be "pairs" with keep', form)
        require(storage == "table", 'storage must be "table" with keep', storage)
        free = True if self.scale_free is None else self.scale_free
        return replace(self, form="pairs", storage="table", scale_free=free)

    def resolved(self) -> dict[str, Any]:
        """Every parameter's value, the preset's filled in."""
        core = self.core()
        given = {"preset": self.preset, **{name: dict(getattr(self, name)) for name in BY_GROUP}}
        return given | {f.name: getattr(core, f.name) for f in fields(self) if f.name not in given}

    def parameters(self) -> dict[str, Any]:
        """Names and values as used: `resolved`."""
        return self.resolved()
