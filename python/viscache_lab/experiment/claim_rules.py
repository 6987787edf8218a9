"""How the words or the number that a paper prints become the interval where its claim is found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

#: Rule to what it says.
RULES = {
    "at_least": "A printed advantage: the printed value or more.",
    "at_most": "A printed bound or advantage where less is better: the printed value or less.",
    "about": "Any other printed value, and values that are equal: within a tenth.",
    "exact": "Counts and identities: this value alone.",
    "computed": "What an equation gives, to the digits that are written.",
    "more": 'A comparison without a number, "rises": no less than on the other side.',
    "less": 'A comparison without a number, "falls": no more than on the other side.',
    "much_more": 'A comparison with "much", "distinct" or the like: twice or more.',
    "much_less": 'A comparison with "much", "significantly" or the like: half or less.',
    "little_gain": '"Not motivated", "no gain" of a larger effort: less than a factor of two.',
    "none": '"No" gain, "stays": a ratio of at most 1.1.',
    "nearly_all": '"Close to 1", "near linear": nine tenths or more.',
    "nearly_none": '"Almost entirely eliminates", "rarely": a tenth or less.',
    "some": '"Only some": between a hundredth and 99 hundredths.',
    "most": "What is alike mostly falls together: half or more.",
    "words": "A quality in words alone: a limit of ours, with its reason.",
}
#: Rule to its interval: both ends, or a function of the printed number or numbers.
_INTERVALS: dict[str, tuple[float, float] | Callable[..., tuple[float, float]]] = {
    "at_least": lambda printed: (printed, math.inf),
    "at_most": lambda printed: (0.0, printed),
    "about": lambda low, high=None: (0.9 * low, 1.1 * (low if high is None else high)),
    "exact": lambda printed: (printed, printed),
    "computed": lambda low, high: (low, high),
    "more": lambda other=1.0: (other, math.inf),
    "less": (0.0, 1.0),
    "much_more": (2.0, math.inf),
    "much_less": (0.0, 0.5),
    "little_gain": (0.5, math.inf),
    "none": (0.0, 1.1),
    "nearly_all": (0.9, 1.0),
    "nearly_none": (0.0, 0.1),
    "some": (0.01, 0.99),
    "most": (0.5, 1.0),
    "words": lambda low, high: (low, high),
}


@dataclass(frozen=True, slots=True)
class Claim:
    """Where a paper's claim is found, both ends included, and the rule that says so."""

    low: float
    high: float
    rule: str
    because: str = ""
    """The reason of a limit for words."""

    @classmethod
    def by(cls, rule: str, *numbers: float, because: str = "") -> Claim:
        """The claim by one of `RULES`, of the printed number or the ends of an interval."""
        found = _INTERVALS[rule]
        low, high = found(*numbers) if callable(found) else found
        return cls(low, high, rule, because)


def interval(low: float, high: float) -> str:
    """An interval in words."""
    if low == high:
        return f"{low:g}"
    if high == math.inf:
        return f"≥ {low:.3g}"
    return f"≤ {high:.3g}" if low in (0, -math.inf) else f"{low:.5g} to {high:.5g}"
