"""What to try when a picture is not close to the exact one, or is biased."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.metrics import Comparable
from viscache.testing.limits import Limit

#: A change of the picture explains the difference if it leaves less than this share of it.
EXPLAINED = 0.25
#: What to do about the error of a cache, by its name.
CACHES = {
    "Aqvc": "a smaller c_e (now {c_e}) or c_finest (now {c_finest}) has less error;"
    " vc.tune(scene, integrator, rel_l1=...) finds one",
    "ShadowMap": "a higher resolution (now {resolution}) has less error",
    "VisMaps": 'use="correct", their default, has no bias',
    "NeePlusPlus": "its error is noise, which falls with spp; vc.testing.assert_unbiased tests its"
    " mean",
    "Unoccluded": "it leaves all shadows out",
}


#: What a frame and its exact frame have in common, besides the settings that `_differing` names.
COMMON = ("scene_hash", "integrator", "size", "spp", "seed", "first_sample", "passes", "camera")


def is_paired(frame: Comparable, exact: Comparable) -> bool:
    """Whether both are frames whose difference is the error of visibility alone."""
    sides = [getattr(side, "parameters", {}) for side in (frame, exact)]
    return all("visibility" in side for side in sides) and not _differing(*sides)


def _differing(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[str]:
    """What two frames should have in common and do not, with both values if they are short."""
    found = []
    for name in COMMON:
        ours, theirs = a.get(name), b.get(name)
        if ours != theirs:
            short = not any(isinstance(v, (dict, list)) for v in (ours, theirs))
            values = f" ({ours}, exact {theirs})" if short and name != "scene_hash" else ""
            found.append(name.removesuffix("_hash") + values)
    return found


def unlike(frame: Comparable, exact: Comparable) -> list[str]:
    """Reasons why the reference does not fit; empty if it seems to."""
    a, b = (getattr(side, "parameters", {}) for side in (frame, exact))
    if "visibility" in a and "visibility" in b:
        names = _differing(a, b)
        why = "the difference of frames is the error of visibility only if all of this is equal"
        return [f"the frames differ in {', '.join(names)}; {why}"] if names else []
    return _transformed(*(np.asarray(getattr(p, "image", p), np.float64) for p in (frame, exact)))


def _transformed(a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> list[str]:
    """Whether a simple change of the picture explains most of the difference."""
    scale = float((a * b).sum() / max((a * a).sum(), 1e-300))
    changes = {
        f"the picture is 1/{scale:.4g} of the exact one: is its exposure or unit another?": a
        * scale,
        "the picture is upside down": a[::-1],
        "the picture is mirrored": a[:, ::-1],
    }
    if a.ndim == 3 and a.shape[2] == 3:
        changes["red and blue of the picture are swapped"] = a[:, :, ::-1]
    off = np.abs(a - b).sum()
    return [text for text, c in changes.items() if np.abs(c - b).sum() < EXPLAINED * off][:1]


def what_to_try(frame: Comparable, exact: Comparable, missed: list[Limit]) -> list[str]:
    """Advice by the settings of the frame."""
    made: Mapping[str, Any] = getattr(frame, "parameters", {})
    chosen = made.get("visibility")
    if not isinstance(chosen, Mapping):
        return []
    tips = [f"the frame warns: {text}" for text in getattr(frame, "warnings", [])]
    use = made.get("use")
    use = use.get("name") if isinstance(use, Mapping) else use
    if use == "correct":
        tips.append(
            "corrected frames err by noise: more spp, vc.Correct(share=...) or vc.Progressive"
            " have less; vc.testing.assert_unbiased tests their mean"
        )
    elif chosen.get("name") in CACHES:
        words = {n: f"{v:g}" if isinstance(v, float) else v for n, v in chosen.items()}
        tips.append(CACHES[str(chosen["name"])].format_map(words))
    if chosen.get("name") == "Aqvc" and use != "correct":
        tips.append('vc.render(..., audit="pixels").audit.groups tells which lights err')
        if any(limit.metric == "energy" for limit in missed):
            tips.append('use="correct" has no bias of the energy')
    if any(limit.metric == "rel_l1_reflected" for limit in missed) and "visibility" not in getattr(
        exact, "parameters", {}
    ):
        tips.append("rel_l1_reflected takes frames, or files that Frame.save wrote")
    return tips
