"""Emitted light that a frame sees directly, and the light on surfaces that is left without it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def seen_emitters(frame: Any) -> npt.NDArray[np.float32] | None:
    """The emitted light that the camera sees, directly or through mirrors and glass.

    Parameters
    ----------
    frame : Frame or anything else

    Returns
    -------
    (H, W, C) float32, or None
        The layer "seen_emitters" of bidirectional path tracing, and the layer "emitted" of the
        other integrators. None of arrays and of files without such a layer.
    """
    layers = getattr(frame, "layers", {})
    if "seen_emitters" in layers:
        return np.asarray(layers["seen_emitters"])
    # With "connection" or "camera", "emitted" also has light that paths found after surfaces
    if "emitted" not in layers or not {"connection", "camera"}.isdisjoint(layers):
        return None
    return np.asarray(layers["emitted"])


def light_on_surfaces(frame: Any) -> npt.NDArray[np.float64] | None:
    """The colour layer without `seen_emitters`, (H, W, C); None if they are not known."""
    emitted = seen_emitters(frame)
    if emitted is None or emitted.shape != frame.image.shape:
        return None
    return np.asarray(frame.image, np.float64) - emitted
