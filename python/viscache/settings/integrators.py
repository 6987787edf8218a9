"""What a frame computes: settings of the integrators.

The fields are the C++ struct `IntegratorSettings`; a test pins names and defaults together.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.spelling import setting
from viscache.settings.vpls import Vpls

__all__ = ["AmbientOcclusion", "Bdpt", "Direct", "Integrator", "Whitted"]

#: Length of ambient occlusion's rays by default, as a share of the scene's diagonal.
AUTO_SHARE = 0.1

PMode: TypeAlias = Literal["last_vertex", "footprint"]


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class Direct:
    """Direct light: point, directional, area lights and environment.

    Mirrors and glass show emitters and the environment after one bounce, nothing else.

    Parameters
    ----------
    n_area : int >= 0
        Samples per eye point over all area lights together; 0 leaves area lights out.
    light_choice : {"contribution", "power"}
        How each of these samples chooses its light. "contribution": by the light that it can send
        to the eye point, estimated from its radiance, solid angle and cosines, without shadows.
        Up to 16 · `n_area` triangles and spheres (256 at most) are estimated one by one; a tree
        over the lights (Conty Estevez, Kulla 2018) serves more. "power": alike at all eye points.
    n_environment : int >= 0
        Samples per eye point of the environment by its radiance.
    n_brdf : int >= 0
        Samples per eye point by the BRDF: of the environment, and at glossy points of area lights.
        They are combined with those of the lights by the balance heuristic (Veach, Guibas 1995).
        Beside shared directions, they are of the environment by sharp lobes alone, and are dealt to
        the sets of `interleave` as the directions are. A lobe is sharp if its peak is at least
        three times the reflection of a diffuse surface of the same albedo.
    environment : {"mis", "product", "shared"}
        "mis": as above. "product": `n_environment` directions per eye point and pass, drawn by
        light × reflection, without `n_brdf`. `VisMaps` always does this. "shared": `n_environment`
        directions drawn by radiance once per frame, the same for all eye points.
        The error then appears as bands instead of noise. Tiles are answered as a whole: by level
        waves of `Aqvc`, or by the aligned batch of `Exact(sky_engine="auto")`.
    passes : int >= 1
        Independent passes of product samples; the image is their mean, the layer
        "environment_last_pass" the last one alone.
    points : {"even", "independent"}
        Product samples: a randomised (0, 2)-sequence, or independent ones.
    centred : bool
        Primary rays go through the centres of pixels instead of random positions. There is no
        antialiasing; for comparisons of variance.
    interleave : int >= 1
        Sets to which shared directions are dealt; the eye points of a pixel ask the sets in turns,
        so each costs `n_environment` / `interleave` rays. With as many samples per pixel, a pixel
        asks all directions once (interleaved sampling, Keller, Heidrich 2001), and rays of the same
        set stay as coherent as those of all.
    pick : int >= 0
        Lights that each eye point picks from each group that all eye points share: point and spot
        lights, directional lights, shared directions. Only these are asked for. They are picked by
        their contribution without shadows (systematic sampling), and weighted by the inverse of
        their probability, so the expectation is the sum over all lights. 0: all lights, and also
        where at most `pick` lights contribute.
    p_mode : {"last_vertex", "footprint"}
        Density of eye points: unfolded camera density, or ray differentials (AQVC Sec. 3.4).
    cosmin : float in (0, 1]
        Floor of the cosine in densities.
    """

    n_area: int = 16
    light_choice: Literal["contribution", "power"] = "contribution"
    n_environment: int = 16
    n_brdf: int = 16
    environment: Literal["mis", "product", "shared"] = "mis"
    passes: int = 1
    points: Literal["even", "independent"] = "even"
    centred: bool = False
    interleave: int = 1
    pick: int = 0
    p_mode: PMode = "last_vertex"
    cosmin: float = 0.05

    def __post_init__(self) -> None:
        check_types(self)
        _check_samples(self)
        require(1 <= self.passes <= 1 << 16, "passes must be in [1, 65536]", self.passes)


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class Whitted:
    """Eye paths through mirrors and glass, direct light, and virtual point lights for the rest.

    VPLs (instant radiosity, Keller 1997) are traced from the lights and carry indirect light only.
    They are resampled to `n_vpls` by their contribution to the camera (after Segovia et al. 2006).
    They reflect diffusely. On glossy surfaces they carry the diffuse part; light that the glossy
    lobe reflects to other surfaces is missing.

    Parameters
    ----------
    n_vpls : int >= 0
        Number of virtual point lights; it may be smaller, because equal ones are merged.
    max_depth : int >= 0
        Mirror and glass bounces of an eye path. Glass splits a path in two. Branches with less than
        0.3 % of a sample continue by Russian roulette (noise below 0.2 % of a sample).
        `frame.counters["lost_throughput"]` counts what `max_depth` cuts off.
    vpl_max_depth : int >= 1
        Bounces of a light path.
    vpl_candidates : int >= 1
        Candidates per VPL kept; as many light paths are traced as they take.
    vpl_eye_points : int >= 1
        Camera points that determine the contribution of candidates.
    vpl_bound : float >= 0
        Bounds the geometry term cos·cos/(d² + (vpl_bound · scene diagonal)²); 0 = unbounded.
    vpls : Vpls, optional
        Virtual point lights of your own; `n_vpls` and the parameters of tracing are not used.
    environment : {"mis", "shared"}
        As in `Direct`.
    pick : int >= 0
        As in `Direct`. Virtual point lights are a group of their own: with `pick=16`, an eye point
        asks for 16 of the `n_vpls`.
    n_area, light_choice, n_environment, n_brdf, interleave, p_mode, cosmin
        As in `Direct`.
    """

    n_vpls: int = 1024
    max_depth: int = 8
    vpl_max_depth: int = 4
    vpl_candidates: int = 4
    vpl_eye_points: int = 64
    vpl_bound: float = 0.01
    vpls: Vpls | None = None
    n_area: int = 16
    light_choice: Literal["contribution", "power"] = "contribution"
    n_environment: int = 16
    n_brdf: int = 16
    environment: Literal["mis", "shared"] = "mis"
    interleave: int = 1
    pick: int = 0
    p_mode: PMode = "last_vertex"
    cosmin: float = 0.05

    def __post_init__(self) -> None:
        check_types(self)
        _check_samples(self)
        require(0 <= self.n_vpls <= 1 << 20, "n_vpls must be in [0, 2^20]", self.n_vpls)
        require(0 <= self.max_depth <= 16, "max_depth must be in [0, 16]", self.max_depth)
        require(
            1 <= self.vpl_max_depth <= 64, "vpl_max_depth must be in [1, 64]", self.vpl_max_depth
        )
        require(
            1 <= self.vpl_candidates <= 1024,
            "vpl_candidates must be in [1, 1024]",
            self.vpl_candidates,
        )
        require(
            1 <= self.vpl_eye_points <= 1 << 16,
            "vpl_eye_points must be in [1, 65536]",
            self.vpl_eye_points,
        )
        require(0 <= self.vpl_bound <= 1, "vpl_bound must be in [0, 1]", self.vpl_bound)
        own = self.vpls is None or isinstance(self.vpls, Vpls)
        require(own, "vpls must be vc.Vpls(...)", self.vpls)


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class AmbientOcclusion:
    """The visible share of the hemisphere, in [0, 1].

    Parameters
    ----------
    n_samples : int >= 1
        Directions per eye point.
    distribution : {"cosine", "uniform"}
        How directions are drawn; both give the cosine-weighted share.
    max_distance : float > 0, "auto" or None
        Length of the rays in scene units; farther occluders do not count. "auto": a tenth of the
        diagonal of the scene's bounding box, so that closed rooms are not black.
        `frame.parameters["integrator"]` has the number. None or inf: no limit.
    directions : {"own", "shared"}
        "own": each eye point draws its directions. "shared": all eye points use the directions of
        `vlf.directions` on their side (VLF Sec. 7), weighted by solid angle and cosine. This costs
        several times less and has no noise, but all pixels miss what these directions miss.
        `n_samples` must be one of vlf.DIRECTION_COUNTS, e.g. 513. `distribution` and the frame's
        seed are not used.
    engine : {"auto", "batch", "embree", "field"}
        The engine for shared directions, as in `vlf.trace_aligned`. "auto" does not use the field,
        because its build takes longer than one frame gains.
    p_mode, cosmin
        As in `Direct`.
    """

    n_samples: int = 64
    distribution: Literal["cosine", "uniform"] = "cosine"
    max_distance: float | Literal["auto"] | None = "auto"
    directions: Literal["own", "shared"] = "own"
    engine: Literal["auto", "batch", "embree", "field"] = "auto"
    p_mode: PMode = "last_vertex"
    cosmin: float = 0.05

    def __post_init__(self) -> None:
        if isinstance(self.max_distance, float) and self.max_distance == math.inf:
            object.__setattr__(self, "max_distance", None)
        check_types(self)
        require(1 <= self.n_samples <= 1 << 20, "n_samples must be in [1, 2^20]", self.n_samples)
        near = self.max_distance
        require(
            near is None or near == "auto" or near > 0,
            'max_distance must be > 0, "auto", or None for no limit',
            near,
        )
        require(
            self.directions == "own" or _core.vlf.is_direction_count(self.n_samples),
            "n_samples must be 1 or 2·4^k + 1 up to 8193, e.g. 513, with shared directions",
            self.n_samples,
        )
        _check_density(self)

    def within(self, bounds: npt.NDArray[np.float32]) -> AmbientOcclusion:
        """With the number that "auto" stands for in a box (2, 3); no limit where it is empty."""
        if self.max_distance != "auto":
            return self
        diagonal = float(np.linalg.norm(bounds[1].astype(float) - bounds[0]))
        limited = math.isfinite(diagonal) and diagonal > 0
        return replace(self, max_distance=AUTO_SHARE * diagonal if limited else None)


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class Bdpt:
    """Bidirectional path tracing (Veach 1997): all light paths of up to `max_depth` edges.

    Every sample of a pixel traces one path from the camera and one from the lights. Every vertex of
    one path is connected with every vertex of the other, weighted by the balance heuristic over all
    techniques that sample the same path. `spp` is the number of such pairs per pixel. Paths end at
    `max_depth` or where nothing is reflected; there is no Russian roulette.

    Sphere lights are found by connections alone (they are traced tessellated), except where only
    mirrors and glass lie between them and the camera.

    Parameters
    ----------
    max_depth : int in [1, 64]
        Edges of a path as Mitsuba counts them: 1 = emission seen directly, 2 = direct light.
    camera_connections : {"keyed", "bypass", "off"}
        Connections of light paths with the camera. "keyed": through the cache, if there is one,
        with the camera as a point. "bypass": a shadow ray each, without the cache. "off": none, so
        only eye paths find caustics.
    cosmin : float in (0, 1]
        Floor of the cosine in the cache's densities.
    """

    max_depth: int = 8
    camera_connections: Literal["keyed", "bypass", "off"] = "keyed"
    cosmin: float = 0.05

    def __post_init__(self) -> None:
        check_types(self)
        require(1 <= self.max_depth <= 64, "max_depth must be in [1, 64]", self.max_depth)
        _check_density(self)

    def core(self) -> _core.BdptSettings:
        """The C++ settings."""
        core = _core.BdptSettings()
        core.max_depth, core.cosmin = self.max_depth, self.cosmin
        core.camera_connections = _core.CameraConnections[self.camera_connections.upper()]
        return core


Integrator: TypeAlias = Direct | Whitted | AmbientOcclusion | Bdpt


def _check_density(s: Integrator) -> None:
    require(0 < s.cosmin <= 1, "cosmin must be in (0, 1]", s.cosmin)


def _check_samples(s: Direct | Whitted) -> None:
    for name in ("n_area", "n_environment", "n_brdf"):
        value = getattr(s, name)
        require(0 <= value <= 1 << 16, f"{name} must be in [0, 65536]", value)
    require(0 <= s.pick <= 1 << 20, "pick must be in [0, 2^20]", s.pick)
    require(
        s.interleave == 1 or s.environment == "shared",
        'interleave must be 1 without environment="shared"',
        s.interleave,
    )
    require(
        1 <= s.interleave <= max(1, s.n_environment),
        "interleave must be >= 1 and at most n_environment",
        s.interleave,
    )
    _check_density(s)


def described(integrator: Integrator) -> dict[str, Any]:
    """Class, names and values, JSON-able: arrays of lights by their number and hash."""
    values = asdict(integrator)
    if values.get("vpls") is not None:
        values["vpls"] = repr(values["vpls"])
    return {"name": type(integrator).__name__, **values}


def core_settings(integrator: Integrator) -> _core.IntegratorSettings:
    """The C++ struct of an integrator that shades eye points; `Bdpt` has its own."""
    if isinstance(integrator, Bdpt):
        raise ValueError(f"integrator must shade eye points, got {integrator}")
    core = _core.IntegratorSettings()
    core.p_mode = _core.PMode[integrator.p_mode.upper()]
    core.cosmin = integrator.cosmin
    if isinstance(integrator, AmbientOcclusion):
        core.direct, core.ambient, core.max_depth = False, True, 0
        core.n_ambient = integrator.n_samples
        core.ambient_cosine = integrator.distribution == "cosine"
        if isinstance(integrator.max_distance, str):
            raise ValueError('max_distance must be a number or None here, got "auto"')
        core.ambient_max_distance = integrator.max_distance or 0.0
        core.ambient_aligned = integrator.directions == "shared"
        core.ambient_engine = _core.AmbientEngine[integrator.engine.upper()]
        return core
    for field in fields(integrator):
        if field.name not in ("p_mode", "light_choice", "environment", "points", "vpls"):
            setattr(core, field.name, getattr(integrator, field.name))
    core.light_choice = _core.LightChoice[integrator.light_choice.upper()]
    core.environment = _core.EnvironmentSampling[integrator.environment.upper()]
    if isinstance(integrator, Direct):
        even = integrator.points == "even"
        core.points = _core.PointSet.ZERO_TWO if even else _core.PointSet.INDEPENDENT
    core.shade_after_specular = isinstance(integrator, Whitted)
    own = getattr(integrator, "vpls", None)
    if own is not None:
        core.set_vpls(own.positions, own.normals, own.flux)
    return core
