"""What the report's page does with packed pictures, in NumPy."""

import base64
import json
import re
import zlib

import numpy as np


def model(page: str):
    """The data that a page carries."""
    return dict(json.loads(re.search(r'application/json">(.*?)</script>', page, re.S)[1]))


def unpack(text: str, width: int) -> np.ndarray:
    """(H, W, 3) int16 steps."""
    raw = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).astype(np.int64)
    low, high = raw.reshape(2, 3, -1, width)
    folded = low + 256 * high
    steps = np.where(folded & 1, -(folded >> 1) - 1, folded >> 1)
    return np.cumsum(np.moveaxis(steps, 0, 2), axis=2).astype(np.int16)


def values(codes: np.ndarray) -> np.ndarray:
    """Half floats of codes, as float64."""
    bits = np.abs(codes.astype(np.int32)).astype(np.uint16)
    return np.sign(codes) * np.where(codes == 0, 0.0, bits.view(np.float16).astype(np.float64))


def reference(data, key: str) -> np.ndarray:
    """Codes of a reference."""
    steps = unpack(data["pictures"][key], data["frame"]["width"])
    return np.cumsum(steps, axis=1, dtype=np.int64).astype(np.int16)


def picture(data, setting) -> np.ndarray:
    """Codes of a setting's picture."""
    steps = unpack(setting["difference"], data["frame"]["width"]).astype(np.int64)
    base = reference(data, setting["reference"]).astype(np.int64)
    return (base + data["step"] * steps).astype(np.int16)


def flip(data, setting) -> np.ndarray:
    """(H, W) FLIP map in [0, 1]."""
    raw = zlib.decompress(base64.b64decode(setting["flip"]["map"]))
    return np.frombuffer(raw, np.uint8).reshape(-1, data["frame"]["width"]) / 255


def colors(data, scale: str) -> np.ndarray:
    """(256, 3) colours of a scale."""
    raw = base64.b64decode(data["colors"][scale])
    return np.frombuffer(raw, np.uint8).reshape(256, 3).astype(int)
