"""Two verdicts on a figure: whether the paper's claims are found, and whether our bands hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from viscache_lab.experiment.full_run import CLAIMING

Result: TypeAlias = Mapping[str, Any]
#: Words for none, all, and some or none of the rows. Some claims are judged at full size only.
CLAIM = ("not stated", "found", "not found")
QUICK_CLAIM = ("not judged", "found", "not found")
EXPECTATION = ("no band", "holds", "does not hold")


def verdicts(rows: Sequence[Result], *, quick: bool, figure: str) -> dict[str, Any]:
    """Claim and expectation of a figure, by the rows of `Row.as_dict`: verdict, yes and all.

    Without a row that can judge it, a claim is "not stated", or "not judged" if the run is quick
    and full runs judge one.
    """
    words = QUICK_CLAIM if quick and figure in CLAIMING else CLAIM
    return {
        "claim": _counted([row.get("found") for row in rows], words),
        "expectation": _counted([row["holds"] for row in rows], EXPECTATION),
    }


def _counted(answers: Iterable[bool | None], words: tuple[str, str, str]) -> dict[str, Any]:
    known = [answer for answer in answers if answer is not None]
    verdict = words[0] if not known else words[1] if all(known) else words[2]
    return {"verdict": verdict, "yes": sum(known), "all": len(known)}


def claim_of(result: Result) -> str:
    """The verdict on the claim of a figure's result."""
    both = verdicts(result["rows"], quick=result["quick"], figure=result["figure"])
    return str(both["claim"]["verdict"])


def sentence(rows: Sequence[Result], *, quick: bool, figure: str) -> str:
    """Both verdicts in one line; those of a quick run say so, as claims are about full sizes."""
    found = verdicts(rows, quick=quick, figure=figure)
    words = [
        f"{name}: {part['verdict']}" + (f" ({part['yes']} of {part['all']})" if part["all"] else "")
        for name, part in zip(("The paper's claim", "Our expectation"), found.values(), strict=True)
    ]
    return ". ".join(words) + (", at quick sizes." if quick else ".")


def claims_not_found(results: Iterable[Result]) -> list[dict[str, Any]]:
    """The rows of all figures whose measured value is outside the paper's claim."""
    return [
        {"figure": result["figure"], **row}
        for result in results
        for row in result["rows"]
        if row.get("found") is False
    ]
