"""Bias of the energy with and without refinement, over many grids."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import viscache as vc
from viscache.settings.by_name import replaced
from viscache_lab.experiment import Row
from viscache_lab.figures.aqvc_errors import Interval, bias, mean_interval
from viscache_lab.figures.aqvc_runs import Shot
from viscache_lab.figures.bands import aqvc as bands

C_E = 16.0
GRIDS, QUICK_GRIDS = 32, 3
SIZE, QUICK_SIZE = (480, 320), (120, 80)
SCENES = ("slats", "slits")
#: Level waves; Alg. 2 with single queries, in the paper's order and in an order random per grid.
FORMS: dict[str, dict[str, Any]] = {
    "waves": {},
    "pairs": {"preset": "paper"},
    "pairs, random order": {"preset": "paper", "order": "random"},
}
VARIANTS: dict[str, dict[str, Any]] = {
    "no refinement": {"refinement": "off"},
    "refinement": {"refinement": "on"},
}


def bias_rows(quick: bool, size: tuple[int, int] | None) -> tuple[list[Row], list[dict[str, Any]]]:
    """Rows and a table, by scene, form and variant."""
    rows: list[Row] = []
    table = []
    for name in SCENES:
        shot = Shot(
            scene=getattr(vc.scenes, name)(),
            integrator=vc.Direct(),
            size=size or (QUICK_SIZE if quick else SIZE),
        )
        for form in FORMS:
            found = biases(shot, form, QUICK_GRIDS if quick else GRIDS)
            rows += _rows(name, form, found, quick)
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
    """Bias, mean rel_l1 and mean RR of every variant of a form."""
    exact = shot.frame()
    total = float(exact.image.sum(dtype="f8"))
    found = {}
    for variant in VARIANTS:
        values, errors, reductions = [], [], []
        for grid in range(1, grids + 1):
            given = {
                "c_e": C_E,
                "grid_seed": grid,
                "exact_groups": (),
                **FORMS[form],
                **VARIANTS[variant],
            }
            frame = shot.frame(replaced(vc.Aqvc(), given, "visibility"))
            values.append(bias(frame, exact))
            errors.append(float(abs(frame.image - exact.image).sum(dtype="f8")) / total)
            reductions.append(float(frame.counters["ray_reduction"]))
        found[variant] = (mean_interval(values), _mean(errors), _mean(reductions))
    return found


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)


def _rows(
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
