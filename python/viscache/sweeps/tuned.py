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
    """What one value gave on the pilots' pixels."""

    value: float
    rel_l1: float
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
    rel_l1 : float
        The error on pixels that no pilot saw.
    interval : (low, high)
        95 % confidence interval of the error of such pixels (jackknife over tiles or frames).
    ray_reduction : float
        Queries per ray on the same pixels.
    pilots : tuple of Pilot
        What was tried, by value.
    samples : int
        Number of tiles or frames behind the interval.
    groups : dict of str to float
        The error of each light group's layer on the same pixels, relative to the light of the whole
        picture. If errors do not cancel, they add up to `rel_l1`.
    """

    target: float
    parameter: str
    value: float
    visibility: Any
    use: Any = None
    rel_l1: float
    interval: tuple[float, float]
    ray_reduction: float
    pilots: tuple[Pilot, ...]
    samples: int
    groups: dict[str, float]

    @property
    def c_e(self) -> float:
        """The value, if C_E was searched."""
        return _c_e(self)

    @property
    def reached(self) -> bool:
        """Whether the error on unseen pixels is within 30 % of the target, or below it."""
        return self.rel_l1 <= self.target * TOLERANCE

    @property
    def message(self) -> str:
        """Why the target is not reached and which light group limits it; empty if it is reached."""
        if self.reached:
            return ""
        symbol = SYMBOLS.get(self.parameter, (self.parameter,))[0]
        near = min(self.pilots, key=lambda p: abs(p.value - self.value))
        if near.rel_l1 <= self.target * TOLERANCE:
            low, high = self.interval
            text = (
                f"rel_l1 {self.target:.3g} is not confirmed: pilots had {near.rel_l1:.3g} at"
                f" {symbol} = {_text(self.value)}, pixels that they did not see have"
                f" {self.rel_l1:.3g} [{low:.3g}, {high:.3g}]."
            )
        else:
            least = min(self.pilots, key=lambda p: p.rel_l1)
            text = (
                f"No {symbol} reaches rel_l1 {self.target:.3g}: the smallest error found is"
                f" {least.rel_l1:.3g}, at {_text(least.value)}."
            )
        return text + self._limits()

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
            "rel_l1": self.rel_l1,
            "interval": list(self.interval),
            "reached": self.reached,
            "ray_reduction": self.ray_reduction,
            "samples": self.samples,
            "groups": self.groups,
            "message": self.message,
            "pilots": [
                {p.parameter: p.value, "rel_l1": p.rel_l1, "ray_reduction": p.ray_reduction}
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
            f"Tuned({self.parameter}={_text(self.value)},{light_cells} rel_l1={self.rel_l1:.3g}"
            f" [{low:.3g}, {high:.3g}], target={self.target:.3g},"
            f" ray_reduction={self.ray_reduction:.3g})"
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{_text(p.value)}</td><td>{p.rel_l1:.3g}</td><td>{p.ray_reduction:.3g}</td>"
            "</tr>"
            for p in self.pilots
        )
        name = html.escape(SYMBOLS.get(self.parameter, (self.parameter,))[-1])
        head = f"<tr><th>{name}</th><th>rel_l1</th><th>queries per ray</th></tr>"
        said = f"<p>{html.escape(self.message)}</p>" if self.message else ""
        return f"<table><caption>{html.escape(repr(self))}</caption>{head}{rows}</table>{said}"


def _c_e(found: Pilot | Tuned) -> float:
    if found.parameter != "c_e":
        raise AttributeError(f"{found.parameter} was searched, not c_e: see value")
    return found.value


def _text(value: float) -> str:
    """Whole numbers in full, others with three digits."""
    return str(value) if isinstance(value, int) else f"{value:.3g}"
