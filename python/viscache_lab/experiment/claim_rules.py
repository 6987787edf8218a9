"""How the words or the number that a paper prints become the interval where its claim is found."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: Rule to what it says. `Claim` has a method for each, which makes the interval.
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


def _fixed(rule: str, low: float, high: float) -> staticmethod[[], Claim]:
    """A rule that needs no printed number."""
    return staticmethod(lambda: Claim(low, high, rule))


@dataclass(frozen=True, slots=True)
class Claim:
    """Where a paper's claim is found, both ends included, and the rule that says so."""

    low: float
    high: float
    rule: str
    because: str = ""  # the reason of a limit for words

    less = _fixed("less", 0.0, 1.0)
    much_more = _fixed("much_more", 2.0, math.inf)
    much_less = _fixed("much_less", 0.0, 0.5)
    little_gain = _fixed("little_gain", 0.5, math.inf)
    none = _fixed("none", 0.0, 1.1)
    nearly_all = _fixed("nearly_all", 0.9, 1.0)
    nearly_none = _fixed("nearly_none", 0.0, 0.1)
    some = _fixed("some", 0.01, 0.99)
    most = _fixed("most", 0.5, 1.0)

    @classmethod
    def at_least(cls, printed: float) -> Claim:
        return cls(printed, math.inf, "at_least")

    @classmethod
    def at_most(cls, printed: float) -> Claim:
        return cls(0.0, printed, "at_most")

    @classmethod
    def about(cls, printed: float, to: float | None = None) -> Claim:
        """Within a tenth of the printed value, or of the ends of a printed interval."""
        return cls(0.9 * printed, 1.1 * (printed if to is None else to), "about")

    @classmethod
    def exact(cls, printed: float) -> Claim:
        return cls(printed, printed, "exact")

    @classmethod
    def computed(cls, low: float, high: float) -> Claim:
        """What an equation gives, between its rounded ends."""
        return cls(low, high, "computed")

    @classmethod
    def more(cls, other: float = 1.0) -> Claim:
        """No less than on the other side; of a ratio this is 1."""
        return cls(other, math.inf, "more")

    @classmethod
    def words(cls, low: float, high: float, *, because: str) -> Claim:
        """Our limit for a quality that the paper has in words, and its reason."""
        return cls(low, high, "words", because)


def interval(low: float, high: float) -> str:
    """An interval in words."""
    if low == high:
        return f"{low:g}"
    if high == math.inf:
        return f"≥ {low:.3g}"
    return f"≤ {high:.3g}" if low in (0, -math.inf) else f"{low:.5g} to {high:.5g}"
