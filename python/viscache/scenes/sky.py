"""Skies as environment light: blue above, haze at the horizon, ground below, and light sources."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

ROWS = 64
ZENITH, HORIZON, GROUND = (0.28, 0.42, 0.75), (0.85, 0.9, 0.95), (0.22, 0.2, 0.17)
SUN_COLOR = (170.0, 155.0, 130.0)
SUN_DEG = 4.0  # standard deviation of the sun's glow

Array = npt.NDArray[np.float64]
Three = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Disc:
    """A light at infinity: a disc of constant radiance."""

    direction: Three
    """Direction to its centre, of any length."""
    radius_deg: float
    radiance: Three


def sky(sun: Three) -> npt.NDArray[np.float32]:
    """Lat-long radiance (64, 128, 3), y up; `sun` points to the sun.

    About half the light comes from the glow around the sun.
    """
    direction = _directions(ROWS)
    glow = np.exp(-0.5 * (_degrees_from(direction, sun) / SUN_DEG) ** 2)[..., None]
    light = _background(direction) + glow * np.array(SUN_COLOR)
    return np.ascontiguousarray(light, dtype=np.float32)


def sky_with(discs: Sequence[Disc], rows: int) -> npt.NDArray[np.float32]:
    """Lat-long radiance (rows, 2·rows, 3), y up: the same sky with discs instead of the sun.

    Edges of discs fall off within one pixel.
    """
    direction = _directions(rows)
    light, pixel_deg = _background(direction), 180.0 / rows
    for disc in discs:
        inside = (disc.radius_deg - _degrees_from(direction, disc.direction)) / pixel_deg
        light = light + np.clip(inside + 0.5, 0, 1)[..., None] * np.array(disc.radiance)
    return np.ascontiguousarray(light, dtype=np.float32)


def _directions(rows: int) -> Array:
    """Directions (rows, 2·rows, 3) of the pixels of a lat-long image."""
    v = (np.arange(rows) + 0.5) / rows * np.pi
    u = (np.arange(2 * rows) + 0.5) / rows * np.pi
    y = np.cos(v)[:, None] + 0 * u
    return np.stack([np.sin(v)[:, None] * np.sin(u), y, -np.sin(v)[:, None] * np.cos(u)], -1)


def _background(direction: Array) -> Array:
    y = direction[..., 1]
    height = np.clip(y, 0, 1)[..., None] ** 0.5
    light = np.array(HORIZON) * (1 - height) + np.array(ZENITH) * height
    return np.where(y[..., None] > 0, light, np.array(GROUND))


def _degrees_from(direction: Array, middle: Three) -> Array:
    unit = np.asarray(middle, float) / np.linalg.norm(middle)
    angle: Array = np.degrees(np.arccos(np.clip(direction @ unit, -1, 1)))
    return angle
