"""Flicker of cached frames along a camera's path (H8 of the quantized cache's claims)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import viscache as vc
from viscache.base import tonemap
from viscache.metrics.temporal import mean_temporal_variance, seen
from viscache_lab.experiment import Row
from viscache_lab.figures.aqvc_runs import Shot, presets
from viscache_lab.figures.aqvc_setups import SETUPS
from viscache_lab.figures.bands import aqvc as bands

#: C_E, and the number of frames of the path.
C_E = 16.0
FRAMES, QUICK_FRAMES = 32, 5
SIZE, QUICK_SIZE = (640, 400), (200, 125)
#: The camera moves from the first place to the second and looks at the living room's far corner.
PATH = ((-0.1, 1.65, 0.35), (-0.4, 1.6, 0.15))
TARGET, FOV_DEG = (-4.6, 0.85, -3.2), 56.0


def flicker_rows(quick: bool, size: tuple[int, int] | None) -> Iterator[Row]:
    """H8: refinement reduces flicker."""
    scene = SETUPS["delta"].scene(quick)
    pixels = size or (QUICK_SIZE if quick else SIZE)
    shots = [
        Shot(scene=scene, integrator=vc.Direct(), size=pixels, camera=camera)
        for camera in cameras(QUICK_FRAMES if quick else FRAMES)
    ]
    frames = [shot.frame() for shot in shots]
    exposure = tonemap.auto_exposure(frames[0].image, 95.0)
    exact = [seen(frame, exposure) for frame in frames]
    for preset in ("default", "paper"):
        found = {
            refinement: mean_temporal_variance(
                [
                    seen(shot.frame(presets(C_E, refinement=refinement)[preset]), exposure) - truth
                    for shot, truth in zip(shots, exact, strict=True)
                ]
            )
            for refinement in ("off", "on")
        }
        yield Row(
            f"H8 {preset}: temporal variance of the error, refinement over none",
            found["on"] / found["off"],
            band=bands.H8_FLICKER,
            note=f"deviation {np.sqrt(found['off']):.3f} to "
            f"{np.sqrt(found['on']):.3f} of white, {len(shots)} frames, "
            f"C_E {C_E:g}",
        )


def cameras(frames: int) -> list[vc.Camera]:
    """Views along the path."""
    start, end = (np.array(place) for place in PATH)
    return [
        vc.look_at((start + t * (end - start)).tolist(), TARGET, (0.0, 1.0, 0.0), FOV_DEG)
        for t in np.linspace(0, 1, frames)
    ]
