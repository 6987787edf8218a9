"""Two reports of `viscache doctor --extremes --json`, of two machines or two versions."""

from __future__ import annotations

import math
from typing import Any

#: Values that differ by more than this factor are told.
FACTOR = 2.0

#: Name of the check, what is different, its state or value in both reports.
Difference = tuple[str, str, Any, Any]


def differences(a: dict[str, Any], b: dict[str, Any]) -> list[Difference]:
    """Checks that one report alone has, that hold in one alone, or whose values are far apart."""
    first, second = ({check["name"]: check for check in r["checks"]} for r in (a, b))
    found: list[Difference] = []
    for name in [*first, *(n for n in second if n not in first)]:
        one, other = first.get(name), second.get(name)
        if one is None or other is None:
            found.append((name, "there", one is not None, other is not None))
        elif one["holds"] != other["holds"]:
            found.append((name, "holds", one["holds"], other["holds"]))
        elif _far(one["value"], other["value"]):
            found.append((name, "value", one["value"], other["value"]))
    return found


def _far(x: float | None, y: float | None) -> bool:
    """Whether two values differ by more than a factor; noise below 1e-9 does not count."""
    if x is None or y is None:
        return x is not y
    low, high = sorted((abs(x), abs(y)))
    return high > 1e-9 and (low == 0 or high / low > FACTOR or math.copysign(1, x * y) < 0)
