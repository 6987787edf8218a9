"""Rendering: one call, every combination of integrator, rays and visibility."""

from __future__ import annotations

import os
import time
import typing
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Literal, TypeAlias

from viscache import _core
from viscache.aqvc_table import AqvcTable
from viscache.cameras import find_camera
from viscache.frame import Frame
from viscache.progress import progress_bar
from viscache.provenance import provenance
from viscache.scene import Env, Scene
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import (
    AmbientOcclusion,
    Bdpt,
    Direct,
    Integrator,
    Whitted,
    core_settings,
)
from viscache.settings.rays import Embree, Rays, Vlf, check_rays
from viscache.settings.visibility import Aqvc, Exact, NeePlusPlus, ShadowMap, Visibility, VisMaps
from viscache.vismap.rendering import render_with_maps

__all__ = ["render"]

Progress: TypeAlias = bool | Callable[[int, int], None]

#: Eye samples of the largest tiles (render/frame.cpp); mirrors may add some.
MOST_POINTS_OF_A_TILE = 1 << 16


def render(
    scene: Scene,
    integrator: Integrator,
    *,
    rays: Rays | None = None,
    visibility: Visibility | None = None,
    use: Literal["replace", "correct"] | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    threads: int | None = None,
    camera: str | int | _core.Camera | None = None,
    env: Env | None = None,
    keep: AqvcTable | None = None,
    progress: Progress = False,
) -> Frame:
    """Render a frame.

    Parameters
    ----------
    scene : Scene
    integrator : Direct, Whitted, AmbientOcclusion or Bdpt
    rays : Embree, Bsp or Vlf, optional
        The ray caster: all rays of the frame go through it.
    visibility : Exact, Aqvc, ShadowMap, NeePlusPlus or VisMaps, optional
        Who answers "does x see y?"; exact by default.
    use : {"replace", "correct"}, optional
        How an approximation is used: in place of visibility (Aqvc, ShadowMap), or as a control
        variate whose error is traced (the default of VisMaps, which offers both).
    size : (width, height), optional
        Pixels; the camera's own by default.
    spp : int >= 1
        Eye paths per pixel, box filter. `Bdpt`: pairs of eye and light paths.
    seed : int >= 0
        Same seed, same bytes, whatever the number of threads.
    threads : int >= 1, optional
        All cores by default.
    camera : str, int or Camera, optional
        Name or index of one of the scene's cameras; the first by default. A scene without a
        camera is seen whole from a corner above.
    env : path, float, (3,) or (H, W, 3), optional
        Environment light instead of the scene's.
    keep : AqvcTable, optional
        Of `Aqvc` with Direct or Whitted: the table whose bits this frame reuses and adds to. The
        cache then runs in form "pairs" with `scale_free` cells unless that is given.
    progress : bool or callable
        True shows a bar; a callable gets (done, total).

    Returns
    -------
    Frame
        Layers "color", "emitted", one per light group (of `Bdpt`, whose layers are weighted, also
        "connection" for those of two surfaces, "camera" for those of light paths with the camera,
        and all lights that eye paths hit in "emitted"), and of what the camera sees first, mirrors
        and glass included: "depth" (H, W, 1) distance from the camera, scene units, "normal"
        (H, W, 3) shading normal turned to the camera, "albedo" (H, W, 3) base colour. These three
        are means over the samples of the pixel that hit a surface, 0 where none did (normals of an
        edge are shorter than 1); "coverage" (H, W, 1) is the share of samples that hit. Besides
        counters ("sha256" is that of the color layer; "lost_throughput" in [0, 1] bounds what the
        frame's mean lacks behind mirrors and glass, relative to the brightest light behind them),
        timings, parameters, provenance.

    Raises
    ------
    ValueError
        A parameter out of range; the message says what must hold.
    KeyboardInterrupt
        Within half a second of Ctrl-C.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> vc.render(scene, vc.Direct(), size=(32, 20)).image.shape
    (20, 32, 3)
    """
    return render_part(
        scene, integrator, (0, 1), rays=rays, visibility=visibility, use=use, size=size, spp=spp,
        seed=seed, threads=threads, camera=camera, env=env, keep=keep, progress=progress,
    )  # fmt: skip


def render_part(
    scene: Scene,
    integrator: Integrator,
    part: tuple[int, int],
    *,
    rays: Rays | None = None,
    visibility: Visibility | None = None,
    use: Literal["replace", "correct"] | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    threads: int | None = None,
    camera: str | int | _core.Camera | None = None,
    env: Env | None = None,
    keep: AqvcTable | None = None,
    progress: Progress = False,
) -> Frame:
    """Part i of n of a frame: every n-th tile from number i on; black elsewhere, else as `render`.

    `viscache.tiles` puts parts together. Of a frame in parts, every part makes the lights again.
    """
    rays = Embree() if rays is None else rays
    visibility = visibility or Exact()
    require(isinstance(scene, Scene), "scene must be a Scene", scene)
    for name, value, known in (
        ("integrator", integrator, typing.get_args(Integrator)),
        ("visibility", visibility, typing.get_args(Visibility)),
    ):
        classes = " or ".join(f"vc.{cls.__name__}(...)" for cls in known)
        require(isinstance(value, known), f"{name} must be {classes}", value)
    check_rays(rays)
    _check_use(use, visibility, integrator)
    _check_shared(integrator, rays, visibility)
    if isinstance(integrator, Bdpt) and isinstance(visibility, Aqvc):
        visibility = visibility.for_frame_table()
    if keep is not None:
        _check_keep(keep, integrator, visibility)
        require(tuple(part) == (0, 1), "keep must be left out for parts of a frame", keep)
        visibility = typing.cast(Aqvc, visibility).for_kept_table()
    geometry = scene
    if env is not None:
        scene = scene.with_environment(env, threads=threads)
    view = find_camera(scene, camera)
    frame = _frame_settings(size or (view.width, view.height), spp, seed, threads)
    frame.part, frame.parts = _checked_part(part, integrator, visibility)

    start, cpu = time.perf_counter(), time.process_time()
    caster = scene.caster(rays, threads=frame.threads)
    build_s = time.perf_counter() - start
    with progress_bar(progress) as report:
        if isinstance(integrator, Bdpt):
            result = _bidirectional(
                (scene._core, caster, view, integrator.core(), frame), visibility, report
            )
        else:
            core = core_settings(integrator)
            parts = (scene._core, caster, view, core, frame)
            if isinstance(visibility, Aqvc) and keep is not None:
                with keep._frame(scene, visibility) as table:
                    result = _core.render_aqvc_kept(
                        *parts, visibility.core(), table, check=keep.check, repair=keep.repair,
                        progress=report,
                    )  # fmt: skip
            elif isinstance(visibility, Aqvc):
                result = _core.render_aqvc(*parts, visibility.core(), progress=report)
            elif isinstance(visibility, ShadowMap):
                result = _core.render_shadow_maps(*parts, visibility.core(), progress=report)
            elif isinstance(visibility, NeePlusPlus):
                result = _core.render_nee_plus_plus(*parts, visibility.core(), progress=report)
            elif core.ambient_aligned:
                embree = typing.cast(_core.EmbreeCaster, caster)  # _check_shared allows no other
                result = _core.render_aligned(
                    scene._core, embree, view, core, frame, _batch_for(scene, integrator, frame),
                    field=_fields_for(scene, integrator, frame), progress=report,
                )  # fmt: skip
            elif isinstance(visibility, VisMaps):
                result = render_with_maps(
                    scene, geometry, rays, *parts[1:], visibility, replace=use == "replace",
                    progress=report,
                )  # fmt: skip
            else:
                batch = _sky_batch(scene, geometry, core, visibility)
                require(batch is None or frame.parts == 1,
                        'visibility must be vc.Exact(sky_engine="embree") for parts of a frame with'
                        " shared directions", visibility)  # fmt: skip
                result = _exact(parts, visibility, batch, report)
    total_s, cpu_s = time.perf_counter() - start, time.process_time() - cpu

    timings: dict[str, float] = {"total_s": total_s, "cpu_s": cpu_s, "build_s": build_s}
    timings.update(result["timings"])
    # Shares of the wall time: CPU seconds of the stage over the threads that ran
    for stage in ("visibility", "shading"):
        timings[f"{stage}_s"] = timings[f"{stage}_cpu_s"] / result["threads"]
    made = Frame(
        layers=result["layers"],
        counters=result["counters"],
        timings=timings,
        parameters={
            "scene": scene.spec or scene.name,
            "scene_hash": scene.content_hash,
            "integrator": {"name": type(integrator).__name__, **asdict(integrator)},
            "rays": {"name": type(rays).__name__, **asdict(rays)},
            "visibility": {"name": type(visibility).__name__, **visibility.parameters()},
            "use": use or ("correct" if isinstance(visibility, VisMaps) else "replace"),
            "size": [frame.width, frame.height],
            "spp": spp,
            "seed": seed,
            "camera": view.name,
            "tile_edge_px": result["tile_edge_px"],
            **({"engine": result["engine"]} if "engine" in result else {}),
            **({"keep": keep.parameters()} if keep is not None else {}),
        },
        provenance={**provenance(), "threads": result["threads"]},
        warnings=_warnings(scene, integrator, visibility),
    )
    if frame.parts > 1:
        made.parameters["part"] = [frame.part, frame.parts]
        made.counters["tile_sums"] = [list(sums) for sums in result.get("tile_sums", [])]
    made.counters["sha256"] = made.sha256
    return made


def _checked_part(
    part: tuple[int, int], integrator: Integrator, visibility: Visibility
) -> tuple[int, int]:
    """The part, where such a frame can be rendered in parts."""
    number, parts = part
    require(is_whole(parts) and 1 <= parts <= 1 << 20, "parts must be in [1, 2^20]", parts)
    require(is_whole(number) and 0 <= number < parts, "part must be in [0, parts)", number)
    if parts > 1:
        require(isinstance(visibility, Exact | Aqvc),
                "visibility must be vc.Exact(...) or vc.Aqvc(...) for parts of a frame",
                visibility)  # fmt: skip
        require(not isinstance(integrator, Bdpt)
                and getattr(integrator, "directions", "") != "shared",
                "integrator must not be Bdpt nor share directions for parts of a frame",
                integrator)  # fmt: skip
        require(getattr(visibility, "storage", "") != "paper_tiles",
                'storage must be "table" or "exact" for parts of a frame', visibility)  # fmt: skip
    return int(number), int(parts)


def _bidirectional(
    parts: tuple[
        _core.Scene, _core.RayCaster, _core.Camera, _core.BdptSettings, _core.FrameSettings
    ],
    visibility: Visibility,
    report: Callable[[int, int], None] | None,
) -> dict[str, typing.Any]:
    """A frame of `Bdpt`."""
    if isinstance(visibility, Aqvc):
        return _core.render_bdpt_aqvc(*parts, visibility.core(), progress=report)
    if isinstance(visibility, NeePlusPlus):
        return _core.render_bdpt_nee_plus_plus(*parts, visibility.core(), progress=report)
    assert isinstance(visibility, Exact)  # _check_use allows no other
    order, coherent = visibility.core()
    return _core.render_bdpt_exact(*parts, order=order, coherent=coherent, progress=report)


def _batch_for(
    scene: Scene, integrator: Integrator, frame: _core.FrameSettings
) -> list[_core.vlf.AlignedBatch]:
    """The batch a frame of shared directions may use; none where Embree traces them anyway."""
    engine = integrator.engine if isinstance(integrator, AmbientOcclusion) else "embree"
    n_points = frame.width * frame.height * frame.spp
    hopeless = engine == "auto" and _core.vlf.is_hopeless(scene.triangles, n_points)
    none = engine in ("embree", "field") or hopeless
    return [] if none else [scene.aligned_batch()]


def _fields_for(
    scene: Scene, integrator: Integrator, frame: _core.FrameSettings
) -> list[_core.vlf.VisibilityField]:
    """The field that a frame of shared directions asks for."""
    if not isinstance(integrator, AmbientOcclusion) or integrator.engine != "field":
        return []
    return [scene.caster(Vlf(n_directions=integrator.n_samples), threads=frame.threads)]


def _exact(
    parts: tuple[
        _core.Scene, _core.RayCaster, _core.Camera, _core.IntegratorSettings, _core.FrameSettings
    ],
    visibility: Exact,
    batch: _core.vlf.AlignedBatch | None,
    report: Callable[[int, int], None] | None,
) -> dict[str, typing.Any]:
    """An exact frame; with a batch, shared directions may go through it."""
    order, coherent = visibility.core()
    if batch is None:
        return _core.render_exact(*parts, order=order, coherent=coherent, progress=report)
    choose = visibility.sky_engine == "auto"
    return _core.render_shared(
        *parts, batch, choose=choose, order=order, coherent=coherent, progress=report
    )


def _sky_batch(
    scene: Scene, geometry: Scene, core: _core.IntegratorSettings, visibility: Exact
) -> _core.vlf.AlignedBatch | None:
    """The batch that a frame's shared directions may use; None where there are none for it."""
    kinds = {light["kind"] for light in scene.lights}
    sky = core.environment == _core.EnvironmentSampling.SHARED
    shared = "directional" in kinds or (sky and bool(kinds & {"constant", "environment"}))
    if visibility.sky_engine == "embree" or not shared:
        return None
    hopeless = _core.vlf.is_hopeless(scene.triangles, MOST_POINTS_OF_A_TILE)
    return None if visibility.sky_engine == "auto" and hopeless else geometry.aligned_batch()


def _check_shared(integrator: Integrator, rays: Rays, visibility: Visibility) -> None:
    if isinstance(integrator, AmbientOcclusion) and integrator.directions == "shared":
        require(isinstance(rays, Embree) and rays.robust,
                "rays must be vc.Embree() with shared directions", rays)  # fmt: skip
        require(isinstance(visibility, Exact),
                "visibility must be vc.Exact(...) with shared directions", visibility)  # fmt: skip
    if isinstance(visibility, Exact) and visibility.sky_engine != "embree":
        require(isinstance(rays, Embree) and rays.robust,
                f'rays must be vc.Embree() with sky_engine="{visibility.sky_engine}"',
                rays)  # fmt: skip
        require(
            isinstance(integrator, Direct | Whitted),
            "integrator must be vc.Direct(...) or vc.Whitted(...) with sky_engine",
            integrator,
        )


def _check_keep(keep: AqvcTable, integrator: Integrator, visibility: Visibility) -> None:
    require(isinstance(keep, AqvcTable), "keep must be vc.AqvcTable(...)", keep)
    require(isinstance(visibility, Aqvc), "visibility must be vc.Aqvc(...) with keep", visibility)
    require(isinstance(integrator, Direct | Whitted),
            "integrator must be vc.Direct(...) or vc.Whitted(...) with keep",
            integrator)  # fmt: skip


def _check_use(use: str | None, visibility: Visibility, integrator: Integrator) -> None:
    both = isinstance(visibility, VisMaps)
    known = (None, "replace", "correct") if both else (None, "replace")
    require(use in known, "use must be " + " or ".join(f'"{u}"' for u in known if u), use)
    if both:
        require(isinstance(integrator, Direct | Whitted),
                "integrator must be vc.Direct(...) or vc.Whitted(...) with visibility maps",
                integrator)  # fmt: skip
        require(getattr(integrator, "environment", "") != "shared",
                'environment must not be "shared" with visibility maps', "shared")  # fmt: skip
    if isinstance(integrator, Bdpt):
        require(isinstance(visibility, Exact | Aqvc | NeePlusPlus),
                "visibility must be vc.Exact(...), vc.Aqvc(...) or vc.NeePlusPlus(...) with Bdpt",
                visibility)  # fmt: skip
    elif isinstance(visibility, Aqvc):
        require(visibility.paper.storage != "shared",
                'storage must be "table", "exact" or "paper_tiles" without Bdpt',
                visibility.paper.storage)  # fmt: skip
    if isinstance(integrator, Direct) and not both:
        product = integrator.environment == "product"
        require(not (product and isinstance(visibility, Aqvc | NeePlusPlus)),
                'visibility must be vc.Exact(...) or vc.VisMaps(...) with environment="product"',
                visibility)  # fmt: skip
        require(product or integrator.passes == 1,
                'passes must be 1 without environment="product"', integrator.passes)  # fmt: skip


def _warnings(scene: Scene, integrator: Integrator, visibility: Visibility) -> list[str]:
    texts = list(scene.warnings)
    if isinstance(integrator, AmbientOcclusion):
        texts = [w for w in texts if "no light" not in w]
    core = visibility.core() if isinstance(visibility, Aqvc) else None
    if core and core.c_n % 2 and core.normal_mode in ("round", "floor"):
        texts.append(
            f"odd c_n ({core.c_n}): grids stand oblique on axis-aligned walls and cost several "
            "times the rays of an even c_n"
        )
    return texts


def _frame_settings(
    size: tuple[int, int], spp: int, seed: int, threads: int | None
) -> _core.FrameSettings:
    pair = isinstance(size, Sequence) and len(size) == 2 and all(is_whole(v) for v in size)
    require(pair, "size must be (width, height)", size)
    for name, value in (("spp", spp), ("seed", seed), ("threads", threads)):
        whole = is_whole(value) or (name == "threads" and value is None)
        require(whole, f"{name} must be a whole number", value)
    width, height = (int(v) for v in size)
    require(1 <= width <= 1 << 16 and 1 <= height <= 1 << 16, "size must be in [1, 65536]", size)
    require(1 <= spp <= 1 << 20, "spp must be in [1, 2^20]", spp)
    require(0 <= seed < 1 << 64, "seed must be in [0, 2^64)", seed)
    require(threads is None or 1 <= threads <= 1024, "threads must be in [1, 1024]", threads)
    frame = _core.FrameSettings()
    frame.width, frame.height, frame.spp, frame.seed = width, height, spp, seed
    frame.threads = threads or len(os.sched_getaffinity(0))
    return frame
