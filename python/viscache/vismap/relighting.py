"""Lighting design (VisMap Sec. 6.2): an image under any environment light, without rays."""

from __future__ import annotations

import time
from dataclasses import asdict
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import Progress, progress_bar
from viscache.base.provenance import provenance
from viscache.frame import Frame
from viscache.scene import Env, Sky
from viscache.scene.cameras import find_camera, frame_size
from viscache.scene.environments import read_image
from viscache.settings.checks import checked_floats, checked_threads, is_number, require
from viscache.settings.spelling import spelled
from viscache.vismap.cache import VisibilityMapCache
from viscache.vismap.records import checked_size

Floats: TypeAlias = npt.NDArray[np.floating[Any]]
#: Light images with more rows are reduced, since the cells of maps are some degrees wide.
MOST_ROWS = 256


@spelled
class Relighting:
    """An image of a scene whose environment light can be rotated and replaced in milliseconds.

    Camera paths are traced and the cache is looked up once. The light of a pixel is then J = ∫
    L·B̃·Ṽ: without noise, but biased, and limited by the resolution of the maps. Other lights of
    the scene are ignored.

    Parameters
    ----------
    cache : VisibilityMapCache
        Cache of the scene. By default records are added where the image needs them.
    camera, size, threads, progress
        As in `viscache.render`.
    update : bool
        Insert records where the pixels of this image need them.

    Raises
    ------
    ValueError
        A parameter is out of range, or the cache has the criterion "ambient".

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> image = vc.Relighting(vc.VisibilityMapCache(scene), size=(32, 20))
    >>> image.under(1.0).image.shape, image.under((1, 0.5, 0.2)).counters["rays"]
    ((20, 32, 3), 0)
    """

    def __init__(
        self,
        cache: VisibilityMapCache,
        *,
        camera: str | int | _core.Camera | None = None,
        size: tuple[int, int] | None = None,
        update: bool = True,
        threads: int | None = None,
        progress: Progress = False,
    ) -> None:
        require(isinstance(cache, VisibilityMapCache), "cache must be a VisibilityMapCache", cache)
        blends = cache.settings.criterion == "visibility"
        require(blends, 'the cache\'s criterion must be "visibility"', cache.settings.criterion)
        self.cache = cache
        view = find_camera(cache.scene, camera)
        self.size = checked_size(frame_size(size, view))
        self._view = view.name
        self._threads = checked_threads(threads)
        if update:
            cache.update(view, size=self.size, threads=threads)
        frame = _core.FrameSettings()
        frame.width, frame.height = self.size
        frame.threads = self._threads
        with cache._lock, progress_bar(progress) as report:
            points, _, _ = cache._pixels(view, *self.size, (0.5, 0.5), self._threads)
            self._core = _core.vismap.Relighting.trace(
                cache.scene._core,
                cache._caster(),
                view,
                frame,
                cache._core,
                points.d_max,
                points.footprint,
                progress=report,
            )

    @property
    def nbytes(self) -> int:
        """Bytes stored for the image."""
        return self._core.nbytes

    def light(self, env: Env, *, rotation_deg: float = 0.0) -> npt.NDArray[np.float64]:
        """Radiance × solid angle over the cells of the maps: (3, 4^m), in Z order.

        Parameters
        ----------
        env : path, float, (3,) or (H, W, 3)
            As in `viscache.render`. Images with more than 256 rows are reduced first.
        rotation_deg : float
            Rotation about the y axis, counter-clockwise as seen from above.
        """
        fits = is_number(rotation_deg) and bool(np.isfinite(rotation_deg))
        require(fits, "rotation_deg must be a finite number", rotation_deg)
        message = "env must not be a Sky: give its image(), which has no sun"
        require(not isinstance(env, Sky), message, env)
        given = checked_floats(env, "env") if _is_numbers(env) else read_image(env)  # type: ignore[arg-type]
        if given.ndim < 3:
            require(
                given.shape in ((), (1,), (3,)),
                "env must be a path, a number, 3 numbers or (H, W, 3) pixels, of shape",
                given.shape,
            )
            r, g, b = (float(v) for v in np.broadcast_to(given, (3,)))
            made = _core.sampling.EnvironmentMap.constant((r, g, b))
        else:
            require(given.size > 0, "env must have at least one pixel, of shape", given.shape)
            made = _core.sampling.EnvironmentMap.from_latlong(
                reduced(given),
                to_world=rotation(rotation_deg),
                resolution=128,
                threads=self._threads,
            )
        return np.asarray(_core.vismap.cell_light(made, self.cache.settings.m))

    def under(self, env: Env, *, rotation_deg: float = 0.0) -> Frame:
        """The image under a light.

        Parameters
        ----------
        env, rotation_deg
            As in `light`.

        Returns
        -------
        Frame
            Layer "color": J (H, W, 3), without directly visible light. Counters: "rays" (0),
            "records", and "without_record", the number of eye points without records.
        """
        start, cpu = time.perf_counter(), time.process_time()
        image = self._core.image(self.light(env, rotation_deg=rotation_deg), self._threads)
        return Frame(
            layers={"color": image.astype(np.float32)},
            counters={
                "rays": self._core.rays,
                "records": len(self.cache),
                "without_record": self._core.without_record,
            },
            timings={"total_s": time.perf_counter() - start, "cpu_s": time.process_time() - cpu},
            parameters={
                "scene": self.cache.scene.spec or self.cache.scene.name,
                "camera": self._view,
                "scene_hash": self.cache.scene.content_hash,
                "size": list(self.size),
                "rotation_deg": rotation_deg,
                "settings": asdict(self.cache.settings),
            },
            provenance=provenance(self._threads or None),
        )


def rotation(degrees: float) -> npt.NDArray[np.float64]:
    """(3, 3): the rotation about the y axis that takes a map into the world."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def reduced(pixels: Floats) -> npt.NDArray[np.float32]:
    """A lat-long image (H, W, C) reduced to at most 256 rows: block means by solid angle."""
    step = -(-pixels.shape[0] // MOST_ROWS)
    if step == 1 or pixels.shape[0] % step or pixels.shape[1] % step:
        return np.asarray(pixels, np.float32)
    height, width, channels = pixels.shape
    edges = np.cos(np.arange(height + 1) / height * np.pi)
    weight = (edges[:-1] - edges[1:]).reshape(-1, step, 1, 1, 1)
    blocks = pixels.reshape(height // step, step, width // step, step, channels)
    mean = (blocks * weight).sum(axis=(1, 3)) / (weight.sum(axis=1).reshape(-1, 1, 1) * step)
    return np.asarray(mean, np.float32)


def _is_numbers(env: Env) -> bool:
    return not isinstance(env, str) and not hasattr(env, "__fspath__")
