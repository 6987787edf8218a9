"""The format of pictures in a page: half floats in units of white, delta-coded and deflated.

The page holds the linear values of a picture, so that exposure, differences and pixel values can be
computed there. The *code* of a value is the bits of its half float as a signed number: equal steps
are equal ratios (2^-10 of a power of two), and codes are ordered like values. A reference is stored
as steps from pixel to pixel, and the picture of a setting as steps from its reference, which are
mostly 0. `page/pictures.js` is the inverse.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import metrics

#: Maximum width; wider frames are shown as means over pixels.
MAX_WIDTH_PX = 640
#: Up to this many pixels over all settings, codes are stored exactly. Beyond that, steps from the
#: reference are rounded to a multiple of `COARSE_STEP` codes (0.8 % to 1.6 %), to keep the file
#: small enough for mail.
MOST_EXACT_PIXELS = 24 * 640 * 400
COARSE_STEP = 16
#: The code of non-finite values; the page shows them in magenta.
NAN_CODE = 0x7E00

Codes = npt.NDArray[np.int32]
FloatImage = npt.NDArray[np.floating[Any]]


def codes(image: FloatImage, exposure: float) -> Codes:
    """Half-float codes of `exposure` times the values; non-finite ones are `NAN_CODE`."""
    scaled = np.asarray(image, dtype=np.float64) * exposure
    finite = np.isfinite(scaled)
    half = np.clip(np.where(finite, scaled, 0.0), -65504.0, 65504.0).astype(np.float16)
    bits = half.view(np.uint16).astype(np.int32)
    magnitude = bits & 0x7FFF
    return np.where(finite, np.where(bits >= 0x8000, -magnitude, magnitude), NAN_CODE)


def pack_reference(reference: Codes) -> str:
    """Packs a reference: the first pixel of each row, then steps to the right."""
    return _pack(np.diff(reference, axis=1, prepend=0))


def pack_difference(picture: Codes, reference: Codes, step: int = 1) -> str:
    """Packs a picture as steps of its codes from those of the reference, in multiples of `step`."""
    delta = picture - reference
    return _pack(np.sign(delta) * ((np.abs(delta) + step // 2) // step))


def pack_map(values: FloatImage) -> str:
    """Packs an (H, W) map with values in [0, 1] in 255 steps."""
    return _deflated(np.round(255.0 * np.clip(values, 0.0, 1.0)).astype(np.uint8))


def flip_map(
    image: FloatImage, reference: FloatImage, width: int = MAX_WIDTH_PX
) -> dict[str, Any] | None:
    """Packed HDR-FLIP map and its mean, as in `metrics.flip`; None if it is undefined."""
    if not (np.isfinite(image).all() and np.isfinite(reference).all()):
        return None
    found = metrics.flip_map(image.astype(np.float64), reference.astype(np.float64))
    if found is None:
        return None
    return pack_flip(found[0], found[1], width)


def pack_flip(errors: FloatImage, mean: float, width: int = MAX_WIDTH_PX) -> dict[str, Any]:
    """A FLIP map, (H, W) in [0, 1], and its mean as the page takes them."""
    return {"map": pack_map(shrunk(errors[:, :, None], width)[:, :, 0]), "mean": mean}


def shrunk(image: FloatImage, max_width: int = MAX_WIDTH_PX) -> FloatImage:
    """(H, W, C) at most `max_width` wide: each pixel is the mean of the pixels that it covers."""
    from PIL import Image

    height, width, channels = image.shape
    if width <= max_width:
        return image
    size = (max_width, max(1, round(height * max_width / width)))
    planes = (Image.fromarray(np.asarray(image[:, :, c], np.float32)) for c in range(channels))
    return np.stack([np.asarray(p.resize(size, Image.Resampling.BOX)) for p in planes], axis=2)


def three_channels(image: FloatImage) -> FloatImage:
    """(H, W, 3): grey is repeated, which costs next to nothing once packed."""
    return np.repeat(image[:, :, :1], 3, axis=2) if image.shape[2] < 3 else image[:, :, :3]


def scales() -> dict[str, str]:
    """256 RGB colours of each scale, distinguishable by colour-blind readers.

    "signed" runs from blue through white to red, with lightness symmetric about its middle; "flip"
    is FLIP's magma; "error" is cividis.
    """
    names = {"signed": "RdBu_r", "flip": "magma", "error": "cividis"}
    return {key: _base64(scale_colors(name).tobytes()) for key, name in names.items()}


def scale_colors(name: str) -> npt.NDArray[np.uint8]:
    """(256, 3) colours of a matplotlib scale."""
    import matplotlib

    rgba = matplotlib.colormaps[name](np.linspace(0, 1, 256))
    return np.round(255 * rgba[:, :3]).astype(np.uint8)


def _pack(steps: npt.NDArray[np.integer[Any]]) -> str:
    """Plane by plane, low bytes before high bytes.

    Channels change together, so all except the first are stored as the difference from the previous
    one, modulo 2^16. The sign is in the lowest bit, so that small steps are small numbers.
    """
    alike = np.diff(steps, axis=2, prepend=0)
    wrapped = ((alike + 0x8000) & 0xFFFF) - 0x8000
    folded = ((wrapped << 1) ^ (wrapped >> 15)).astype(np.uint16)
    planes = np.moveaxis(folded, 2, 0)
    return _deflated(np.stack([planes & 0xFF, planes >> 8]).astype(np.uint8))


def _deflated(array: npt.NDArray[np.uint8]) -> str:
    return _base64(zlib.compress(array.tobytes(), 9))


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
