"""Figure 7 of the quantized cache's paper: reduction, speed-up and quality over C_E."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import viscache as vc
from viscache.plots import label as plot_label
from viscache.plots.sweeps import ticks_1_2_5
from viscache.scenes.sources import scene_file
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Series, draw
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import TURNS, Shot, Trade, error_row, group_rows
from viscache_lab.figures.aqvc_setups import SETUPS, SIZE, Preset, Setup
from viscache_lab.figures.bands import aqvc as bands
from viscache_lab.figures.vismap_living_room import SKIES

#: C_E over the paper's range. The paper's preset runs at both ends and at one value between.
DELTA = {False: (4.0, 9.0, 18.0), True: (4.0, 12.0, 24.0, 36.0)}
SMOOTH = {False: (4.0, 8.0, 14.0, 24.0), True: (10.0, 20.0, 40.0, 64.0)}
#: Divisor of the lights per sample, in anti-aliased frames of scenes with many lights.
ANTIALIASED_LIGHTS = 4
#: Scenes by other authors, in $VISCACHE_SCENES, and their C_E.
FILES, FILES_C_E = ("living-room", "classroom", "sponza-dabrovic", "sanmiguel-part"), 10.0


@dataclass(kw_only=True, slots=True)
class Sweep:
    """Trades of one setup by preset and C_E, with or without anti-aliasing."""

    setup: Setup
    antialiased: bool
    spp: int
    trades: dict[str, dict[float, Trade]] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """Setup and samples."""
        return f"{self.setup.name}, {'AA' if self.antialiased else 'no AA'}"

    def largest(self, what: str, preset: str | None = None) -> float:
        """The largest value of an attribute."""
        chosen = [p for p in self.trades if preset in (None, p)]
        return max(float(getattr(t, what)) for p in chosen for t in self.trades[p].values())

    @property
    def last(self) -> Trade:
        """The default preset at the largest C_E."""
        return self.trades["default"][max(self.trades["default"])]


@FIGURES.add(
    "aqvc-fig7", "ray reduction, speed-up, rel_l1 and SSIM over C_E in five scenes", sized=True
)
def figure7(trial: Trial) -> None:
    """Every setup with and without anti-aliasing."""
    sweeps: list[Sweep] = []
    for setup in SETUPS.values():
        scene = setup.scene(trial.quick)
        for antialiased in (False, True):
            sweep, shot = make_sweep(setup, scene, antialiased, trial.quick, trial.size)
            values = c_e_values(setup, antialiased, trial.quick)
            settings = {(p, c_e): setup.cache(p, c_e) for p in values for c_e in values[p]}
            for (preset, c_e), trade in shot.trades(settings, trial.quick).items():
                sweep.trades.setdefault(preset, {})[c_e] = trade
            trial.rows += _sweep_rows(sweep, trial.quick)
            sweeps.append(sweep)
    trial.rows += _overall_rows(sweeps, trial.quick)
    if not trial.quick:
        trial.rows += _file_rows(trial, trial.size or SIZE)
    trial.save(_picture(sweeps), "aqvc-fig7.png")
    trial.csv("aqvc-fig7.csv", _table(sweeps))
    trial.notes.append(
        "Speed-ups: CPU seconds of whole frames against our fastest exact order, "
        f"{'one turn' if trial.quick else f'medians of {TURNS} turns'}. "
        f"Anti-aliased frames with virtual lights have 1/{ANTIALIASED_LIGHTS} of the lights and "
        "environment samples per sample of a pixel. The paper's QMOS has no counterpart here: "
        "SSIM stands beside it, no equivalence claimed."
    )


def c_e_values(setup: Setup, antialiased: bool, quick: bool) -> dict[Preset, Sequence[float]]:
    """C_E per preset: all for the default; both ends and one value between for the paper's."""
    values = (DELTA if setup.delta_lights else SMOOTH)[antialiased]
    if quick:
        values = (values[0], values[-1])
    few = sorted({values[0], values[len(values) // 2], values[-1]})
    return {"default": values, "paper": few}


def make_sweep(
    setup: Setup, scene: vc.Scene, antialiased: bool, quick: bool, size: tuple[int, int] | None
) -> tuple[Sweep, Shot]:
    """The sweeps to fill, and the frames to render."""
    spp = 1 if not antialiased else 4 if quick else setup.antialiased
    integrator = setup.integrator(quick)
    if antialiased and setup.n_vpls and not quick:
        n = setup.n_environment // ANTIALIASED_LIGHTS
        integrator = vc.Whitted(
            n_vpls=setup.n_vpls // ANTIALIASED_LIGHTS,
            n_environment=n,
            n_brdf=n,
            n_area=setup.n_area,
        )
    shot = Shot(scene=scene, integrator=integrator, spp=spp, size=setup.pixels(quick, size))
    return Sweep(setup=setup, antialiased=antialiased, spp=spp), shot


def _sweep_rows(sweep: Sweep, quick: bool) -> Iterator[Row]:
    for preset, trades in sweep.trades.items():
        label = f"{sweep.label}, {preset}"
        for c_e, trade in trades.items():
            yield Row(f"{label}, C_E {c_e:g}: RR", trade.ray_reduction, note=trade.note)
            yield error_row(f"{label}, C_E {c_e:g}", trade)
        first, last = trades[min(trades)], trades[max(trades)]
        yield Row(
            f"{label}: RR, largest over smallest C_E",
            last.ray_reduction / first.ray_reduction,
            band=bands.REDUCTION_RISES,
        )
        yield Row(
            f"{label}: rel_l1, largest over smallest C_E",
            last.rel_l1 / first.rel_l1,
            band=bands.ERROR_RISES,
        )
        yield Row(
            f"{label}: SSIM at the smallest C_E",
            first.ssim,
            printed="QMOS > 77 %",
            band=None if quick else bands.LEAST_SSIM,
        )
        yield from group_rows(f"{label}, C_E {max(trades):g}", last)
    implied = printed.SCENES[sweep.setup.printed].implied_speedup
    yield Row(
        f"{sweep.label}, default: largest speed-up",
        sweep.largest("speedup", "default"),
        printed=implied,
        note="printed: total/shading over what is left to gain, on a GPU",
    )


def _overall_rows(sweeps: Sequence[Sweep], quick: bool) -> Iterator[Row]:
    plain = {s.setup.name: s.last.reflected_rel_l1 for s in sweeps if not s.antialiased}
    others = float(np.mean([v for name, v in plain.items() if name != "hairball"]))
    gains = {s.label: s.largest("speedup", "default") for s in sweeps}
    conference, apartment = (
        max(s.largest("speedup", "default") for s in sweeps if s.setup.name == name)
        for name in ("conference", "apartment")
    )
    greatest = max(gains, key=lambda label: gains[label])
    yield Row(
        "largest RR",
        max(s.largest("ray_reduction") for s in sweeps),
        printed=printed.RAY_REDUCTION + 1,
        band=None if quick else bands.LARGEST_REDUCTION,
    )
    yield Row(
        "default: largest speed-up",
        gains[greatest],
        printed=printed.SPEEDUP,
        band=None if quick else bands.LARGEST_SPEEDUP,
        note=f"in {greatest}; the paper's in SAN MIGUEL",
    )
    yield Row(
        "default: largest speed-up in the conference room over the apartment's",
        conference / apartment,
        printed=printed.SCENES["conference"].implied_speedup
        / printed.SCENES["apartment"].implied_speedup,
        band=None if quick else bands.CONFERENCE_GAINS_LESS,
    )
    yield Row(
        "no AA, default: rel_l1 of reflected light, hairball over the others' mean",
        plain["hairball"] / others,
        band=None if quick else bands.HAIRBALL_ERRS_MOST,
    )


def _file_rows(trial: Trial, size: tuple[int, int]) -> Iterator[Row]:
    """Scenes by other authors, beside the stand-ins; without bands."""
    for name in FILES:
        scene = load_file(name, trial)
        if scene is None:
            continue
        integrator = vc.Whitted(n_vpls=256, n_environment=16, n_brdf=16, n_area=16)
        shot = Shot(scene=scene, integrator=integrator, size=size)
        presets: tuple[Preset, ...] = ("default", "paper")
        settings = {p: SETUPS["courtyard"].cache(p, FILES_C_E) for p in presets}
        for preset, trade in shot.trades(settings, quick=False).items():
            label = f"{name}, no AA, {preset}, C_E {FILES_C_E:g}"
            yield Row(f"{label}: RR", trade.ray_reduction, note=trade.note)
            yield Row(f"{label}: rel_l1", trade.rel_l1, note=f"SSIM {trade.ssim:.3f}")
            yield from group_rows(label, trade)


def load_file(name: str, trial: Trial) -> vc.Scene | None:
    """A scene by another author, with a measured sky if it has no light that viscache models."""
    path = scene_file(name)
    if path is None:
        trial.skip(name, "no scene file; VISCACHE_SCENES names the folder of scene folders")
        return None
    scene = vc.load_scene(path)
    sky = path.parent.parent / SKIES["noon"]
    if scene.lights:
        return scene
    if not sky.is_file():
        trial.skip(name, f"none of its lights is modelled, and {SKIES['noon']} is absent")
        return None
    return scene.with_environment(sky)


def _table(sweeps: Sequence[Sweep]) -> list[dict[str, Any]]:
    return [
        {"setup": s.setup.name, "spp": s.spp, "preset": preset, "c_e": c_e, **trade.record()}
        for s in sweeps
        for preset, trades in s.trades.items()
        for c_e, trade in trades.items()
    ]


def _picture(sweeps: Sequence[Sweep]) -> Any:
    """Three rows: reduction, speed-up, error. The right column is anti-aliased."""

    def panel(what: str, label: str, antialiased: bool) -> Panel:
        series = []
        for k, sweep in enumerate(s for s in sweeps if s.antialiased == antialiased):
            for preset, style in (("default", "-o"), ("paper", "--s")):
                trades = dict(sorted(sweep.trades[preset].items()))
                values = [getattr(trade, what) for trade in trades.values()]
                name = sweep.setup.name if preset == "default" else ""
                series.append(Series(name, list(trades), values, style, f"C{k}"))
        return Panel(
            series=series,
            x=plot_label("c_e"),
            y=label,
            logarithmic="y",
            title=("AA" if antialiased else "no AA") if what == "ray_reduction" else "",
            legend=False,
            more=lambda axes: ticks_1_2_5(axes.yaxis),
        )

    kinds = {"ray_reduction": "RR", "speedup": "speed-up", "rel_l1": "rel_l1"}
    figure = draw([[panel(*kind, aa) for aa in (False, True)] for kind in kinds.items()], (10, 9))
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(),
        loc="outside upper center",
        ncols=len(SETUPS),
        title="solid: preset default; dashed: paper",
    )
    return figure
