"""The error of an assertion about pictures, which can show them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viscache import report
from viscache.metrics import Comparable


class PictureError(AssertionError):
    """An assertion about pictures does not hold.

    Attributes
    ----------
    picture, reference : Frame or array, or None
        What the page shows; None if they cannot be compared.
    numbers : dict of str to str
        What was measured, for the head of the page.
    """

    __module__ = "viscache.testing"  # where users find it, and what pytest prints

    def __init__(
        self,
        message: str,
        picture: Comparable | None = None,
        reference: Comparable | None = None,
        numbers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(message)
        self.picture, self.reference = picture, reference
        self.numbers = dict(numbers or {})

    def write(self, path: str | os.PathLike[str], *, title: str = "picture") -> Path | None:
        """Write a page with both pictures, their difference and the numbers.

        Parameters
        ----------
        path : path
            The HTML file, which needs no other.
        title : str
            Name of the picture on the page.

        Returns
        -------
        Path or None
            The file; None if the pictures cannot be compared.
        """
        if self.picture is None or self.reference is None:
            return None
        return report.write_difference(
            self.picture,
            self.reference,
            path,
            name=title,
            reference_name="exact",
            facts=self.numbers,
        )


def told(frame: Comparable) -> str:
    """What a picture is, in a few words."""
    made: Mapping[str, Any] = getattr(frame, "parameters", {})
    shape = "x".join(str(n) for n in np.shape(getattr(frame, "image", frame))[1::-1])
    if "visibility" not in made:
        return f"{shape} pixels of unknown origin"
    words = [f"{shape} pixels", str(made.get("scene"))]
    words += [name for role in ("integrator", "visibility") if (name := _name(made.get(role)))]
    if words[-1] != "Exact":
        words.append(f'use="{_name(made.get("use"))}"')
    counts = ("spp", "seed", "first_sample", "passes")
    return ", ".join([*words, *(f"{k} {made[k]}" for k in counts if made.get(k) is not None)])


def _name(setting: Any) -> str:
    """Of a setting in the parameters of a frame."""
    return str(setting["name"] if isinstance(setting, Mapping) else setting)


def lines(head: str, rows: Mapping[str, str], advice: list[str]) -> str:
    """A message: what failed, numbers in columns, and what to try."""
    width = max((len(name) for name in rows), default=0)
    body = [f"  {name:<{width}}  {text}" for name, text in rows.items()]
    tips = [f"  - {tip}" for tip in advice]
    return "\n".join([head, *body, *(["Try:", *tips] if tips else [])])
