"""Settings of the visibility-map cache."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.spelling import setting

__all__ = ["PRESETS", "MapSettings", "automatic_thresholds", "expected_records"]

Floats: TypeAlias = npt.NDArray[np.floating[Any]]

#: Thresholds of the presets. The paper has three presets but gives no numbers.
PRESETS: dict[str, dict[str, float]] = {
    "low": {"w_min": 0.2, "delta_max": 0.10},
    "medium": {"w_min": 0.3, "delta_max": 0.06},
    "high": {"w_min": 0.4, "delta_max": 0.04},
}


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class MapSettings:
    """How records are created, found, inserted and removed (VisMap Sec. 5, Table 1).

    Parameters
    ----------
    preset : {"low", "medium", "high", "auto"}
        Determines `w_min` and `delta_max` if they are None. "auto": the tightest thresholds for
        which the start-up predicts few enough records (`automatic_thresholds`).
    m : int in [4, 7]
        M: maps have 2^m x 2^m cells; a record takes 76, 172, 572 or 2172 bytes.
    n_startup : int >= 1
        Number of start-up records, at first hits distributed over the image.
    d_max : float > 0
        Search radius for records as a fraction of the image width, measured by the size of a pixel
        at the point; at most a tenth of the scene's diagonal.
    theta_max_deg : float in (0, 180]
        Records are used only if their normal differs by less.
    n_best : int in [1, 8]
        Maximum number of blended records.
    m_nearest : int in [n_best, 64]
        Number of nearest records from which they are chosen.
    lam : float >= 0
        λ of Eq. 9.
    w_min : float in [0, 1], optional
        A point gets a record if no record in reach has this weight.
    delta_max : float in [0, 1], optional
        A point gets a record if the mean difference of the blended maps is larger (Eq. 11).
    r_min_px : float >= 0
        If a record is nearer than this, in footprints of a pixel, differing maps do not cause a new
        one.
    max_records : int in [1, 2^26]
        Maximum number of records in the cache.
    weight_test : {"full", "w_hat", "raw"}
        The weight compared with `w_min`: w_g·ŵ, ŵ, or w of Eq. 9.
    filter : {"during", "after"}
        Test normals during the search for the nearest records, or after it.
    criterion : {"visibility", "ambient"}
        "ambient": records for ambient occlusion. There are more of them near surfaces, and maps may
        differ. Their rays find the nearest hit.
    mode : {"batch", "locked"}
        "batch": the same records for any number of threads. "locked": a read-write lock, as in the
        paper.
    batch : int >= 1
        Number of pixels that are looked up together.
    settle : bool
        True: repeat passes over the image until no pixel needs a record. False: a single pass, as
        in the paper.
    order : {"scanline", "hilbert", "coarse_to_fine"}
        Order in which pixels may insert records.
    removal : {"rate", "wilson", "worst", "none"}
        Records removed at the end of a frame. "rate": those whose error rate exceeds `eps_max`.
        "wilson": those for which the lower end of its 95 % interval does. "worst": the `k_worst`
        with the highest error rates.
    eps_max : float in [0, 1]
        ε_max: maximum error rate.
    min_rays : int >= 0
        Records compared with fewer rays are kept.
    k_worst : int >= 0
    unused_frames : int >= 0
        Records that no pixel used for this many frames are removed; 0: never.
    seed : int >= 0
        Seed of the directions of the maps and of the start-up rays.
    """

    preset: Literal["low", "medium", "high", "auto"] = "medium"
    m: int = 5
    n_startup: int = 1000
    d_max: float = 0.05
    theta_max_deg: float = 30.0
    n_best: int = 4
    m_nearest: int = 16
    lam: float = 5.0
    w_min: float | None = None
    delta_max: float | None = None
    r_min_px: float = 2.0
    max_records: int = 1 << 20
    weight_test: Literal["full", "w_hat", "raw"] = "full"
    filter: Literal["during", "after"] = "during"
    criterion: Literal["visibility", "ambient"] = "visibility"
    mode: Literal["batch", "locked"] = "batch"
    batch: int = 4096
    settle: bool = True
    order: Literal["scanline", "hilbert", "coarse_to_fine"] = "scanline"
    removal: Literal["rate", "wilson", "worst", "none"] = "rate"
    eps_max: float = 0.05
    min_rays: int = 64
    k_worst: int = 0
    unused_frames: int = 10
    seed: int = 0

    def __post_init__(self) -> None:
        check_types(self)
        most = (1 << 32) - 1
        for name, low, high in (
            ("m", 4, 7), ("n_startup", 1, 1 << 24), ("n_best", 1, 8), ("batch", 1, 1 << 30),
            ("m_nearest", self.n_best, 64), ("max_records", 1, 1 << 26), ("min_rays", 0, most),
            ("k_worst", 0, most), ("unused_frames", 0, most), ("seed", 0, (1 << 64) - 1),
        ):  # fmt: skip
            value = getattr(self, name)
            require(low <= value <= high, f"{name} must be in [{low}, {high}]", value)
        require(0 < self.d_max <= 1000, "d_max must be in (0, 1000]", self.d_max)
        fits = self.removal != "worst" or self.k_worst > 0
        require(fits, 'k_worst must be > 0 with removal="worst"', self.k_worst)
        require(0 <= self.eps_max <= 1, "eps_max must be in [0, 1]", self.eps_max)
        self.core()

    def core(self) -> _core.vismap.MapCacheParameters:
        """The C++ struct. Thresholds to be determined by the start-up have the values of "medium".

        Raises
        ------
        ValueError
            A value is out of range.
        """
        preset = PRESETS.get(self.preset, PRESETS["medium"])
        return _core.vismap.MapCacheParameters(
            m=self.m, n_best=self.n_best, m_nearest=self.m_nearest,
            theta_max_rad=math.radians(self.theta_max_deg), lambda_=self.lam,
            w_min=preset["w_min"] if self.w_min is None else self.w_min,
            delta_max=preset["delta_max"] if self.delta_max is None else self.delta_max,
            r_min_px=self.r_min_px, max_records=self.max_records, weight_test=self.weight_test,
            filter=self.filter, criterion=self.criterion,
        )  # fmt: skip

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

    def parameters(self) -> dict[str, Any]:
        """Names and values for JSON."""
        return asdict(self)


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
RECORDS_PER_UNSERVED = 10
#: The choices of "auto": steps from the preset "medium", each full step halves delta_max.
STEPS = np.linspace(-2, 2, 81)


def expected_records(tested: Floats, difference: Floats, w_min: float, delta_max: float) -> float:
    """Estimate from the start-up how many records an image will get.

    Where no record is usable, there are many small surfaces close together, and each needs its own
    records. Where maps differ, the difference is proportional to the distance of records, and their
    number grows with the inverse square of that distance. Each start-up record is looked up without
    itself.

    Parameters
    ----------
    tested : (N,) float
        Largest weight of another record; 0 if none is in reach.
    difference : (N,) float
        Mean difference of the maps that would be blended; NaN for fewer than two.
    """
    known = difference[np.isfinite(difference)]
    by_weight = len(tested) + RECORDS_PER_UNSERVED * np.count_nonzero(tested < w_min)
    finer = np.maximum(known / max(delta_max, 1e-9), 1) ** 2
    return float(by_weight * (finer.mean() if len(finer) else 1.0))


def automatic_thresholds(tested: Floats, difference: Floats) -> tuple[float, float]:
    """Choose w_min and delta_max from the start-up; the paper does not specify them.

    The pairs lie on a line through the presets that extends beyond them on both sides. The tightest
    pair is chosen for which `expected_records` is small enough.

    Parameters
    ----------
    tested, difference : (N,) float
        See `expected_records`.

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
