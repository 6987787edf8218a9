"""Exact and cached frames of one shot, and the measures that the figures report."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache.settings.integrators import Integrator
from viscache.settings.visibility import Visibility
from viscache_lab.experiment import Band, Row

Key = TypeVar("Key", bound=Hashable)

#: Amplification of the luminance error in Figure 5.
AMPLIFIED = 16.0
#: Frames of each setting in full runs, where times are compared. An odd number.
TURNS = 3


@dataclass(frozen=True, kw_only=True, slots=True)
class Shot:
    """All settings of a rendering except the visibility."""

    scene: vc.Scene
    integrator: Integrator
    size: tuple[int, int]
    spp: int = 1
    camera: str | int | vc.Camera | None = None

    def frame(self, visibility: Visibility | None = None, seed: int = 0) -> vc.Frame:
        """A frame, exact by default. Its time excludes building the ray caster."""
        self.scene.caster()
        return vc.render(
            self.scene,
            self.integrator,
            visibility=visibility or vc.Exact(engine="packets"),
            seed=seed,
            size=self.size,
            spp=self.spp,
            camera=self.camera,
        )

    def in_turns(
        self, settings: Mapping[Key, Visibility | None], quick: bool
    ) -> dict[Key, vc.Frame]:
        """A frame per setting, with the median CPU time of `TURNS`; of one turn if quick.

        The settings take turns, so that a busy machine slows all of them.
        """
        frames: dict[Key, list[vc.Frame]] = {key: [] for key in settings}
        for _ in range(1 if quick else TURNS):
            for key, visibility in settings.items():
                frames[key].append(self.frame(visibility))
        return {key: _median(made) for key, made in frames.items()}

    def trades(self, settings: Mapping[Key, Visibility], quick: bool) -> dict[Key, Trade]:
        """A trade per setting; the exact frame, which all share, takes turns with them."""
        frames = self.in_turns({None: None, **settings}, quick)
        return {key: Trade(frame=frames[key], exact=frames[None]) for key in settings}


@dataclass(frozen=True, kw_only=True, slots=True)
class Trade:
    """A cached frame and the exact frame of the same samples."""

    frame: vc.Frame
    exact: vc.Frame

    @property
    def ray_reduction(self) -> float:
        """Queries per ray."""
        return float(self.frame.counters["ray_reduction"])

    @property
    def speedup(self) -> float:
        """CPU seconds of the exact frame over those of the cached one."""
        return self.exact.timings["cpu_s"] / self.frame.timings["cpu_s"]

    @property
    def rel_l1(self) -> float:
        """rel_l1 of the whole picture."""
        return float(vc.metrics.rel_l1(_double(self.frame.image), _double(self.exact.image)) or 0.0)

    @property
    def reflected_rel_l1(self) -> float:
        """rel_l1 without directly visible emitters and sky."""
        cached, exact = (
            _double(f.image) - _double(f.layers["emitted"]) for f in (self.frame, self.exact)
        )
        return float(vc.metrics.rel_l1(cached, exact) or 0.0)

    @property
    def ssim(self) -> float:
        """SSIM of the whole picture; NaN if it is smaller than SSIM's window."""
        value = vc.metrics.compare(self.frame, self.exact, metrics=["ssim"]).ssim
        return float("nan") if value is None else value

    @property
    def groups(self) -> list[str]:
        """Light groups with queries."""
        return [n for n, c in self.exact.counters["groups"].items() if c["queries"]]

    def group_rel_l1(self, group: str) -> float:
        """rel_l1 of one light group's layer; 0 if it is black."""
        cached, exact = (_double(f.layers[group]) for f in (self.frame, self.exact))
        return float(vc.metrics.rel_l1(cached, exact) or 0.0)

    def group_reduction(self, group: str) -> float:
        """Queries per ray of one light group; infinite without rays."""
        counts = self.frame.counters["groups"][group]
        return float(counts["queries"] / counts["rays"]) if counts["rays"] else float("inf")

    @property
    def note(self) -> str:
        """RR, speed-up and the two times."""
        exact, cached = self.exact.timings["cpu_s"], self.frame.timings["cpu_s"]
        return (
            f"RR {self.ray_reduction:.1f}, speed-up {self.speedup:.2f}"
            f" ({exact:.2f} to {cached:.2f} CPU s)"
        )

    def record(self) -> dict[str, Any]:
        """A row of a table."""
        names = ("ray_reduction", "speedup", "rel_l1", "reflected_rel_l1", "ssim")
        return {
            **{name: getattr(self, name) for name in names},
            "exact_cpu_s": self.exact.timings["cpu_s"],
            "cpu_s": self.frame.timings["cpu_s"],
            **{f"rel_l1_{g}": self.group_rel_l1(g) for g in self.groups},
            **{f"rr_{g}": self.group_reduction(g) for g in self.groups},
        }


def _median(frames: Sequence[vc.Frame]) -> vc.Frame:
    """The frame of the median CPU time. All must have the same pixels."""
    if len({frame.sha256 for frame in frames}) != 1:
        raise AssertionError("frames of the same settings must have the same pixels")
    return sorted(frames, key=lambda frame: frame.timings["cpu_s"])[len(frames) // 2]


def _double(image: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    return np.asarray(image, dtype=np.float64)


def presets(c_e: float, **given: Any) -> dict[str, vc.Aqvc]:
    """The default and the paper's preset at one C_E."""
    return {
        "default": vc.Aqvc(c_e=c_e, exact_groups=(), **given),
        "paper": vc.Aqvc(preset="paper", c_e=c_e, **given),
    }


def group_rows(label: str, trade: Trade) -> list[Row]:
    """The error of each light group, so that the total hides none."""
    return [
        Row(
            f"{label}: rel_l1 of {group} light",
            trade.group_rel_l1(group),
            note=f"RR {trade.group_reduction(group):.1f}",
        )
        for group in trade.groups
    ]


def error_row(label: str, trade: Trade, band: Band | None = None) -> Row:
    """The error of the picture, and beside it that of reflected light and SSIM."""
    note = f"reflected light {trade.reflected_rel_l1:.4f}, SSIM {trade.ssim:.3f}"
    return Row(f"{label}: rel_l1", trade.rel_l1, band=band, note=note)


def difference(trade: Trade, gain: float = AMPLIFIED) -> npt.NDArray[np.float64]:
    """(H, W, 1) in [0, 1]: the absolute luminance error, amplified and exposed like the picture."""
    exposure = tonemap.auto_exposure(trade.exact.image, 95.0)
    cached, exact = (tonemap.luminance(f.image) for f in (trade.frame, trade.exact))
    error: npt.NDArray[np.float64] = np.clip(gain * exposure * np.abs(cached - exact), 0, 1)
    return error[:, :, None]
