"""FLIP maps of a sweep's frames, kept in its folder: each takes seconds, and is measured once.

A sweep with the metric "flip" keeps the map of every first repeat, so that a report does not
measure it again. The name of a file is made of the contents of both frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from viscache import metrics
from viscache.base.files import inside
from viscache.base.formats import DIGEST, NUMBER, ArrayField, Format, FormatError

if TYPE_CHECKING:
    from viscache.frame import Frame

FORMAT = Format(
    kind="a FLIP map of a sweep",
    version=1,
    fields={"frame": DIGEST, "reference": DIGEST, "mean": NUMBER},
    arrays={"errors": ArrayField("u1", ("H", "W"))},
)


@dataclass(frozen=True, slots=True)
class FlipMap:
    """HDR-FLIP of every pixel, (H, W) in 255ths, and its mean, which is not rounded."""

    errors: npt.NDArray[np.uint8]
    mean: float


def flip_map_of(frame: Frame, reference: Frame, directory: Path | None) -> FlipMap | None:
    """The map of a frame, measured unless it is kept in the directory; None if it is undefined."""
    known = kept(frame, reference, directory)
    if known is not None:
        return known
    sides = [np.asarray(f.image[:, :, :3], np.float64) for f in (frame, reference)]
    if not all(np.isfinite(side).all() for side in sides):
        return None
    found = metrics.flip_map(*sides)
    if found is None:
        return None
    made = FlipMap(np.round(255.0 * np.clip(found[0], 0.0, 1.0)).astype(np.uint8), found[1])
    if directory is not None:
        target = _file(directory, frame, reference)
        target.parent.mkdir(exist_ok=True)
        fields = {"frame": frame.sha256, "reference": reference.sha256, "mean": made.mean}
        FORMAT.write_npz(target, fields, {"errors": made.errors}, compressed=True)
    return made


def kept(frame: Frame, reference: Frame, directory: Path | None) -> FlipMap | None:
    """The map that is kept of a frame; None if there is none."""
    if directory is None or not (file := _file(directory, frame, reference)).exists():
        return None
    try:
        fields, arrays = FORMAT.read_npz(file)
    except (FormatError, OSError):
        return None  # measured again
    of_these = (fields["frame"], fields["reference"]) == (frame.sha256, reference.sha256)
    fits = of_these and arrays["errors"].shape == frame.image.shape[:2]
    return FlipMap(arrays["errors"], float(fields["mean"])) if fits else None


def _file(directory: Path, frame: Frame, reference: Frame) -> Path:
    return inside(directory, f"flip/{frame.sha256[:16]}-{reference.sha256[:16]}.npz")
