"""A sky as environment light: blue above, haze at the horizon, ground below, a veiled sun."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

ROWS = 64
ZENITH, HORIZON, GROUND = (0.28, 0.42, 0.75), (0.85, 0.9, 0.95), (0.22, 0.2, 0.17)
SUN_COLOR = (170.0, 155.0, 130.0)
SUN_DEG = 4.0  # standard deviation of the sun's glow


def sky(sun: tuple[float, float, float]) -> npt.NDArray[np.float32]:
    """Lat-long radiance (64, 128, 3), y up; `sun` points to the sun.

    About half the light comes from the glow around the sun.
    """
    v = (np.arange(ROWS) + 0.5) / ROWS * np.pi
    u = (np.arange(2 * ROWS) + 0.5) / ROWS * np.pi
    y = np.cos(v)[:, None] + 0 * u
    direction = np.stack([np.sin(v)[:, None] * np.sin(u), y, -np.sin(v)[:, None] * np.cos(u)], -1)
    height = np.clip(y, 0, 1)[..., None] ** 0.5
    light = np.array(HORIZON) * (1 - height) + np.array(ZENITH) * height
    light = np.where(y[..., None] > 0, light, np.array(GROUND))
    angle = np.degrees(np.arccos(np.clip(direction @ _unit(sun), -1, 1)))
    glow = np.exp(-0.5 * (angle / SUN_DEG) ** 2)[..., None]
    return np.ascontiguousarray(light + glow * np.array(SUN_COLOR), dtype=np.float32)


def _unit(v: tuple[float, float, float]) -> npt.NDArray[np.float64]:
    out: npt.NDArray[np.float64] = np.asarray(v, float) / np.linalg.norm(v)
    return out
