"""What `tune` found: the setting, its error on pixels that no pilot saw, and what was tried."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import Any

from viscache.settings.visibility import Aqvc

__all__ = ["OWN_SAMPLES", "TOLERANCE", "Pilot", "Tuned"]

#: The error that is reached may exceed the target by this factor.
TOLERANCE = 1.3
#: Light groups whose samples belong to one pixel each, and the parameters that count them: light
#: cells bound their error, not C_E.
OWN_SAMPLES = {
    "area": "n_area, n_brdf",
    "environment": "n_environment, n_brdf",
    "ambient": "n_samples",
}
#: How parameters are written in text and in headings, if not by their names.
SYMBOLS = {"c_e": ("C_E", "C_E [px]")}


@dataclass(frozen=True, slots=True)
class Pilot:
    """What one value gave on the pilots' pixels: the error in the metric that was asked for."""

    value: float
    error: float
    ray_reduction: float
    parameter: str = "c_e"

    @property
    def c_e(self) -> float:
        """The value, if C_E was searched."""
        return _c_e(self)


@dataclass(frozen=True, kw_only=True, slots=True)
class Tuned:
    """What `tune` found.

    Attributes
    ----------
    parameter : str
        The parameter that was searched.
    value : float or int
        Its value to use; `visibility` (or `use`) has it. If C_E was searched, `c_e` is the same.
    visibility, use
        What to render with: `vc.render(..., visibility=found.visibility, use=found.use)`.
    metric : {"rel_l1_reflected", "rel_l1"}
        The metric that should have the target; `error` is its value.
    rel_l1, rel_l1_reflected : float
        The errors on pixels that no pilot saw: over all light, and over light on surfaces.
    interval : (low, high)
        95 % confidence interval of `error` on such pixels (jackknife over tiles or blocks).
    ray_reduction : float
        Queries per ray on the same pixels.
    pilots : tuple of Pilot
        What was tried, by value.
    samples : int
        Number of tiles or blocks behind the interval.
    groups : dict of str to float
        The error of each light group's layer on the same pixels, relative to the light that the
        metric divides by. If errors do not cancel, they add up to `error`.
    seconds, seconds_exact : float
        CPU seconds of a frame with this setting and of an exact one, measured on the same pixels.
    """

    target: float
    parameter: str
    value: float
    visibility: Any
    use: Any = None
    metric: str = "rel_l1_reflected"
    rel_l1: float
    rel_l1_reflected: float
    interval: tuple[float, float]
    ray_reduction: float
    pilots: tuple[Pilot, ...]
    samples: int
    groups: dict[str, float]
    seconds: float
    seconds_exact: float

    @property
    def error(self) -> float:
        """The error in `metric`."""
        return self.rel_l1 if self.metric == "rel_l1" else self.rel_l1_reflected

    @property
    def exact_is_cheaper(self) -> bool:
        """Whether an exact frame took less CPU time."""
        return self.seconds_exact < self.seconds

    @property
    def c_e(self) -> float:
        """The value, if C_E was searched."""
        return _c_e(self)

    @property
    def reached(self) -> bool:
        """Whether the error on unseen pixels is within 30 % of the target, or below it."""
        return self.error <= self.target * TOLERANCE

    @property
    def message(self) -> str:
        """Why the error is not near the target, and what limits it; empty if it is near.

        Then, if it is so, that an exact frame is cheaper, with both times.
        """
        texts = [self._off_target(), self._cost()]
        return " ".join(text for text in texts if text)

    def _off_target(self) -> str:
        low, high = self.target / TOLERANCE, self.target * TOLERANCE
        near = min(self.pilots, key=lambda p: abs(p.value - self.value))
        if self.error > high:
            text = self._above() if near.error > high else self._not_confirmed(near)
            return text + self._limits()
        if self.error < low:
            return self._below(near) if near.error < low else self._not_confirmed(near)
        return ""

    def _not_confirmed(self, near: Pilot) -> str:
        """The pilots had the target, the other pixels have more or less."""
        low, high = self.interval
        return (
            f"{self.metric} {self.target:.3g} is not confirmed: pilots had {near.error:.3g} at"
            f" {self._symbol} = {_text(self.value)}, pixels that they did not see have"
            f" {self.error:.3g} [{low:.3g}, {high:.3g}]."
        )

    def _above(self) -> str:
        least = min(self.pilots, key=lambda p: p.error)
        return (
            f"No {self._symbol} reaches {self.metric} {self.target:.3g}: the smallest error found"
            f" is {least.error:.3g}, at {_text(least.value)}."
        )

    def _below(self, near: Pilot) -> str:
        """All tried values have smaller errors, or the error jumps over the target."""
        above = [p for p in self.pilots if p.error > self.target]
        text = f"The error is below {self.metric} {self.target:.3g}: "
        if not above:
            return (
                f"{text}no {self._symbol} that was tried has more than {near.error:.3g}, at"
                f" {_text(near.value)}."
            )
        next_one = min(above, key=lambda p: abs(p.value - self.value))
        return (
            f"{text}it jumps from {near.error:.3g} at {self._symbol} = {_text(near.value)} to"
            f" {next_one.error:.3g} at {_text(next_one.value)}."
        )

    def _cost(self) -> str:
        if not self.exact_is_cheaper:
            return ""
        return (
            f"Exact visibility is cheaper here: {self.seconds_exact:.3g} s of the CPU for a frame"
            f" against {self.seconds:.3g} s with this setting. vc.Exact() has no error."
        )

    @property
    def _symbol(self) -> str:
        return SYMBOLS.get(self.parameter, (self.parameter,))[0]

    def _limits(self) -> str:
        if not self.groups:
            return ""
        worst = max(self.groups, key=self.groups.__getitem__)
        text = f" The group {worst!r} limits it, off by {self.groups[worst]:.3g}"
        rest = sorted((g for g in self.groups if g != worst), key=lambda g: -self.groups[g])
        text += "".join(f", {g} by {self.groups[g]:.3g}" for g in rest) + "."
        if worst in OWN_SAMPLES and self.parameter == "c_e":
            text += (
                " Its samples are each pixel's own: the size of their light cells bounds their"
                f" error, not C_E. A smaller c_l makes the cells smaller, and so do more samples"
                f" ({OWN_SAMPLES[worst]}); vc.Exact() has no error."
            )
        return text

    def as_dict(self) -> dict[str, Any]:
        """What `viscache tune --json` prints."""
        light_cells = {} if self.c_l is None else {"c_l": self.c_l}
        return {
            "target": self.target,
            "parameter": self.parameter,
            "value": self.value,
            self.parameter: self.value,
            **light_cells,
            "metric": self.metric,
            "error": self.error,
            "rel_l1": self.rel_l1,
            "rel_l1_reflected": self.rel_l1_reflected,
            "interval": list(self.interval),
            "reached": self.reached,
            "ray_reduction": self.ray_reduction,
            "samples": self.samples,
            "groups": self.groups,
            "seconds": self.seconds,
            "seconds_exact": self.seconds_exact,
            "exact_is_cheaper": self.exact_is_cheaper,
            "message": self.message,
            "pilots": [
                {p.parameter: p.value, "error": p.error, "ray_reduction": p.ray_reduction}
                for p in self.pilots
            ],
        }

    @property
    def c_l(self) -> float | None:
        """Size of the light cells of the quantized cache, which `tune` may have chosen too."""
        chosen = isinstance(self.visibility, Aqvc) and self.parameter == "c_e"
        return self.visibility.resolved()["c_l"] if chosen else None

    def __repr__(self) -> str:
        low, high = self.interval
        light_cells = "" if self.c_l is None else f" c_l={self.c_l:.3g},"
        return (
            f"Tuned({self.parameter}={_text(self.value)},{light_cells}"
            f" {self.metric}={self.error:.3g} [{low:.3g}, {high:.3g}], target={self.target:.3g},"
            f" ray_reduction={self.ray_reduction:.3g})"
        )

    def __str__(self) -> str:
        return f"{self!r}\n{self.message}" if self.message else repr(self)

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{_text(p.value)}</td><td>{p.error:.3g}</td><td>{p.ray_reduction:.3g}</td>"
            "</tr>"
            for p in self.pilots
        )
        name = html.escape(SYMBOLS.get(self.parameter, (self.parameter,))[-1])
        head = f"<tr><th>{name}</th><th>{self.metric}</th><th>queries per ray</th></tr>"
        said = f"<p>{html.escape(self.message)}</p>" if self.message else ""
        return f"<table><caption>{html.escape(repr(self))}</caption>{head}{rows}</table>{said}"


def _c_e(found: Pilot | Tuned) -> float:
    if found.parameter != "c_e":
        raise AttributeError(f"{found.parameter} was searched, not c_e: see value")
    return found.value


def _text(value: float) -> str:
    """Whole numbers in full, others with three digits."""
    return str(value) if isinstance(value, int) else f"{value:.3g}"
