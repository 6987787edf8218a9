"""Pictures as the page carries them: half floats in units of white, told apart and deflated.

The page has a picture's linear values, not only its look, so that exposure, differences and the
read-out of a pixel are made there. A value's *code* is its half float's bits as a signed number:
equal steps are equal ratios (2^-10 of a power of two), and codes order as values do. A reference
is kept as steps from pixel to pixel, a setting's picture as steps from its reference, which are
mostly 0. `page/pictures.js` is the inverse.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import metrics

#: Widest picture; wider frames are shown as means over pixels.
MAX_WIDTH_PX = 640
#: Codes of this many pixels in all settings are kept exactly; beyond, steps from the reference are
#: rounded to a multiple of `COARSE_STEP` codes (0.8 % to 1.6 %), to keep the file mailable.
MOST_EXACT_PIXELS = 24 * 640 * 400
COARSE_STEP = 16
#: The code of what is no number; the page shows it in magenta.
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
    """A reference: each row's first pixel, then steps to the right."""
    return _pack(np.diff(reference, axis=1, prepend=0))


def pack_difference(picture: Codes, reference: Codes, step: int = 1) -> str:
    """A picture as its codes' steps from the reference's, in multiples of `step`."""
    delta = picture - reference
    return _pack(np.sign(delta) * ((np.abs(delta) + step // 2) // step))


def pack_map(values: FloatImage) -> str:
    """An (H, W) map of [0, 1] in 255 steps."""
    return _deflated(np.round(255.0 * np.clip(values, 0.0, 1.0)).astype(np.uint8))


def flip_map(
    image: FloatImage, reference: FloatImage, width: int = MAX_WIDTH_PX
) -> dict[str, Any] | None:
    """HDR-FLIP's packed map and its mean, as `metrics.flip` has it; None where it is undefined."""
    if not (np.isfinite(image).all() and np.isfinite(reference).all()):
        return None
    found = metrics.flip_map(image.astype(np.float64), reference.astype(np.float64))
    if found is None:
        return None
    return {"map": pack_map(shrunk(found[0][:, :, None], width)[:, :, 0]), "mean": found[1]}


def shrunk(image: FloatImage, max_width: int = MAX_WIDTH_PX) -> FloatImage:
    """(H, W, C) no wider than `max_width`: means over the pixels each new one covers."""
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
    """256 colours of each scale, RGB: told apart by colour-blind readers too.

    "signed" runs from blue over white to red and is symmetric about its middle in lightness;
    "flip" is FLIP's magma; "error" is cividis.
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

    Channels change alike: all but the first are kept as their difference from the one before.
    Modulo 2^16, the sign in the lowest bit, so small steps are small numbers.
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
