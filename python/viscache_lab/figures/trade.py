"""The trade over time: exact, biased, corrected and picked visibility, pass by pass."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import viscache as vc
from viscache.passes.over_time import gain
from viscache.plots.drawing import new_figure
from viscache.plots.over_time import draw_over_time
from viscache_lab.experiment import FIGURES, Band, Row, Trial
from viscache_lab.experiment.amounts import student_t
from viscache_lab.figures.bands import trade as bands

if TYPE_CHECKING:
    import xarray

#: C_E of the cache and number of picks, for all scenes.
C_E, PICKS = 10, 16
#: Scenes where corrected passes have a band over picks, and biased ones over corrected ones.
ROOMS = ("room", "apartment", "conference")


@dataclass(frozen=True, slots=True)
class Case:
    """A scene: a built-in spec, or a file in the folder of scenes by others."""

    name: str
    scene: str


CASES = (
    Case("room", "room?triangles=200000"),
    Case("apartment", "apartment?triangles=300000"),
    Case("conference", "conference"),
    Case("garage", "garage"),
    Case("living-room", "living-room/scene.xml"),
    Case("sponza-dabrovic", "sponza-dabrovic/scene.xml"),
    Case("classroom", "classroom/scene.xml"),
    Case("veach-ajar", "veach-ajar/scene.pbrt"),
)
QUICK = (Case("room", "room?triangles=3000"), Case("conference", "conference?triangles=20000"))


@FIGURES.add(
    "trade",
    "error over time: exact, biased, corrected and picked visibility, pass by pass",
    sized=True,
)
def trade(trial: Trial) -> None:
    """Passes of one sample with lights that stay the same, on one thread each."""
    found, table = {}, []
    light = vc.Whitted(n_vpls=64 if trial.quick else 1024)
    for case, scene in trial.scenes(QUICK if trial.quick else CASES):
        ds = vc.passes_over_time(
            scene,
            light,
            settings(light),
            passes=8 if trial.quick else 16,
            size=trial.size or ((48, 32) if trial.quick else (192, 192)),
            threads=1,
            progress=trial.progress,
        )
        found[case.name] = ds
        trial.rows += _rows(case.name, ds, trial.quick)
        table += [
            {"scene": case.name, **row}
            for row in ds.drop_dims("row").to_dataframe().reset_index().to_dict("records")
        ]
    trial.rows.append(_verdict(found))
    trial.save(_picture(found), "trade.png")
    trial.csv("trade.csv", table)
    trial.notes.append(
        "Errors are of light on surfaces, against two pictures of as many exact passes with other"
        " eye samples and the same lights. Settings took turns. A gain is squared error · CPU"
        " seconds of one way over that of the other; that of biased passes falls with more passes."
    )


def settings(light: vc.Whitted) -> dict[str, Any]:
    """What is compared, by name."""
    cache = vc.Aqvc(c_e=C_E)
    return {
        "exact": {"visibility": vc.Exact()},
        "packets": {"visibility": vc.Exact(engine="packets")},
        "biased": {"visibility": cache, "use": "replace"},
        "corrected": {"visibility": cache, "use": "correct"},
        f"{PICKS} picks": {"visibility": vc.Exact(), "integrator": replace(light, pick=PICKS)},
    }


def _rows(name: str, ds: xarray.Dataset, quick: bool) -> list[Row]:
    def last(setting: str, variable: str) -> float:
        return float(ds[variable].sel(setting=setting)[-1])

    def band(table: Any) -> Band | None:
        return None if quick else table

    picks = f"{PICKS} picks"
    room = name in ROOMS
    # Few pixels and passes: only the scene whose bias is largest is sure to show it
    stalls = bands.STALLS if name == "room" or (room and not quick) else None
    note = ", ".join(
        f"{n} {last(n, 'nmse'):.3g} in {last(n, 'cpu_s'):.3g} s" for n in ds["setting"].values
    )
    stall = last("biased", "nmse") / last("corrected", "nmse")
    words = f"{name}, corrected"
    rows = [
        Row(f"{words} over packets: gain, nMSE", gain(ds, "corrected", "packets"),
            band=band(bands.GAIN.get(name)), note=note),
        Row(f"{words} over packets: gain, relMSE", gain(ds, "corrected", "packets", "rel_mse"),
            band=band(bands.RELATIVE_GAIN.get(name))),
        Row(f"{words} over exact: gain, nMSE", gain(ds, "corrected"),
            band=band(bands.NEVER_WORSE)),
        Row(f"{words} over {picks}: gain, nMSE", gain(ds, "corrected", picks),
            band=band(bands.OVER_PICKS if room else None)),
        Row(f"{name}, biased over exact: gain, nMSE", gain(ds, "biased")),
        Row(f"{name}, {picks} over exact: gain, nMSE", gain(ds, picks)),
        Row(f"{name}: nMSE of biased over that of corrected passes", stall, band=stalls),
    ]  # fmt: skip
    for setting in ("corrected", picks):
        row = Row(f"{name}, {setting}: absolute t of the energy", abs(energy_t(ds, setting)),
                  band=bands.UNBIASED)  # fmt: skip
        rows.append(row)
    return rows


def energy_t(ds: xarray.Dataset, setting: str) -> float:
    """Student's t of the energy of passes against exact passes of the same samples."""
    off = (ds["energy"].sel(setting=setting) - ds["energy"].sel(setting="exact")).values
    return student_t(off)


def _verdict(found: dict[str, xarray.Dataset]) -> Row:
    """In how many scenes corrected passes are the best of the unbiased ways."""
    ways = ("exact", "corrected", f"{PICKS} picks")
    best = {n: max(ways, key=lambda w: gain(ds, w)) for n, ds in found.items()}
    words = "; ".join(
        f"{way}: {', '.join(n for n, w in best.items() if w == way) or 'none'}" for way in ways
    )
    return Row(
        f"verdict: scenes of {len(found)} where corrected passes have least error · time",
        sum(way == "corrected" for way in best.values()),
        note=f"least unbiased error · time — {words}",
    )


def _picture(found: dict[str, xarray.Dataset]) -> Any:
    """A panel per scene."""
    columns = min(4, max(1, len(found)))
    rows = -(-max(1, len(found)) // columns)
    drawing = new_figure(4.0 * columns, 3.4 * rows)
    panels = drawing.subplots(rows, columns, squeeze=False).ravel()
    for panel in panels[len(found) :]:
        panel.set_axis_off()
    for panel, (name, ds) in zip(panels, found.items(), strict=False):
        draw_over_time(panel, ds, legend=panel is panels[0])
        panel.set_title(name, fontsize=10)
    return drawing
