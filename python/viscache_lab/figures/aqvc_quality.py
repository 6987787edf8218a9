"""Comparison of the quantized cache's quality choices (Sec. 3.3, Sec. 3.6, and later ones)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.aqvc import eye_keys
from viscache.settings.by_name import replaced
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.figures.aqvc_runs import Shot, Trade
from viscache_lab.figures.aqvc_setups import SETUPS
from viscache_lab.figures.bands import aqvc as bands

Size = tuple[int, int] | None

C_E = 12.0
SIZE, QUICK_SIZE = (640, 400), (120, 75)
GRIDS, QUICK_GRIDS = 4, 1
#: Of the bias: C_E, the number of grids, the size, and forms: level waves; Alg. 2 with single
#: queries, in the paper's order and in an order random per grid.
BIAS_C_E = 16.0
BIAS_GRIDS, QUICK_BIAS_GRIDS = 32, 3
BIAS_SIZE, QUICK_BIAS_SIZE = (480, 320), (120, 80)
FORMS: dict[str, dict[str, Any]] = {
    "waves": {},
    "pairs": {"preset": "paper"},
    "pairs, random order": {"preset": "paper", "order": "random"},
}
VARIANTS = {"no refinement": "off", "refinement": "on"}
MEASURES = ("rays", "ray_reduction", "rel_l1", "bias", "stray")
MODES = ("round", "floor", "octahedral", "single")
#: Kinds of lights, by setup.
KINDS = {
    "delta": ("point", "directional"),
    "conference": ("area",),
    "apartment": ("vpl", "environment"),
}


@FIGURES.add(
    "aqvc-quality",
    "quality choices of the quantized cache: normals, grids, refinement, bias",
    sized=True,
)
def quality(trial: Trial) -> None:
    """All choices, and a table."""
    trial.rows += leaking_cells()
    rows, table = normals(trial.quick, trial.size)
    trial.rows += rows
    trial.rows += grids_and_neighbours(trial.quick, trial.size)
    trial.rows += light_kinds(trial.quick, trial.size)
    rows, biases = bias_rows(trial.quick, trial.size)
    trial.rows += rows
    trial.csv("aqvc-quality.csv", table)
    trial.csv("aqvc-quality-bias.csv", biases)
    trial.notes.append(
        "Choices are changed one at a time in the preset default; the apartment has 24 lamps and a "
        f"sun, C_E {C_E:g}. Errors are means over grids, a shift of the grids each."
    )


def leaking_cells() -> Iterator[Row]:
    """How many cells on the front of a wall, 1/1000 cell thick, also contain its back."""
    radius, cells = 7.5, 40.0
    rng = np.random.default_rng(1)
    front = rng.uniform(-2, 2, (2000, 3)).astype(np.float32)
    front[:, 1] = 0.0303
    up = np.tile(np.array([0, 1, 0], np.float32), (len(front), 1))
    behind = front - np.float32(1e-3 * 2 * radius / cells) * up
    for mode in MODES:
        settings = replaced(vc.Aqvc(), {"normal_mode": mode}, "visibility")
        sides = [
            eye_keys(settings, (0, 0, 0), radius, x, n, np.full(len(x), cells))[0]
            for x, n in ((front, up), (behind, -up))
        ]
        seen, hidden = ([key.tobytes() for key in side] for side in sides)
        shared = np.isin(seen, hidden).mean()
        yield Row(
            f"normals {mode}: cells of a thin wall's front that hold its back",
            float(shared),
            band=bands.LEAKING_CELLS[mode],
        )


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean, and half the width of its 95 % confidence interval."""

    mean: float
    half: float

    def __str__(self) -> str:
        return f"{100 * self.mean:+.3f} ± {100 * self.half:.3f} %"


def mean_interval(values: Sequence[float]) -> Interval:
    """By Student's t, for independent values."""
    from scipy.stats import t

    n = len(values)
    spread = float(np.std(values, ddof=1) / np.sqrt(n))
    return Interval(float(np.mean(values)), float(t.ppf(0.975, n - 1)) * spread)


def bias(frame: vc.Frame, exact: vc.Frame) -> float:
    """Relative error of the picture's energy, without emitted light."""
    cached, truth = (
        np.asarray(f.image, np.float64) - np.asarray(f.layers["emitted"], np.float64)
        for f in (frame, exact)
    )
    return float((cached - truth).sum() / truth.sum())


def stray_light(frame: vc.Frame, exact: vc.Frame) -> float:
    """Light on pixels that are black in the exact picture, over that picture's total light."""
    cached, truth = (np.asarray(f.image, np.float64).sum(axis=2) for f in (frame, exact))
    return float(cached[truth == 0].sum() / truth.sum())


def over_grids(shot: Shot, n: int, **given: Any) -> dict[str, npt.NDArray[np.float64]]:
    """Each of `MEASURES` for n shifts of the grids. The given settings replace the preset's."""
    exact = shot.frame()
    found = []
    for grid in range(1, 1 + n):
        chosen = {"c_e": C_E, "exact_groups": (), "grid_seed": grid, **given}
        frame = shot.frame(replaced(vc.Aqvc(), chosen, "visibility"))
        trade = Trade(frame=frame, exact=exact)
        light = bias(frame, exact), stray_light(frame, exact)
        found.append((frame.counters["rays"], trade.ray_reduction, trade.rel_l1, *light))
    return dict(zip(MEASURES, np.transpose(found), strict=True))


def mean_trade(shot: Shot, quick: bool, **given: Any) -> dict[str, float]:
    """The means of `over_grids`."""
    found = over_grids(shot, QUICK_GRIDS if quick else GRIDS, **given)
    return {name: float(values.mean()) for name, values in found.items()}


def _shot(quick: bool, size: Size) -> Shot:
    return replace(SETUPS["delta"].shot(quick, size), size=size or (QUICK_SIZE if quick else SIZE))


def normals(quick: bool, size: Size) -> tuple[list[Row], list[dict[str, Any]]]:
    """Bins of normals: rays and errors in the apartment, and stray light behind a thin wall."""
    apartment = _shot(quick, size)
    wall = Shot(scene=vc.scenes.thin_wall(), integrator=vc.Direct(), size=apartment.size)
    found = {m: mean_trade(apartment, quick, normal_mode=m) for m in MODES}
    stray = {m: mean_trade(wall, quick, normal_mode=m, refinement="off") for m in MODES}
    rows = []
    for mode in MODES:
        rows.append(
            Row(
                f"normals {mode}: rays over those of round",
                found[mode]["rays"] / found["round"]["rays"],
                band=None if quick else bands.RAYS_OF_BINS.get(mode),
                note=_note(found[mode]),
            )
        )
        rows.append(
            Row(
                f"normals {mode}: light where the exact picture of a thin wall is black",
                stray[mode]["stray"],
                note=f"{stray[mode]['rays']:.0f} rays, no refinement",
            )
        )
    rows.append(
        Row(
            "normals: that light, single over round",
            stray["single"]["stray"] / stray["round"]["stray"],
            band=bands.SINGLE_LEAKS,
        )
    )
    table = [{"normals": m, **found[m], "stray_thin_wall": stray[m]["stray"]} for m in MODES]
    return rows, table


def _note(found: dict[str, float]) -> str:
    return (
        f"RR {found['ray_reduction']:.1f}, rel_l1 {found['rel_l1']:.4f}, "
        f"bias {100 * found['bias']:+.2f} %"
    )


def grids_and_neighbours(quick: bool, size: Size) -> Iterator[Row]:
    """Offsets of the grids, and neighbours along the tangent plane."""
    shot = _shot(quick, size)
    base = mean_trade(shot, quick)
    fixed = mean_trade(shot, quick, grid_offset=False)
    level = mean_trade(shot, quick, tangent_neighbours=False)
    yield Row(
        "grids without offset: rays over those with it",
        fixed["rays"] / base["rays"],
        band=None if quick else bands.RAYS_WITHOUT_OFFSET,
        note=_note(fixed),
    )
    yield Row(
        "tangent neighbours: rel_l1 over that with the same v_z",
        base["rel_l1"] / level["rel_l1"],
        band=None if quick else bands.TANGENT_ERROR,
        note=f"without: {_note(level)}",
    )
    yield Row(
        "tangent neighbours: rays over those with the same v_z",
        base["rays"] / level["rays"],
        band=None if quick else bands.TANGENT_RAYS,
        note=_note(base),
    )


def light_kinds(quick: bool, size: Size) -> Iterator[Row]:
    """Refinement on and off, by kind of light."""
    for name, kinds in KINDS.items():
        setup = SETUPS[name]
        shot = replace(setup.shot(quick, size), size=size or (QUICK_SIZE if quick else SIZE))
        # An eighth of the setup's own samples
        shot = replace(shot, integrator=setup.integrator(True))
        exact = shot.frame()
        trades = {
            state: Trade(
                frame=shot.frame(
                    vc.Aqvc(c_e=C_E, refinement=dict.fromkeys(kinds, state), exact_groups=())
                ),
                exact=exact,
            )
            for state in ("off", "on")
        }
        for kind in kinds:
            off, on = (trades[state].group_rel_l1(kind) for state in ("off", "on"))
            reductions = [trades[s].group_reduction(kind) for s in ("off", "on")]
            shared = kind in ("point", "directional", "vpl")
            yield Row(
                f"refinement of {kind} light ({name}): rel_l1 on over off",
                on / off if off else None,
                band=bands.REFINED_ERROR if shared and not quick else None,
                note=f"{off:.4f} to {on:.4f}, RR {reductions[0]:.1f} to {reductions[1]:.1f}",
            )


def bias_rows(quick: bool, size: Size) -> tuple[list[Row], list[dict[str, Any]]]:
    """Rows and a table of the energy's bias over many grids, by scene, form and refinement."""
    rows: list[Row] = []
    table = []
    pixels = size or (QUICK_BIAS_SIZE if quick else BIAS_SIZE)
    for name in bands.REFINED_BIAS:
        shot = Shot(scene=getattr(vc.scenes, name)(), integrator=vc.Direct(), size=pixels)
        for form in FORMS:
            found = biases(shot, form, QUICK_BIAS_GRIDS if quick else BIAS_GRIDS)
            rows += _bias_rows(name, form, found, quick)
            table += [
                {
                    "scene": name,
                    "form": form,
                    "variant": variant,
                    "bias": interval.mean,
                    "half_of_95_percent": interval.half,
                    "rel_l1": rel_l1,
                    "ray_reduction": reduction,
                }
                for variant, (interval, rel_l1, reduction) in found.items()
            ]
    return rows, table


def biases(shot: Shot, form: str, grids: int) -> dict[str, tuple[Interval, float, float]]:
    """Bias, mean rel_l1 and mean RR of a form, without and with refinement."""
    found = {}
    for variant, refinement in VARIANTS.items():
        of = over_grids(shot, grids, c_e=BIAS_C_E, **FORMS[form], refinement=refinement)
        rel_l1, reduction = (float(of[name].mean()) for name in ("rel_l1", "ray_reduction"))
        found[variant] = mean_interval(of["bias"].tolist()), rel_l1, reduction
    return found


def _bias_rows(
    name: str, form: str, found: Mapping[str, tuple[Interval, float, float]], quick: bool
) -> Iterator[Row]:
    for variant, (interval, rel_l1, reduction) in found.items():
        what = f"{name}, {form}, {variant}: bias of the energy"
        banded = not quick and variant == "refinement" and form != "waves"
        yield Row(
            what,
            interval.mean,
            band=bands.REFINED_BIAS[name] if banded else None,
            note=f"{interval} (95 %), rel_l1 {rel_l1:.4f}, RR {reduction:.1f}",
        )
        # The paper's order is the same for all grids, so it favours the same representatives
        if variant == "no refinement" and form != "pairs":
            yield Row(
                f"{what} over half of its interval",
                interval.mean / interval.half,
                band=None if quick else bands.PLAIN_BIAS,
            )
