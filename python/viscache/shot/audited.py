"""The error of a cached frame, estimated from the few queries that exact rays answered as well."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache._core import draw_audit_pixels as draw_audit_pixels
from viscache.frame.emitted_light import light_on_surfaces
from viscache.settings.audit import LEAST_PIXELS
from viscache.settings.combinations import Request
from viscache.settings.integrators import Bdpt
from viscache.settings.visibility import Aqvc

Array = npt.NDArray[np.float64]

#: An error over light on surfaces that frames are warned of.
LARGE_ERROR = 0.05
#: One pixel in 256, and at most so many, are audited without being asked for.
MOST_WATCHED = 256
#: From fewer pixels not even a warning follows.
LEAST_FOR_WARNINGS = 100
#: With fewer wrong pixels, or wrong queries among those drawn at random, there is no interval.
LEAST_WRONG = 50
#: Nor with more of the pixels than this share, unless it is all of them.
MOST_SHARE = 1 / 8
#: Errors of less than this, in means of the picture, are rounding.
ROUNDING = 1e-5
#: Standard errors to either side of a 95 % interval.
WIDTH_95 = 1.96
#: Columns of the sums over the audited queries of a tile (render/audit.h).
SUMS = (
    "exact",
    "queries",
    "certain",
    "certain_wrong",
    "sampled",
    "sampled_wrong",
    "certain_error",
    "sampled_error",
    "sampled_square",
    "sampled_fourth",
)


def watched_pixels(request: Request, pixels: int) -> int:
    """How many pixels a frame audits for its warnings alone, without being asked to."""
    visibility = request.visibility
    waves = isinstance(visibility, Aqvc) and visibility.paper.form == "waves"
    if not waves or request.corrects or isinstance(request.integrator, Bdpt):
        return 0
    n = min(MOST_WATCHED, pixels // 256)
    return n if n > 1 else 0


def audit_record(found: Mapping[str, Any], frame: Any) -> dict[str, Any]:
    """The record of an audit: what `frame.counters["audit"]` holds.

    `found` is what the core found in all parts of the frame, with the settings of the audit.
    """
    audit, names = found["settings"], list(found["errors"])
    lights = {name: _sum(frame.layers[name]) for name in ("color", *names)}
    if audit["name"] == "AuditQueries":
        sums = {name: _fsums(found["queries"][name]) for name in names}
        all_ = {c: math.fsum(s[c] for s in sums.values()) for c in SUMS}
        return {
            "kind": "queries",
            **query_estimates(all_, lights["color"], audit["share"]),
            "groups": {n: query_estimates(sums[n], lights[n], audit["share"]) for n in names},
        }
    weight = np.asarray(found["weight"], np.float64)
    errors = {n: np.asarray(found["errors"][n], np.float64).reshape(-1, 3) for n in names}
    total = sum(errors.values(), np.zeros((len(weight), 3)))
    width, height = frame.size
    size = width * height
    surfaces = light_on_surfaces(frame)
    reflected = None if surfaces is None else _sum(surfaces)
    rays = int(found["rays"])
    return {
        "kind": "pixels",
        **pixel_estimates(weight, total, size, lights["color"], reflected),
        "rays": rays,
        "groups": {
            n: {**pixel_estimates(weight, errors[n], size, lights[n]), "rays": rays} for n in names
        },
    }


def pixel_estimates(
    weight: Array, errors: Array, size: int, light: float, reflected: float | None = None
) -> dict[str, Any]:
    """Errors of a frame a against the exact frame b, from n whole pixels.

    Ratios of estimated sums, each value by its weight. Their variance is that of the linearised
    ratio, from the two pixels of each stratum. Few pixels make up most of the sum, so intervals are
    symmetric in the logarithm, and Student's t has the degrees of freedom of Satterthwaite (1946).
    Still fewer make up nearly all of the sum of squares, and most samples lack them: nrmse has no
    interval.

    Weights (n,) of one stratum follow each other in pairs; they are 1 if all pixels are there.
    Errors (n, channels) are a - b; none at all if exact rays answered everything. `size` counts the
    frame's pixels, `light` is Σa over them, `reflected` the same without emitted light that the
    camera sees. Gives "pixels", and the records of `Estimate` for "rel_l1", "rel_l1_reflected" and
    "nrmse".
    """
    signed, absolute = errors.sum(axis=1), np.abs(errors).sum(axis=1)
    square = np.square(errors).sum(axis=1)
    exact = light - float((weight * signed).sum())
    whole = len(weight) in (0, size)
    wrong = int((absolute > ROUNDING * light / size).sum())
    why = None
    if len(weight) < LEAST_PIXELS:
        why = f"an interval takes at least {LEAST_PIXELS} drawn pixels, got {len(weight)}"
    elif len(weight) > MOST_SHARE * size:
        why = f"more than an eighth of {size} pixels were drawn: an audit of all has no error"
    elif wrong < LEAST_WRONG:
        why = f"an interval takes at least {LEAST_WRONG} wrong pixels, got {wrong}"

    def estimate(value: float, terms: Array, why: str | None) -> dict[str, Any]:
        """`terms`: what each pixel adds to the logarithm of the value."""
        spread, freedom = (0.0, 1.0) if whole or value == 0 else _spread(weight * terms)
        made: dict[str, Any] = {"value": value, "se": value * spread, "low": None, "high": None}
        if whole:
            return made | {"low": value, "high": value}
        if why is not None:
            return made | {"why": why}
        factor = math.exp(_student(freedom) * spread)
        return made | {"low": value / factor, "high": value * factor}

    def rel_l1(exact: float) -> dict[str, Any] | None:
        total = float((weight * absolute).sum())
        if not exact > 0 or not math.isfinite(total):
            return None
        return estimate(total / exact, absolute / (total or 1.0) + signed / exact, why)

    def nrmse() -> dict[str, Any] | None:
        total, channels = float((weight * square).sum()), errors.shape[1]
        if not exact > 0 or not math.isfinite(total):
            return None
        value = math.sqrt(total * size * channels) / exact
        rare = (
            "no interval of nrmse was shown to hold: the few pixels that decide it are rarely drawn"
        )
        return estimate(value, square / (2 * total or 1.0) + signed / exact, rare)

    shift = None if reflected is None else reflected - light
    return {
        "pixels": len(weight),
        "rel_l1": rel_l1(exact),
        "rel_l1_reflected": None if shift is None else rel_l1(exact + shift),
        "nrmse": nrmse(),
    }


def query_estimates(sums: Mapping[str, float], light: float, share: float) -> dict[str, Any]:
    """Bias and share of wrong answers, from `SUMS` over audited queries of a frame or a group.

    `light` is Σa over the frame or the layer, `share` the probability with which each query that is
    not certain was audited.
    """
    queries, audited = sums["exact"] + sums["queries"], sums["certain"] + sums["sampled"]
    others = sums["queries"] - sums["certain"]
    unknown = others > 0 and sums["sampled"] == 0
    error = sums["certain_error"] + sums["sampled_error"] / share
    se = math.sqrt(max(0.0, (1 - share) * sums["sampled_square"])) / share
    exact = light - error
    bias: dict[str, Any] | None = None
    if exact > 0 and not unknown:
        value, se = error / exact, se * light / exact**2
        bias = {"value": value, "se": se, "low": None, "high": None}
        fourth, hits = sums["sampled_fourth"], sums["sampled_wrong"]
        if share == 1:
            bias |= {"low": value, "high": value}
        elif hits < LEAST_WRONG:
            why = f"an interval takes at least {LEAST_WRONG} wrong answers drawn, got {hits:.0f}"
            bias |= {"why": why}
        else:
            freedom = max(1.0, sums["sampled_square"] ** 2 / fourth) if fourth > 0 else 1.0
            half = _student(freedom) * se
            bias |= {"low": value - half, "high": value + half}
    wrong: dict[str, Any] | None = None
    if queries > 0 and not unknown:
        rate = sums["sampled_wrong"] / sums["sampled"] if sums["sampled"] else 0.0
        low, high = _wilson(sums["sampled_wrong"], sums["sampled"], share)
        part = others / queries
        certain = sums["certain_wrong"] / queries
        spread = math.sqrt((1 - share) * rate * (1 - rate) / max(1.0, sums["sampled"]))
        wrong = {
            "value": certain + part * rate,
            "se": part * spread,
            "low": certain + part * low,
            "high": certain + part * high,
        }
    return {
        "queries": int(queries),
        "audited": int(audited),
        "rays": int(audited),
        "bias": bias,
        "wrong": wrong,
    }


def nothing_found(names: list[str]) -> dict[str, Any]:
    """What an audit of pixels finds where exact rays answered everything."""
    return {"rays": 0, "weight": [], "errors": {name: [] for name in names}, "queries": {}}


def joined(parts: list[Mapping[str, Any]]) -> dict[str, Any]:
    """What the core found, of several parts of a frame."""
    return {
        "settings": parts[0]["settings"],
        "rays": sum(int(part["rays"]) for part in parts),
        "weight": np.concatenate([np.asarray(part["weight"], np.float64) for part in parts]),
        "errors": {
            name: np.concatenate([np.reshape(part["errors"][name], (-1, 3)) for part in parts])
            for name in parts[0]["errors"]
        },
        "queries": {
            name: [row for part in parts for row in part["queries"].get(name, [])]
            for name in parts[0]["errors"]
        },
    }


def error_warnings(frame: Any) -> list[str]:
    """A warning where the estimated error may be above `LARGE_ERROR`."""
    audit: Mapping[str, Any] | None = frame.counters.get("audit")
    if audit is None or audit["kind"] != "pixels" or audit["pixels"] < LEAST_FOR_WARNINGS:
        return []
    found = audit["rel_l1_reflected"]
    if found is None or found["value"] <= 0:
        return []
    value = found["value"]
    if value * math.exp(WIDTH_95 * found["se"] / value) <= LARGE_ERROR:
        return []
    errors = {n: g["rel_l1"]["value"] * _sum(frame.layers[n]) if g["rel_l1"] else 0.0
              for n, g in audit["groups"].items()}  # fmt: skip
    group = max(errors, key=errors.__getitem__)
    sure = "" if found["low"] is None else (
        f"95 % interval {found['low']:.1%} to {found['high']:.1%}, "
    )  # fmt: skip
    return [
        f"the cache errs by about {value:.1%} of the light on surfaces ({sure}from"
        f" {audit['pixels']} pixels traced exactly), most of"
        f" it in light group {group!r}: use a smaller c_finest or c_e,"
        f" exact_groups=({group!r},), or vc.Exact()"
    ]


def _sum(layer: npt.NDArray[Any]) -> float:
    return float(np.asarray(layer, np.float64).sum())


def _fsums(rows: Any) -> dict[str, float]:
    """Sums over tiles; exact, so that the order of tiles does not matter."""
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(SUMS)
    return {name: math.fsum(column) for name, column in zip(SUMS, columns, strict=True)}


def _spread(terms: Array) -> tuple[float, float]:
    """Standard deviation of a sum over pairs, and its degrees of freedom."""
    variances = np.square(terms[::2] - terms[1::2])
    total = float(variances.sum())
    squares = float(np.square(variances).sum())
    return math.sqrt(total), max(1.0, total**2 / squares) if squares > 0 else 1.0


def _student(freedom: float) -> float:
    """Standard errors to either side of a 95 % interval."""
    from scipy.special import stdtrit  # type: ignore[import-untyped,unused-ignore]

    return float(stdtrit(freedom, 0.975))


def _wilson(hits: float, n: float, share: float) -> tuple[float, float]:
    """Wilson's interval of a rate, from a random share of a finite number of trials."""
    if n <= 0:
        return (0.0, 0.0)
    rate, z2 = hits / n, WIDTH_95**2 * (1 - share)
    middle = (rate + z2 / (2 * n)) / (1 + z2 / n)
    half = math.sqrt(z2 * (rate * (1 - rate) / n + z2 / (4 * n * n))) / (1 + z2 / n)
    return (max(0.0, middle - half), min(1.0, middle + half))
