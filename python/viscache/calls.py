"""`viscache.Shot`: what to render, and every call that renders it as a method."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from viscache import _core
from viscache.frame import Frame
from viscache.passes.progressive import Progressive
from viscache.settings.spelling import spelled
from viscache.shot.connections import Connections, connections
from viscache.shot.render import render
from viscache.shot.shot import BareShot
from viscache.sweeps.plan import Over
from viscache.sweeps.sweep import sweep
from viscache.sweeps.tune import tune
from viscache.sweeps.tuned import Tuned

if TYPE_CHECKING:
    import xarray


@spelled
@dataclass(frozen=True, eq=False, repr=False)
class Shot(BareShot):
    """What to render, said once: scene, integrator, visibility and the rest.

    A shot does not change. Two shots are equal if they give the same picture: `key` is the hash of
    all that decides its bytes, by value. Threads and names of files have no part in it.

    Parameters
    ----------
    scene : Scene, path or str
        A string is a file or a built-in name (`room?triangles=5000`).
    integrator : Direct, Whitted, AmbientOcclusion or Bdpt
        Or its name: "direct", "whitted", "ao" or "bdpt", with parameters if wanted:
        "whitted?n_vpls=64". The next two take names too. `vc.Direct()` by default.
    rays : Embree, Bsp or Vlf, optional
        The ray caster that traces all rays of the frame. "embree", "bsp" or "vlf".
    visibility : Exact, Aqvc, ShadowMap, NeePlusPlus, VisMaps or your own, optional
        The method that answers "does x see y?"; exact by default. "exact", "aqvc", "shadow_map",
        "nee_plus_plus" or "vismap". An object with a method `block(eyes, lamps, wanted)` is an
        oracle of your own (docs/howto/own-cache.md).
    use : {"replace", "correct"} or Correct, optional
        How an approximation is used. "replace": in place of visibility; the default, but not of
        VisMaps. "correct": as a control variate, which is unbiased; rays for a random share of the
        queries correct the error. "correct" is `vc.Correct()`, except that VisMaps have their own
        control variate.
    size : (width, height), optional
        Pixels; the camera's own by default.
    spp : int >= 1
        Eye paths per pixel, box filter. `Bdpt`: pairs of eye and light paths.
    seed : int >= 0
        The same seed gives the same bytes for any number of threads.
    threads : int >= 1, optional
        All cores by default.
    camera : str, int or Camera, optional
        Name or index of one of the scene's cameras, or a camera of `vc.look_at`. The first by
        default. Without a camera, the whole scene is shown from a corner above.
    env : Sky, path, float, (3,) or (H, W, 3), optional
        Environment light instead of the scene's.

    Examples
    --------
    >>> import viscache as vc
    >>> shot = vc.Shot("room?triangles=3000", "whitted?n_vpls=64", size=(64, 40), seed=3)
    >>> shot
    Shot('room?triangles=3000', Whitted(n_vpls=64), size=(64, 40), seed=3)
    >>> exact, frame = shot.render(), shot.render(visibility="aqvc?c_e=8")
    >>> vc.metrics.compare(frame, exact)["rel_l1"] < 0.1
    True
    >>> shot.sweep(over={"c_e": [4, 8]})["rel_l1"].shape
    (2, 1)
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        # What can change is copied
        for name, kind in (("camera", _core.Camera), ("env", np.ndarray)):
            if isinstance(given := getattr(self, name), kind):
                object.__setattr__(self, name, copy.copy(given))

    def render(self, **more: Any) -> Frame:
        """The frame: `viscache.render`, with changes to the shot or arguments of the call."""
        return render(**self._with(more, opened=True))

    def sweep(self, over: Over, **more: Any) -> xarray.Dataset:
        """Frames over a grid of parameters: `viscache.sweep`; of `vc.Aqvc()` by default."""
        return sweep(over=over, **self._with(more))

    def tune(self, **more: Any) -> Tuned:
        """A setting with a wanted error: `viscache.tune`; of `vc.Aqvc()` by default."""
        return tune(**self._with(more, opened=True))

    def passes(self, n: int, **more: Any) -> Progressive:
        """A picture after n passes, which can go on: `viscache.Progressive`; `.frame` is it."""
        picture = Progressive(**self._with(more, opened=True))
        picture.passes(n)
        return picture

    def connections(self, **more: Any) -> Connections:
        """The visibility queries as arrays: `viscache.connections`."""
        bare = replace(self, visibility=None, use=None)  # answers are asked for later
        return connections(**bare._with(more, opened=True))

    def _with(self, more: dict[str, Any], *, opened: bool = False) -> dict[str, Any]:
        """Arguments of a call; what was not given keeps the call's own default."""
        given = {name: value for name, value in self.arguments.items() if value is not None}
        if opened and "scene" not in more:
            given["scene"] = self.opened
        return given | more
