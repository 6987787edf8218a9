"""From scene-linear images to 8-bit images for display."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.real_numbers import real_array

FloatImage = npt.NDArray[np.floating[Any]]

#: Rec. 709 luminance weights of linear R, G, B.
LUMINANCE = (0.2126, 0.7152, 0.0722)


def luminance(image: FloatImage) -> npt.NDArray[np.float64]:
    """Rec. 709 luminance, shape (H, W) float64, of a linear image (H, W, 1) or (H, W, >= 3)."""
    pixels = real_array(image, "image").astype(np.float64, copy=False)
    if pixels.shape[2] < 3:
        return pixels[:, :, 0]
    return np.asarray(pixels[:, :, :3] @ np.asarray(LUMINANCE))


def srgb_curve(linear: FloatImage) -> npt.NDArray[np.float64]:
    """The sRGB transfer curve (IEC 61966-2-1) of values clipped to [0, 1]."""
    x = np.clip(real_array(linear, "linear").astype(np.float64), 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)


def auto_exposure(image: FloatImage, percentile: float = 99.0) -> float:
    """The factor that brings this percentile of the luminance to 1.

    If that percentile is 0, the factor brings the brightest pixel to 1. It is 1 for a black image.
    Non-finite pixels do not count.
    """
    values = luminance(image)
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 1.0
    white = float(np.percentile(values, percentile))
    if white <= 0.0:
        white = float(values.max())
    return 1.0 / white if white > 0.0 else 1.0


def display_exposure(image: FloatImage) -> float:
    """The exposure for display: `auto_exposure`, or more if most of the image would be dark.

    It is raised up to 8 times, until the median luminance is 0.1: for rooms with bright windows.
    """
    values = luminance(image)
    lit = values[np.isfinite(values) & (values > 0)]
    white = auto_exposure(image)
    if lit.size == 0:
        return white
    return float(np.clip(0.1 / np.median(lit), white, 8.0 * white))


def to_srgb8(image: FloatImage, exposure: float | None = None) -> npt.NDArray[np.uint8]:
    """Exposure, clip, sRGB curve: (H, W, 3) of 8 bits, with NaN in magenta.

    The image (H, W, C) is scene-linear: C = 1 is grey, of more the first three are R, G, B. The
    exposure is a factor before the curve; `display_exposure(image)` by default.
    """
    pixels = real_array(image, "image")
    if pixels.ndim != 3 or pixels.shape[2] in (0, 2):
        raise ValueError(f"image must have shape (H, W, 1) or (H, W, >= 3), got {pixels.shape}")
    factor = display_exposure(pixels) if exposure is None else float(exposure)
    rgb = np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels[:, :, :3]
    bad = np.isnan(rgb).any(axis=2)
    finite = np.nan_to_num(rgb.astype(np.float64), nan=0.0, posinf=np.inf, neginf=-np.inf)
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = np.nan_to_num(finite * factor, nan=0.0)
    out = np.round(srgb_curve(scaled) * 255.0).astype(np.uint8)
    out[bad] = (255, 0, 255)
    return out


def difference8(
    a: FloatImage, b: FloatImage, gain: float = 16.0, exposure: float | None = None
) -> npt.NDArray[np.uint8]:
    """The signed difference a - b around mid grey: 128 + 127·gain·(a - b)·exposure.

    Where a is brighter than the reference b, the result is brighter than grey. The exposure is
    `display_exposure(b)` by default. The shape is (H, W, 3) uint8.
    """
    delta = real_array(a, "a").astype(np.float64) - real_array(b, "b").astype(np.float64)
    if delta.shape[2] == 1:
        delta = np.repeat(delta, 3, axis=2)
    factor = display_exposure(b) if exposure is None else float(exposure)
    scaled = np.nan_to_num(delta[:, :, :3] * gain * factor, nan=1.0)
    return np.round(128.0 + 127.0 * np.clip(scaled, -1.0, 1.0)).astype(np.uint8)


def encode(
    pixels: npt.NDArray[np.uint8],
    *,
    kind: str = "png",
    max_width: int | None = None,
    effort: int = 6,
) -> bytes:
    """PNG or JPEG bytes of an (H, W, 3) uint8 picture, made no wider than `max_width`.

    `effort` in [0, 9] is zlib's level for PNG: 1 takes a third of the time of 6 and more bytes.
    """
    from PIL import Image

    picture = Image.fromarray(pixels)
    if max_width is not None and picture.width > max_width:
        height = max(1, round(picture.height * max_width / picture.width))
        picture = picture.resize((max_width, height), Image.Resampling.BOX)
    buffer = io.BytesIO()
    if kind == "png":
        picture.save(buffer, "PNG", compress_level=effort)
    elif kind == "jpeg":
        picture.save(buffer, "JPEG", quality=92, subsampling=0)
    else:
        raise ValueError(f"kind must be png or jpeg, got {kind}")
    return buffer.getvalue()
