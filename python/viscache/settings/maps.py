"""Settings of the visibility-map cache."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import require
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.spelling import setting

Floats: TypeAlias = npt.NDArray[np.floating[Any]]

#: Thresholds of the presets. The paper has three presets but gives no numbers.
PRESETS: dict[str, dict[str, float]] = {
    "low": {"w_min": 0.2, "delta_max": 0.10},
    "medium": {"w_min": 0.3, "delta_max": 0.06},
    "high": {"w_min": 0.4, "delta_max": 0.04},
}


ROWS = ParameterRows(_core.vismap.MapCacheParameters)


@setting
@ROWS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class MapSettings(RowSettings):
    """How records are created, found, inserted and removed (VisMap Sec. 5, Table 1).

    Parameters
    ----------
    preset : {"low", "medium", "high", "auto"}
        Determines `w_min` and `delta_max` if they are None. "auto": the tightest thresholds for
        which the start-up predicts few enough records (`automatic_thresholds`).
    {parameters}
    order : {"scanline", "hilbert", "coarse_to_fine"}
        Order in which pixels may insert records.
    """

    ROWS: ClassVar[ParameterRows] = ROWS
    preset: Literal["low", "medium", "high", "auto"] = "medium"
    m: int = ROWS.default("m")
    n_startup: int = ROWS.default("n_startup")
    d_max: float = ROWS.default("d_max")
    theta_max_deg: float = ROWS.default("theta_max_deg")
    n_best: int = ROWS.default("n_best")
    m_nearest: int = ROWS.default("m_nearest")
    lam: float = ROWS.default("lam")
    w_min: float | None = ROWS.default("w_min")
    delta_max: float | None = ROWS.default("delta_max")
    r_min_px: float = ROWS.default("r_min_px")
    max_records: int = ROWS.default("max_records")
    weight_test: Literal["full", "w_hat", "raw"] = ROWS.default("weight_test")
    filter: Literal["during", "after"] = ROWS.default("filter")
    criterion: Literal["visibility", "ambient"] = ROWS.default("criterion")
    mode: Literal["batch", "locked"] = ROWS.default("mode")
    batch: int = ROWS.default("batch")
    repeat_passes: bool = ROWS.default("repeat_passes")
    order: Literal["scanline", "hilbert", "coarse_to_fine"] = "scanline"
    removal: Literal["rate", "wilson", "worst", "none"] = ROWS.default("removal")
    eps_max: float = ROWS.default("eps_max")
    min_rays: int = ROWS.default("min_rays")
    k_worst: int = ROWS.default("k_worst")
    unused_frames: int = ROWS.default("unused_frames")
    seed: int = ROWS.default("seed")

    def thresholds(self, startup: Mapping[str, Any] | None = None) -> tuple[float, float]:
        """(w_min, delta_max) as given, from the preset, or from the statistics of the start-up."""
        given = self.w_min, self.delta_max
        if self.preset == "auto" and startup is not None:
            chosen = automatic_thresholds(startup["tested"], startup["difference"])
        else:
            preset = PRESETS.get(self.preset, PRESETS["medium"])
            chosen = preset["w_min"], preset["delta_max"]
        w_min, delta_max = (c if g is None else g for g, c in zip(given, chosen, strict=True))
        return w_min, delta_max


def map_settings(given: MapSettings | str | None) -> MapSettings:
    """The settings that an argument means: themselves, the name of a preset, None the defaults."""
    if isinstance(given, str):
        return MapSettings(preset=given)  # type: ignore[arg-type]  # checked there
    known = given is None or isinstance(given, MapSettings)
    require(known, "settings must be a MapSettings", given)
    return given or MapSettings()


#: Maximum of `expected_records` with "auto". Images of 1600×1200 get up to three times as many
#: records (docs/performance/visibility-maps.md).
EXPECTED_RECORDS = 5000
#: Number of records per start-up record for which no other start-up record is usable.
RECORDS_PER_ISOLATED = 10
#: The choices of "auto": steps from the preset "medium", each full step halves delta_max.
STEPS = np.linspace(-2, 2, 81)


def expected_records(tested: Floats, difference: Floats, w_min: float, delta_max: float) -> float:
    """Estimate from the start-up how many records an image will get.

    Where no record is usable, there are many small surfaces close together, and each needs its own
    records. Where maps differ, the difference is proportional to the distance of records, and their
    number grows with the inverse square of that distance. Each start-up record is looked up without
    itself: `tested` (N,) is the largest weight of another record, 0 if none is in reach;
    `difference` (N,) is the mean one of the maps that would be blended, NaN for fewer than two.
    """
    known = difference[np.isfinite(difference)]
    by_weight = len(tested) + RECORDS_PER_ISOLATED * np.count_nonzero(tested < w_min)
    finer = np.maximum(known / max(delta_max, 1e-9), 1) ** 2
    return float(by_weight * (finer.mean() if len(finer) else 1.0))


def automatic_thresholds(tested: Floats, difference: Floats) -> tuple[float, float]:
    """Choose w_min and delta_max from the start-up; the paper does not specify them.

    The pairs lie on a line through the presets that extends beyond them on both sides. The tightest
    pair is chosen for which `expected_records`, with the same arguments, is small enough.

    Examples
    --------
    >>> import numpy as np
    >>> flat = automatic_thresholds(np.full(999, 0.6), np.full(999, 0.05))
    >>> hard = automatic_thresholds(np.full(999, 0.05), np.full(999, 0.15))
    >>> flat[0] > hard[0], flat[1] < hard[1]
    (True, True)
    """
    chosen = _step(STEPS[0])
    for step in STEPS:
        if expected_records(tested, difference, *_step(step)) <= EXPECTED_RECORDS:
            chosen = _step(step)
    return chosen


def _step(x: float) -> tuple[float, float]:
    """x = 0: "medium"; 0.585: "high"; −0.74: "low"."""
    medium = PRESETS["medium"]
    w_min = min(max(medium["w_min"] + 0.15 * float(x), 0.1), 0.5)
    return w_min, medium["delta_max"] * 2.0 ** -float(x)
