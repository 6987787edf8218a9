"""Frames of the checks: every method under a name, and how far two frames are apart."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

import viscache as vc
from viscache_lab.extremes import scenes
from viscache_lab.extremes.moved import moved

SIZE = (48, 32)
C_E = 6.0

#: All kinds of light that a scene has, few samples of each.
DIRECT = vc.Direct(n_area=4, n_environment=4, n_brdf=4)
WHITTED = vc.Whitted(n_vpls=32, n_area=2, n_environment=2, n_brdf=2)
#: Light that all eye points share, alone: cells vanish with C_E there.
SHARED = vc.Whitted(n_vpls=24, n_area=0, n_environment=0, n_brdf=0)
PRODUCT = vc.Direct(n_area=4, n_environment=4, environment="product")


@dataclass(frozen=True, kw_only=True, slots=True)
class Method:
    """What answers "does x see y?" in a frame, and how."""

    settings: dict[str, Any] = field(default_factory=dict)  # arguments of `vc.render`
    exact: bool = False  # whether it answers as rays do
    noisy: bool = False  # whether another unit of length draws other random numbers or other cells
    maps: bool = False  # whether it serves the environment alone

    @property
    def integrator(self) -> Any:
        """Light that the method has to answer; virtual lights where few lights are all traced."""
        return PRODUCT if self.maps else WHITTED if self.noisy else DIRECT

    def reference(self) -> Method:
        """Exact visibility with the same samples."""
        chosen = METHODS["exact products" if self.maps else "exact by Embree"]
        return replace(chosen, noisy=self.noisy)


def _aqvc(**settings: Any) -> dict[str, Any]:
    """All light groups through the quantized cache."""
    return {"visibility": vc.Aqvc(**{"c_e": C_E, "exact_groups": (), **settings})}


def _methods() -> dict[str, Method]:
    nee = vc.NeePlusPlus(n_voxels=8, learn_pixels=512)
    pairs = vc.PaperForm(form="pairs", storage="exact")
    table = vc.PaperForm(form="pairs", storage="table")
    free = vc.PaperForm(scale_free=True)
    field_ = vc.Vlf(n_directions=33, n_tiles=32)
    maps = {"visibility": vc.VisMaps(n_startup=100), "env": scenes.sky()}
    return {
        "exact by Embree": Method(exact=True),
        "exact by BSP": Method(settings={"rays": vc.Bsp()}, exact=True),
        "exact by the field": Method(settings={"rays": field_}, exact=True),
        "exact by shafts": Method(settings={"visibility": vc.Exact(engine="shafts")}, exact=True),
        "exact products": Method(settings={"env": scenes.sky()}, exact=True, maps=True),
        "quantized cache": Method(settings=_aqvc()),
        'quantized cache "fast"': Method(settings=_aqvc(preset="fast")),
        'quantized cache "paper"': Method(settings=_aqvc(preset="paper")),
        'quantized cache "as_printed"': Method(settings=_aqvc(preset="as_printed")),
        "quantized cache, pairs with full keys": Method(settings=_aqvc(paper=pairs)),
        "quantized cache, pairs with the table": Method(settings=_aqvc(paper=table)),
        "quantized cache, scale-free": Method(settings=_aqvc(paper=free), noisy=True),
        "quantized cache, corrected": Method(settings={**_aqvc(), "use": "correct"}, noisy=True),
        "shadow maps": Method(settings={"visibility": vc.ShadowMap(resolution=128)}),
        "NEE++": Method(settings={"visibility": nee}, noisy=True),
        "NEE++, corrected": Method(settings={"visibility": nee, "use": "correct"}, noisy=True),
        "visibility maps": Method(settings={**maps, "use": "replace"}, maps=True),
        "visibility maps, corrected": Method(settings=maps, maps=True),
    }


#: Every method of the package that answers visibility of frames.
METHODS: dict[str, Method] = _methods()


def picture(scene: vc.Scene, method: Method | None = None, **given: Any) -> vc.Frame:
    """A small frame on one thread; exact by default. `given` goes to `vc.render`."""
    method = method or METHODS["exact by Embree"]
    settings = {"size": SIZE, "threads": 1, "seed": 1, **method.settings, **given}
    integrator = settings.pop("integrator", method.integrator)
    return vc.render(scene, integrator, **settings)


@cache
def lit(method: str | None = None, **given: Any) -> vc.Frame:
    """A frame of the lit box by one of `METHODS`, exact by default; kept."""
    return picture(scenes.lit_box(), METHODS[method] if method else None, **given)


def one(measure: Callable[[vc.Frame], float], **given: Any) -> float:
    """A measure of a frame of the lit box."""
    return measure(lit(**given))


def two(
    measure: Callable[[vc.Frame, vc.Frame], float],
    mine: dict[str, Any],
    other: Mapping[str, Any] = MappingProxyType({}),
    **both: Any,
) -> float:
    """A measure of a frame of the lit box against another; both have the same further arguments.

    The first is drawn anew: a kept frame would be compared with itself where both are alike.
    """
    return measure(picture(scenes.lit_box(), **both, **mine), lit(**both, **other))


def against_unmoved(
    measure: Callable[[vc.Frame, vc.Frame], float], method: Method, **transform: Any
) -> float:
    """A measure of the moved box's frame against that of the box."""
    box = scenes.lit_box()
    return measure(picture(moved(box, **transform), method), picture(box, method))


def rel_l1(frame: vc.Frame, reference: vc.Frame) -> float:
    """Σ|a − b| / Σb over all pixels; NaN where a pixel is not finite."""
    a, b = (np.asarray(f.image, np.float64) for f in (frame, reference))
    total = b.sum()
    return float(np.abs(a - b).sum() / total) if total else float(np.abs(a).sum())


def differing(frame: vc.Frame, reference: vc.Frame) -> float:
    """Number of pixels whose bytes differ."""
    a, b = (np.ascontiguousarray(f.image, np.float32).view(np.uint32) for f in (frame, reference))
    return float((a != b).any(axis=-1).sum())


def error_of(scene: vc.Scene, method: Method, **given: Any) -> float:
    """rel_l1 of a method against exact visibility of the same samples."""
    return rel_l1(picture(scene, method, **given), picture(scene, method.reference(), **given))


def bad_pixels(frame: vc.Frame) -> float:
    """Number of pixels that are negative or not finite."""
    image = np.asarray(frame.image)
    return float((~np.isfinite(image) | (image < 0)).any(axis=-1).sum())


def outside(frame: vc.Frame, bright: vc.Frame) -> float:
    """Number of pixels that are negative, not finite, or brighter than without any shadow.

    A cache of bits answers "visible" or "occluded", so its frame lies between black and the frame
    without shadows, whatever its cells are. The margin is that of sums in another order.
    """
    a, b = (np.asarray(f.image, np.float64) for f in (frame, bright))
    margin = 1e-5 * b + 1e-7 * b.max(initial=0)
    return float((~np.isfinite(a) | (a < 0) | (a > b + margin)).any(axis=-1).sum())


#: The frame without shadows.
BRIGHT = {"visibility": vc.Unoccluded()}
#: Why `outside` is none of a cache of bits.
BETWEEN = "a cache of bits lies between black and the picture without shadows"


def unequal(frames: list[vc.Frame]) -> float:
    """Number of frames whose bytes are not those of the first."""
    return float(sum(f.sha256 != frames[0].sha256 for f in frames[1:]))
