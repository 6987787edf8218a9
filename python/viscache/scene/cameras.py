"""Cameras made in Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from viscache import _core
from viscache._core import Camera
from viscache.scene.scene import Scene
from viscache.settings.checks import is_number, is_whole, require
from viscache.settings.spelling import spelled

__all__ = ["Camera", "look_at", "orthographic"]


Point: TypeAlias = Sequence[float]


@spelled
def look_at(
    origin: Point, target: Point, up: Point = (0.0, 1.0, 0.0), fov_deg: float = 45.0
) -> Camera:
    """A pinhole camera at `origin` that looks at `target`.

    Parameters
    ----------
    origin, target : (3,) float
        In scene units; they must differ.
    up : (3,) float
        The direction that points up in the picture.
    fov_deg : float in (0.01, 177)
        Vertical angle of view.

    Raises
    ------
    ValueError
        A vector does not have three numbers, or the angle is out of range.
    """
    require(is_number(fov_deg) and 0.01 < fov_deg < 177, "fov_deg must be in (0.01, 177)", fov_deg)
    return _placed(origin, target, up, fov_deg)


@spelled
def orthographic(
    origin: Point, target: Point, up: Point = (0.0, 1.0, 0.0), height: float = 2.0
) -> Camera:
    """A camera of parallel rays in the direction from `origin` to `target`.

    Parameters
    ----------
    origin, target : (3,) float
        In scene units; they must differ. The picture is centred on the line between them, and what
        lies behind `origin` is not seen.
    up : (3,) float
        The direction that points up in the picture.
    height : float > 0
        Height of the picture in scene units; the width follows from the size of the frame.

    Raises
    ------
    ValueError
        A vector does not have three numbers, or the height is not positive.

    Examples
    --------
    >>> import viscache as vc
    >>> plan = vc.orthographic((0, 5, 0), (0, 0, 0), up=(0, 0, -1), height=4)
    >>> vc.render("cube_on_plane", vc.AmbientOcclusion(), camera=plan, size=(8, 8)).image.shape
    (8, 8, 3)
    """
    finite = is_number(height) and 0 < height < float("inf")
    require(finite, "height must be > 0 and finite", height)
    camera = _placed(origin, target, up, 45.0)
    camera.view_height = height
    return camera


def _placed(origin: Point, target: Point, up: Point, fov_deg: float) -> Camera:
    for name, value in (("origin", origin), ("target", target), ("up", up)):
        three = np.ndim(value) == 1 and len(value) == 3 and all(is_number(v) for v in value)
        require(three, f"{name} must be 3 numbers", value)
    x, y, z = (float(v) for v in origin)
    tx, ty, tz = (float(v) for v in target)
    ux, uy, uz = (float(v) for v in up)
    return _core.look_at((x, y, z), (tx, ty, tz), (ux, uy, uz), fov_deg)


def find_camera(scene: Scene, wish: str | int | _core.Camera | None) -> Camera:
    """A camera by name or index; the first one by default, or one that sees the whole scene."""
    if isinstance(wish, _core.Camera):
        return wish
    cameras = scene.cameras
    if wish is None:
        return cameras[0] if cameras else scene.overview_camera()
    names = [c.name for c in cameras]
    # An index on a command line or in a sweep's file is text; a name comes first
    if isinstance(wish, str) and wish.isdecimal() and wish not in names:
        wish = int(wish)
    if isinstance(wish, int):
        require(0 <= wish < len(cameras), f"camera must be in [0, {len(cameras)})", wish)
        return cameras[wish]
    require(wish in names, f"camera must be one of {names}", wish)
    return cameras[names.index(wish)]


def camera_in_words(wish: str | int | _core.Camera | None) -> Any:
    """A camera as sweeps record it: JSON-able."""
    if not isinstance(wish, _core.Camera):
        return wish
    names = ["name", "origin", "right", "up", "forward", "fov_rad", "fov_is_horizontal"]
    if wish.view_height > 0:
        names.append("view_height")
    names += [name for name in ("shift_x", "shift_y") if getattr(wish, name) != 0]
    return {name: getattr(wish, name) for name in names}


def frame_size(size: tuple[int, int] | None, camera: _core.Camera | None) -> tuple[int, int]:
    """(width, height), by default those of the camera, which is needed only then.

    ValueError if they are not two whole numbers in [1, 65536].
    """
    given: Any = (camera.width, camera.height) if size is None and camera is not None else size
    fits = isinstance(given, Sequence | np.ndarray) and len(given) == 2
    fits = fits and all(is_whole(v) and 1 <= v <= 1 << 16 for v in given)
    require(fits, "size must be (width, height), both in [1, 65536]", given)
    return (int(given[0]), int(given[1]))
