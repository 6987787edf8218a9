"""Images of a scene: EXR textures, and environment light from files, arrays or constants."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache._core import SceneDescription, SceneError
from viscache.base.files import about_exr
from viscache.scene.sky import Sky
from viscache.settings.checks import checked_floats


def existing_file(path: str | os.PathLike[str]) -> Path:
    """A file that is there; SceneError if it is not."""
    source = Path(path)
    if not source.is_file():
        raise SceneError(f"{source}: no such file")
    return source


def read_exr(path: str | os.PathLike[str]) -> npt.NDArray[np.float32]:
    """The colour of an EXR file, (H, W, 3) float32; a single channel is repeated.

    SceneError if the file is missing, not an EXR file, or without colour channels.
    """
    import OpenEXR

    source = existing_file(path)
    with source.open("rb") as start:
        if start.read(4) != b"v/1\x01":
            raise SceneError(f"{source}: not an OpenEXR file")
    try:
        channels: dict[str, Any] = OpenEXR.File(str(source), separate_channels=True).channels()
    except Exception as error:  # the library raises exceptions of several kinds
        raise SceneError(f"{source} cannot be read: {about_exr(error)}") from error
    if all(c in channels for c in "RGB"):
        planes = [channels[c].pixels for c in "RGB"]
    elif "Y" in channels:
        planes = [channels["Y"].pixels] * 3
    else:
        raise SceneError(f"{source}: must have channels R, G, B or Y, got {sorted(channels)}")
    return np.ascontiguousarray(np.stack(planes, axis=-1), dtype=np.float32)


def read_image(path: str | os.PathLike[str]) -> npt.NDArray[np.float32]:
    """A linear image, (H, W, C) float32, from .exr, .hdr, .png or .jpg."""
    existing_file(path)
    if str(path).lower().endswith(".exr"):
        return read_exr(path)
    return _core.read_image(os.fspath(path))


def pending_images(description: SceneDescription) -> list[int]:
    """Indices of the EXR images that a loader left pending."""
    return [i for i, image in enumerate(description.images) if image["width"] == 0]


def decode_image(description: SceneDescription, index: int) -> None:
    """Decode a pending image."""
    image = description.images[index]
    try:
        description.set_image(index, read_exr(image["path"]))
    except SceneError as error:
        raise SceneError(f"{image['where']}: {error}") from error


def apply_environment(description: SceneDescription, env: Any) -> None:
    """Replace the environment by a sky, an image (path or (H, W, 3) array) or constant radiance."""
    if isinstance(env, Sky):
        env.add_to(description)
        return
    pixels = environment_pixels(env)
    if pixels.ndim == 3:
        description.set_environment((1.0, 1.0, 1.0), image=description.add_image(pixels))
        return
    r, g, b = (float(v) for v in np.broadcast_to(pixels, (3,)))
    description.set_environment((r, g, b))


def environment_pixels(env: Any) -> npt.NDArray[np.float32]:
    """The image of an environment, read or as it was given; or its radiance, one or three numbers.

    SceneError if the file is missing or malformed, ValueError if it is no environment.
    """
    if isinstance(env, str | os.PathLike):
        return read_image(env)
    try:
        pixels = checked_floats(env, "env")
    except ValueError:
        what = "env must be a Sky, a path, a number or pixels"
        raise ValueError(f"{what}, got {env!r}") from None
    if pixels.ndim != 3 and pixels.shape not in ((), (1,), (3,)):
        raise ValueError(
            f"env must be a path, a number, 3 numbers or (H, W, 3) pixels, got shape {pixels.shape}"
        )
    return pixels
