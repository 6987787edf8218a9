"""What `tune` found: the setting, its error on pixels that no pilot saw, and what was tried."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from typing import Any, Literal

from viscache.oracles.correct import in_words
from viscache.settings.visibility import Aqvc, Exact

#: The error that is reached may exceed the target by this factor.
TOLERANCE = 1.3
#: The time that is taken may exceed the target by this factor.
LATE = 1.1
#: Light groups whose samples belong to one pixel each, and the parameters that count them: light
#: cells bound their error, not C_E.
OWN_SAMPLES = {
    "area": "n_area, n_brdf",
    "environment": "n_environment, n_brdf",
    "ambient": "n_samples",
}
#: How parameters are written in text and in headings, if not by their names.
SYMBOLS = {"c_e": ("C_E", "C_E [px]")}
_SHOWN = (
    "passes wanted metric error rel_l1 rel_l1_reflected interval outcome reached ray_reduction"
    " samples groups seconds seconds_exact wall_s exact_is_cheaper message"
)


@dataclass(frozen=True, slots=True)
class Pilot:
    """What one value gave on the pilots' pixels: the error in the metric that was asked for.

    `also` has other parameters that were chosen with it; `wall_s` are seconds of a whole frame.
    """

    value: float
    error: float
    ray_reduction: float
    parameter: str = "c_e"
    also: dict[str, float] = field(default_factory=dict)
    wall_s: float = field(default=0.0, compare=False)

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
    also : dict of str to float
        Other parameters that were chosen with it: `c_finest` and `bright` of the quantized cache,
        or `pick` of the integrator.
    passes : int, optional
        With `passes=True`: so many passes of `vc.Progressive(..., visibility=found.visibility,
        integrator=found.integrator)`, with `use=found.use`.
    integrator, optional
        With `passes=True`: the one that was given, or that with the picks in `also`.
    wanted : {"error", "seconds"}
        What the target is of.
    metric : {"rel_l1_reflected", "rel_l1", "flip"}
        The metric that should have the target; `error` is its value.
    flip : float, optional
        The mean HDR-FLIP, if it is the metric.
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
    wall_s : float
        Seconds of the clock, of the same frame.
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
    wall_s: float = 0.0
    also: dict[str, float] = field(default_factory=dict)
    passes: int | None = None
    integrator: Any = None
    wanted: Literal["error", "seconds"] = "error"
    flip: float | None = None

    @property
    def error(self) -> float:
        """The error in `metric`."""
        if self.metric == "flip" and self.flip is not None:
            return self.flip
        return self.rel_l1 if self.metric == "rel_l1" else self.rel_l1_reflected

    @property
    def is_exact(self) -> bool:
        """Whether exact visibility was chosen."""
        return isinstance(self.visibility, Exact)

    @property
    def exact_is_cheaper(self) -> bool:
        """Whether an exact frame took less CPU time."""
        return self.seconds_exact < self.seconds

    @property
    def c_e(self) -> float:
        """The value, if C_E was searched."""
        return _c_e(self)

    @property
    def outcome(self) -> Literal["reached", "within noise", "missed"]:
        """Whether pixels that no pilot saw confirm the target.

        "reached": the upper end of the interval is at most the target. "within noise": the interval
        contains the target, and the error is at most 30 % above it. Of a time: it is at most 10 %
        above, or missed.
        """
        if self.wanted == "seconds":
            return "reached" if self.wall_s <= self.target * LATE else "missed"
        if self.interval[1] <= self.target:
            return "reached"
        near = self.error <= self.target * TOLERANCE and self.interval[0] <= self.target
        return "within noise" if near else "missed"

    @property
    def reached(self) -> bool:
        """Whether the outcome is "reached"."""
        return self.outcome == "reached"

    @property
    def message(self) -> str:
        """Why the target is not confirmed, and what limits the error; empty if it is near.

        Then, if it is so, that an exact frame is cheaper, with both times.
        """
        texts = [self._off_target(), self._cost()]
        return " ".join(text for text in texts if text)

    def _off_target(self) -> str:
        if self.wanted == "seconds" or self.passes is not None:
            return self._of_time()
        low, high = self.target / TOLERANCE, self.target * TOLERANCE
        near = min(self._mine, key=lambda p: abs(p.value - self.value))
        if self.outcome == "missed":
            text = self._above() if near.error > high else self._not_confirmed(near)
            return text + self._limits()
        if self.error < low:
            return self._below(near) if near.error < low else self._not_confirmed(near)
        return self._within_noise() if self.outcome == "within noise" else ""

    def _within_noise(self) -> str:
        low, high = self.interval
        return (
            f"{self.metric} {self.target:.3g} is reached within noise: the error is"
            f" {self.error:.3g}, its 95 % interval {low:.3g} to {high:.3g}."
        )

    @property
    def _mine(self) -> list[Pilot]:
        """The pilots with the other parameters that were chosen."""
        return [p for p in self.pilots if p.also == self.also] or list(self.pilots)

    def _of_time(self) -> str:
        if self.passes is not None:
            if self.outcome != "missed":
                return "" if self.reached else self._within_noise()
            return (
                f"{self.passes} passes are as many as there may be: {self.metric} {self.error:.3g}"
                f" and {self.wall_s:.3g} s."
            )
        if self.is_exact:
            return f"An exact frame takes {self.wall_s:.3g} s, which fits: it has no error."
        if self.reached:
            return ""
        return (
            f"No {self._symbol} that was tried takes {self.target:.3g} s: the frame with"
            f" {_text(self.value)} takes {self.wall_s:.3g} s."
        )

    def _not_confirmed(self, near: Pilot) -> str:
        """The pilots had the target, the other pixels have more or less."""
        low, high = self.interval
        return (
            f"{self.metric} {self.target:.3g} is not confirmed: pilots had {near.error:.3g} at"
            f" {self._symbol} = {_text(self.value)}, pixels that they did not see have"
            f" {self.error:.3g} [{low:.3g}, {high:.3g}]."
        )

    def _above(self) -> str:
        least = min(self._mine, key=lambda p: p.error)
        return (
            f"No {self._symbol} reaches {self.metric} {self.target:.3g}: the smallest error found"
            f" is {least.error:.3g}, at {_text(least.value)}."
        )

    def _below(self, near: Pilot) -> str:
        """All tried values have smaller errors, or the error jumps over the target."""
        above = [p for p in self._mine if p.error > self.target]
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
        if not self.exact_is_cheaper or self.is_exact or self.passes is not None:
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
            **self.also,
            **light_cells,
            "visibility": repr(self.visibility),
            "use": in_words(self.use),
            **{name: getattr(self, name) for name in _SHOWN.split()},
            "pilots": [
                {p.parameter: p.value, **p.also, "error": p.error, "ray_reduction": p.ray_reduction}
                for p in self.pilots
            ],
        }

    @property
    def _way(self) -> str:
        """How passes see."""
        if "pick" in self.also:
            return "of picks"
        return "exact" if self.is_exact else "corrected"

    @property
    def c_l(self) -> float | None:
        """Size of the light cells of the quantized cache, which `tune` may have chosen too."""
        chosen = isinstance(self.visibility, Aqvc) and self.parameter == "c_e"
        return self.visibility.resolved()["c_l"] if chosen else None

    def __repr__(self) -> str:
        low, high = self.interval
        light_cells = "" if self.c_l is None else f" c_l={self.c_l:.3g},"
        others = "".join(f" {name}={value:.3g}," for name, value in self.also.items())
        unit = " s" if self.wanted == "seconds" else ""
        chosen = f"{self.parameter}={_text(self.value)}"
        if self.passes is not None:
            chosen = f"{self.passes} passes {self._way}"
        elif self.is_exact:
            chosen = "exact"
        return (
            f"Tuned({chosen},{others}{light_cells}"
            f" {self.metric}={self.error:.3g} [{low:.3g}, {high:.3g}],"
            f" target={self.target:.3g}{unit}, ray_reduction={self.ray_reduction:.3g})"
        )

    def __str__(self) -> str:
        return f"{self!r}\n{self.message}" if self.message else repr(self)

    def _repr_html_(self) -> str:
        names = list(dict.fromkeys(name for p in self.pilots for name in p.also))
        rows = "".join(
            f"<tr><td>{_text(p.value)}</td>{_cells(p, names)}<td>{p.error:.3g}</td>"
            f"<td>{p.ray_reduction:.3g}</td></tr>"
            for p in self.pilots
        )
        name = html.escape(SYMBOLS.get(self.parameter, (self.parameter,))[-1])
        more = "".join(f"<th>{html.escape(n)}</th>" for n in names)
        head = f"<tr><th>{name}</th>{more}<th>{self.metric}</th><th>queries per ray</th></tr>"
        said = f"<p>{html.escape(self.message)}</p>" if self.message else ""
        return f"<table><caption>{html.escape(repr(self))}</caption>{head}{rows}</table>{said}"


def _c_e(found: Pilot | Tuned) -> float:
    if found.parameter != "c_e":
        raise AttributeError(f"{found.parameter} was searched, not c_e: see value")
    return found.value


def _cells(pilot: Pilot, names: list[str]) -> str:
    """Cells of the other parameters; empty where the cache's own stayed."""
    return "".join(
        f"<td>{pilot.also[n]:.3g}</td>" if n in pilot.also else "<td></td>" for n in names
    )


def _text(value: float) -> str:
    """Whole numbers in full, others with three digits."""
    return str(value) if isinstance(value, int) else f"{value:.3g}"
