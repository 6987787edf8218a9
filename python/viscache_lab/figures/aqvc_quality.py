"""Comparison of the quantized cache's quality choices (Sec. 3.3, Sec. 3.6, and later ones)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import viscache as vc
from viscache.aqvc import eye_keys
from viscache.settings.by_name import replaced
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.figures.aqvc_bias import bias_rows
from viscache_lab.figures.aqvc_errors import bias, stray_light
from viscache_lab.figures.aqvc_runs import Shot, Trade
from viscache_lab.figures.aqvc_setups import SETUPS
from viscache_lab.figures.bands import aqvc as bands

Size = tuple[int, int] | None

C_E = 12.0
SIZE, QUICK_SIZE = (640, 400), (120, 75)
GRIDS, QUICK_GRIDS = 4, 1
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


def mean_trade(shot: Shot, quick: bool, **given: Any) -> dict[str, float]:
    """Rays, RR, rel_l1 and bias, as means over grids. The given settings replace the preset's."""
    exact = shot.frame()
    found = []
    for grid in range(1, 1 + (QUICK_GRIDS if quick else GRIDS)):
        cache = vc.Aqvc(c_e=C_E, exact_groups=(), paper=vc.PaperForm(grid_seed=grid))
        settings = replaced(cache, given, "visibility")
        trade = Trade(frame=shot.frame(settings), exact=exact)
        found.append(
            [
                trade.frame.counters["rays"],
                trade.ray_reduction,
                trade.rel_l1,
                bias(trade.frame, exact),
                stray_light(trade.frame, exact),
            ]
        )
    names = ("rays", "ray_reduction", "rel_l1", "bias", "stray")
    return dict(zip(names, np.mean(found, axis=0).tolist(), strict=True))


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
