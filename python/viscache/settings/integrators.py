"""What a frame computes: settings of the integrators (rows: cpp/viscache/render/settings.h)."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import require
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.registry import registered
from viscache.settings.vpls import Vpls

#: Length of ambient occlusion's rays by default, as a share of the scene's diagonal.
AUTO_SHARE = 0.1

DIRECT = ParameterRows(_core.DirectSettings)
WHITTED = ParameterRows(_core.WhittedSettings)
AMBIENT = ParameterRows(_core.AmbientSettings)
BDPT = ParameterRows(_core.BdptSettings)


@registered("integrator", "direct")
@DIRECT.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Direct(RowSettings):
    """Direct light: point, directional, area lights and environment.

    Mirrors and glass show emitters and the environment after one bounce, nothing else.

    Parameters
    ----------
    {parameters}
    """

    ROWS: ClassVar[ParameterRows] = DIRECT
    n_area: int = DIRECT.default("n_area")
    n_environment: int = DIRECT.default("n_environment")
    n_brdf: int = DIRECT.default("n_brdf")
    environment: Literal["mis", "shared", "product"] = DIRECT.default("environment")
    passes: int = DIRECT.default("passes")
    points: Literal["independent", "even"] = DIRECT.default("points")
    centred: bool = DIRECT.default("centred")
    interleave: int = DIRECT.default("interleave")
    pick: int = DIRECT.default("pick")


@registered("integrator", "whitted")
@WHITTED.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Whitted(RowSettings):
    """Eye paths through mirrors and glass, direct light, and virtual point lights for the rest.

    VPLs (instant radiosity, Keller 1997) are traced from the lights and carry indirect light only.
    They are resampled to `n_vpls` by their contribution to the camera (after Segovia et al. 2006).
    They reflect diffusely. On glossy surfaces they carry the diffuse part; light that the glossy
    lobe reflects to other surfaces is missing.

    Parameters
    ----------
    {parameters}
    """

    ROWS: ClassVar[ParameterRows] = WHITTED
    n_vpls: int = WHITTED.default("n_vpls")
    max_depth: int = WHITTED.default("max_depth")
    vpl_max_depth: int = WHITTED.default("vpl_max_depth")
    vpl_bound: float = WHITTED.default("vpl_bound")
    vpls: Vpls | None = None
    n_area: int = WHITTED.default("n_area")
    n_environment: int = WHITTED.default("n_environment")
    n_brdf: int = WHITTED.default("n_brdf")
    environment: Literal["mis", "shared"] = WHITTED.default("environment")
    interleave: int = WHITTED.default("interleave")
    pick: int = WHITTED.default("pick")

    def __post_init__(self) -> None:
        own = self.vpls is None or isinstance(self.vpls, Vpls)
        require(own, "vpls must be vc.Vpls(...)", self.vpls)
        RowSettings.__post_init__(self)


@registered("integrator", "ao")
@AMBIENT.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class AmbientOcclusion(RowSettings):
    """The visible share of the hemisphere, in [0, 1].

    Parameters
    ----------
    {parameters}
    """

    ROWS: ClassVar[ParameterRows] = AMBIENT
    n_samples: int = AMBIENT.default("n_samples")
    distribution: Literal["cosine", "uniform"] = AMBIENT.default("distribution")
    max_distance: float | Literal["auto"] | None = AMBIENT.default("max_distance")
    directions: Literal["own", "shared"] = AMBIENT.default("directions")
    engine: Literal["auto", "batch", "embree", "field"] = AMBIENT.default("engine")

    def __post_init__(self) -> None:
        if isinstance(self.max_distance, float) and self.max_distance == math.inf:
            object.__setattr__(self, "max_distance", None)
        RowSettings.__post_init__(self)

    def within(self, bounds: npt.NDArray[np.float32]) -> AmbientOcclusion:
        """With the number that "auto" stands for in a box (2, 3); no limit where it is empty."""
        if self.max_distance != "auto":
            return self
        diagonal = float(np.linalg.norm(bounds[1].astype(float) - bounds[0]))
        limited = math.isfinite(diagonal) and diagonal > 0
        return replace(self, max_distance=AUTO_SHARE * diagonal if limited else None)


@registered("integrator", "bdpt")
@BDPT.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Bdpt(RowSettings):
    """Bidirectional path tracing (Veach 1997): all light paths of up to `max_depth` edges.

    Every sample of a pixel traces one path from the camera and one from the lights. Every vertex of
    one path is connected with every vertex of the other, weighted by the balance heuristic over all
    techniques that sample the same path. `spp` is the number of such pairs per pixel. Paths end at
    `max_depth` or where nothing is reflected; there is no Russian roulette.

    Sphere lights are found by connections alone (they are traced tessellated), except where only
    mirrors and glass lie between them and the camera.

    Parameters
    ----------
    {parameters}
    """

    ROWS: ClassVar[ParameterRows] = BDPT
    max_depth: int = BDPT.default("max_depth")
    camera_connections: Literal["keyed", "bypass", "off"] = BDPT.default("camera_connections")


Integrator: TypeAlias = Direct | Whitted | AmbientOcclusion | Bdpt


def described(integrator: Integrator) -> dict[str, Any]:
    """Class, names and values, JSON-able: arrays of lights by their number and hash."""
    values = asdict(integrator)
    if values.get("vpls") is not None:
        values["vpls"] = repr(values["vpls"])
    return {"name": type(integrator).__name__, **values}


def eye_settings(integrator: Integrator) -> _core.IntegratorSettings:
    """The C++ struct of an integrator that shades eye points; `Bdpt` has its own."""
    if isinstance(integrator, Bdpt):
        raise ValueError(f"integrator must shade eye points, got {integrator}")
    if isinstance(integrator, AmbientOcclusion) and integrator.max_distance == "auto":
        raise ValueError('max_distance must be a number or None here, got "auto"')
    core: _core.IntegratorSettings = integrator.core()
    return core
