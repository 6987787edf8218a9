"""Rendering: one call for every combination of integrator, rays and visibility."""

from __future__ import annotations

import hashlib
import math
import os
import time
from contextlib import ExitStack
from dataclasses import asdict, replace
from typing import Any, Literal, cast

from viscache import _core, sources
from viscache.aqvc_rows import AqvcRows
from viscache.aqvc_table import AqvcTable
from viscache.audited import audit_record, error_warnings, nothing_found, watched_pixels
from viscache.combinations import Request, check
from viscache.exact_cost import cost_warnings
from viscache.frame import Frame, count_broken_pixels
from viscache.frame_memory import require_memory
from viscache.oracles.correct import Correct, in_words
from viscache.oracles.learned import PassMemory
from viscache.oracles.sources import oracle_source, parameters_of, shafts_for
from viscache.oracles.written import Written, is_written
from viscache.progress import Progress, progress_bar
from viscache.provenance import provenance
from viscache.scene import Env, Scene
from viscache.scene.about import lit_coats
from viscache.scene.cameras import find_camera, frame_size
from viscache.settings import audit as audits
from viscache.settings import by_name
from viscache.settings.checks import checked_threads, is_whole, require
from viscache.settings.integrators import (
    AmbientOcclusion,
    Bdpt,
    Integrator,
    described,
    eye_settings,
)
from viscache.settings.rays import Rays, Vlf, check_rays
from viscache.settings.registry import classes, is_setting
from viscache.settings.source_context import SourceContext
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Aqvc, Exact, NeePlusPlus, Visibility, VisMaps
from viscache.vismap.rendering import render_with_maps
from viscache.voxel_counts import VoxelCounts

__all__ = ["render"]


#: Eye samples of the largest tiles (render/tiles.h); mirrors may add some.
MOST_POINTS_OF_A_TILE = 1 << 16


@spelled
def render(
    scene: Scene | str | os.PathLike[str],
    integrator: Integrator | str,
    *,
    rays: Rays | str | None = None,
    visibility: Visibility | Written | str | None = None,
    use: Literal["replace", "correct"] | Correct | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    threads: int | None = None,
    camera: str | int | _core.Camera | None = None,
    env: Env | None = None,
    keep: AqvcTable | AqvcRows | VoxelCounts | None = None,
    first_sample: int = 0,
    audit: audits.Audit | Literal["pixels", "queries"] | None = None,
    progress: Progress = False,
) -> Frame:
    """Render a frame.

    Parameters
    ----------
    scene : Scene, path or str
        A string is a file or a built-in name (`room?triangles=5000`).
    integrator : Direct, Whitted, AmbientOcclusion or Bdpt
        Or its name, for default settings: "direct", "whitted", "ao" or "bdpt". The next two take
        names too.
    rays : Embree, Bsp or Vlf, optional
        The ray caster that traces all rays of the frame. "embree", "bsp" or "vlf".
    visibility : Exact, Aqvc, ... or your own, optional
        The method that answers "does x see y?"; exact by default. `viscache params` lists names. An
        object with a method `block(eyes, lamps, wanted)` is an oracle of your own
        (docs/howto/own-cache.md).
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
    keep : AqvcTable, AqvcRows or VoxelCounts, optional
        For `Aqvc` with Direct or Whitted: what this frame reuses and extends. With a table, the
        cache has the form "pairs", and `scale_free` cells by default; it is for frames of moving
        cameras. Rows are for frames of more samples, as `vc.Progressive` renders them. Counts of
        voxels are for `NeePlusPlus`.
    first_sample : int >= 0, a multiple of spp
        Number of the first eye sample of each pixel. With one seed, frames of first samples 0, spp,
        2·spp, ... have the same virtual lights and shared directions, and new samples of all else:
        those of one frame of as many samples. So such frames are not independent of each other.
    audit : {"pixels", "queries"}, AuditPixels or AuditQueries, optional
        Lets exact rays answer some queries of an approximation as well, for `Frame.audit`: whole
        pixels for its rel_l1 and nrmse, or single queries for its bias and share of wrong answers.
        The image has the same bytes. Without, 256 pixels or fewer are audited in frames of the
        quantized cache; that is enough for warnings, but not for intervals.
    progress : bool or callable
        True shows a bar; a callable gets (done, total).

    Returns
    -------
    Frame
        Layers of light: "color", "emitted", and one per light group. The layers of `Bdpt` are
        weighted; it also has "connection" (surface with surface) and "camera" (light paths with the
        camera), and "emitted" has all lights that eye paths hit; "seen_emitters" is the part of it
        that the camera sees directly, or through mirrors and glass.

        Layers of the first hit, mirrors and glass included: "depth" (H, W, 1), distance from the
        camera in scene units; "normal" (H, W, 3), shading normal towards the camera; "albedo"
        (H, W, 3), base colour. They are means over the samples of the pixel that hit a surface, or
        0 without a hit, so normals at edges are shorter than 1. "coverage" (H, W, 1) is the share
        of samples that hit.

        `warnings` names light groups of the quantized cache for which exact visibility would have
        been cheaper, by the rays that were counted (docs/aqvc.md).

        Counters, timings, parameters and provenance. The counter "sha256" is that of the color
        layer. "lost_throughput" in [0, 1] bounds the light that is missing behind mirrors and
        glass, relative to the brightest light behind them.

    Raises
    ------
    ValueError
        A parameter is out of range; the message says what must hold.
    KeyboardInterrupt
        Within half a second of Ctrl-C.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> vc.render(scene, vc.Direct(), size=(32, 20)).image.shape
    (20, 32, 3)
    >>> frame = vc.render("slits", "direct", visibility="aqvc", size=(32, 20))
    """
    return render_part(
        scene,
        integrator,
        (0, 1),
        rays=rays,
        visibility=visibility,
        use=use,
        size=size,
        spp=spp,
        seed=seed,
        threads=threads,
        camera=camera,
        env=env,
        keep=keep,
        first_sample=first_sample,
        audit=audit,
        progress=progress,
    )


def render_part(
    scene: Scene | str | os.PathLike[str],
    integrator: Integrator | str,
    part: tuple[int, int],
    *,
    rays: Rays | str | None = None,
    visibility: Visibility | Written | str | None = None,
    use: Literal["replace", "correct"] | Correct | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    threads: int | None = None,
    camera: str | int | _core.Camera | None = None,
    env: Env | None = None,
    keep: AqvcTable | AqvcRows | VoxelCounts | None = None,
    first_sample: int = 0,
    audit: audits.Audit | Literal["pixels", "queries"] | None = None,
    progress: Progress = False,
    memory: PassMemory | None = None,
) -> Frame:
    """Part i of n of a frame: tiles i, i + n, i + 2n, ...; other tiles are black. As `render`.

    `viscache.tiles` joins parts. Every part traces the virtual lights again. `memory`: what passes
    of one picture hand on; its lights must be of this scene, integrator, size and seed.
    """
    scene = sources.opened(scene)
    integrator = cast(Integrator, by_name.setting("integrator", integrator))
    rays = check_rays(rays)
    visibility = cast("Visibility | Written", by_name.setting("visibility", visibility, "exact"))
    check_settings(scene, integrator, rays, visibility, use, keep)
    audit = audits.checked(audit)
    number, parts = _checked_part(part)
    if isinstance(integrator, Bdpt) and isinstance(visibility, Aqvc):
        visibility = visibility.for_frame_table()
    if isinstance(keep, AqvcTable) and isinstance(visibility, Aqvc):
        visibility = visibility.for_kept_table()
    request = Request(
        integrator=integrator,
        rays=rays,
        visibility=visibility,
        use=use,
        keep=keep is not None,
        keeps_rows=isinstance(keep, AqvcRows),
        keeps_voxels=isinstance(keep, VoxelCounts),
        first_sample=_checked_first(first_sample, spp),
        parts=parts,
        audit=audit,
    )
    check(request)
    if isinstance(integrator, AmbientOcclusion):
        integrator = integrator.within(scene.bounds)
    geometry = scene
    if env is not None:
        scene = scene.with_environment(env, threads=threads)
    view = find_camera(scene, camera)
    pixels = frame_size(size, view)
    frame = frame_settings(pixels, spp, seed, threads)
    spp, seed = int(spp), int(seed)  # numbers of NumPy overflow
    require_memory(scene, integrator, pixels, corrects=use not in (None, "replace"))
    frame.part, frame.parts = number, parts
    frame.first_sample = int(first_sample)
    if audit is None:
        frame.audit_pixels = watched_pixels(request, frame.width * frame.height)
    else:
        audits.set_audit(frame, audit)

    start, cpu = time.perf_counter(), time.process_time()
    caster = scene.caster(rays, threads=frame.threads)
    build_s = time.perf_counter() - start
    core = integrator.core() if isinstance(integrator, Bdpt) else eye_settings(integrator)
    batch = None
    if isinstance(visibility, Exact) and not isinstance(core, _core.BdptSettings):
        batch = _sky_batch(scene, geometry, request.environment, visibility)
    check(replace(request, batch=batch is not None))
    with ExitStack() as stack:
        report = stack.enter_context(progress_bar(progress))
        kept, rows, voxels = None, None, None
        if isinstance(keep, AqvcTable):
            table = stack.enter_context(keep._frame(scene, cast(Aqvc, visibility)))
            kept = (table, keep.check, keep.repair)
        elif isinstance(keep, VoxelCounts):
            voxels = stack.enter_context(keep._frame(scene, cast(NeePlusPlus, visibility)))
        elif keep is not None:
            rows = stack.enter_context(keep._frame(scene, cast(Aqvc, visibility)))
        context = SourceContext(
            scene=scene._core,
            caster=caster,
            spp=spp,
            # Oracles that draw at random do so anew for each first sample
            seed=seed_of(seed, "oracle", frame.first_sample),
            # Corrections draw independently in epochs of passes
            lasting_seed=seed_of(seed, "corrections", memory.epoch if memory else 0),
            batch=batch,
            shafts=shafts_for(geometry, visibility, rays),
            kept=kept,
            rows=rows,
            octaves=memory.octaves if memory else None,
            voxels=voxels,
            bidirectional=isinstance(integrator, Bdpt),
        )
        source = oracle_source(visibility, use, context)
        if isinstance(core, _core.BdptSettings):
            result = _core.render_bdpt(
                scene._core, caster, view, core, frame, source, progress=report
            )
        elif isinstance(visibility, VisMaps):
            result = render_with_maps(
                scene,
                geometry,
                rays,
                caster,
                view,
                core,
                frame,
                visibility,
                source,
                replace=use == "replace",
                progress=report,
            )
        else:
            result = _core.render_frame(
                scene._core,
                caster,
                view,
                core,
                frame,
                source,
                batch=_batch_for(scene, integrator, frame),
                field=_field_for(scene, integrator, frame),
                lights=memory.lights if memory else None,
                progress=report,
            )
    total_s, cpu_s = time.perf_counter() - start, time.process_time() - cpu

    timings: dict[str, float] = {"total_s": total_s, "cpu_s": cpu_s, "build_s": build_s}
    timings.update(result["timings"])
    # Wall time of a stage: its CPU seconds over the number of threads
    for stage in ("visibility", "shading"):
        timings[f"{stage}_s"] = timings[f"{stage}_cpu_s"] / result["threads"]
    made = Frame(
        layers=result["layers"],
        counters=result["counters"],
        timings=timings,
        parameters={
            "scene": scene.spec or scene.name,
            "scene_hash": scene.content_hash,
            "integrator": described(integrator),
            "rays": {"name": type(rays).__name__, **asdict(rays)},
            "visibility": {"name": type(visibility).__name__, **parameters_of(visibility)},
            "use": use_in_words(use, visibility),
            "size": [frame.width, frame.height],
            "spp": spp,
            "seed": seed,
            **({"first_sample": frame.first_sample} if frame.first_sample else {}),
            "camera": view.name,
            "tile_edge_px": result["tile_edge_px"],
            **({"engine": result["engine"]} if "engine" in result else {}),
            **({"keep": keep.parameters()} if keep is not None else {}),
            **({"audit": audits.in_words(audit)} if audit is not None else {}),
        },
        provenance={**provenance(), "threads": result["threads"]},
        warnings=_warnings(scene, integrator, visibility),
    )
    count_broken_pixels(made)
    found = result.get("audit")
    if found is None and audit is not None:
        found = nothing_found(list(made.counters["groups"]))
    if found is not None:
        watch = {"name": "AuditPixels", "n": frame.audit_pixels}
        found["settings"] = watch if audit is None else audits.in_words(audit)
    if frame.parts > 1:
        if found is not None:
            made.counters["audit_found"] = found
        made.parameters["part"] = [frame.part, frame.parts]
        made.counters["tile_sums"] = result.get("tile_sums", [])
    else:
        if found is not None:
            made.counters["audit"] = audit_record(found, made)
        made.warnings += cost_warnings(made.parameters, made.counters) + error_warnings(made)
    made.counters["sha256"] = made.sha256
    return made


def check_settings(
    scene: Any, integrator: Any, rays: Any, visibility: Any, use: Any, keep: Any
) -> None:
    """Check the type of every argument."""
    require(isinstance(scene, Scene), "scene must be a Scene", scene)
    known = f"integrator must be {classes('integrator')}"
    require(is_setting("integrator", integrator), known, integrator)
    require(
        is_setting("visibility", visibility) or is_written(visibility),
        f"visibility must be {classes('visibility')}, or an object with a method block",
        visibility,
    )
    check_rays(rays)
    fits = (
        use in (None, "replace", "correct")
        if isinstance(use, str | None)
        else (isinstance(use, Correct) and not isinstance(visibility, VisMaps))
    )
    require(
        fits,
        'use must be "replace" or "correct", or vc.Correct(...) unless visibility is VisMaps',
        use,
    )
    require(
        keep is None or isinstance(keep, AqvcTable | AqvcRows | VoxelCounts),
        "keep must be vc.AqvcTable(...), vc.AqvcRows(...) or vc.VoxelCounts()",
        keep,
    )


def seed_of(seed: int, purpose: str, number: int) -> int:
    """The seed of one of several draws from a seed: number 0 has the seed itself.

    A hash, so that no two seeds share a later one, however close they are.
    """
    if number == 0:
        return seed
    text = f"{seed} {purpose} {number}".encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little")


def use_in_words(use: Any, visibility: Any) -> Any:
    """How the approximation is used, as frames record it."""
    return in_words(use) or ("correct" if isinstance(visibility, VisMaps) else "replace")


def _checked_part(part: tuple[int, int]) -> tuple[int, int]:
    number, parts = part
    require(is_whole(parts) and 1 <= parts <= 1 << 20, "parts must be in [1, 2^20]", parts)
    require(is_whole(number) and 0 <= number < parts, "part must be in [0, parts)", number)
    return int(number), int(parts)


def _checked_first(first_sample: int, spp: int) -> int:
    whole = is_whole(first_sample) and 0 <= first_sample < 1 << 31
    require(whole, "first_sample must be a whole number in [0, 2^31)", first_sample)
    fits = not is_whole(spp) or spp < 1 or first_sample % spp == 0
    require(fits, f"first_sample must be a multiple of spp ({spp})", first_sample)
    return int(first_sample)


def _batch_for(
    scene: Scene, integrator: Integrator, frame: _core.FrameSettings
) -> _core.vlf.AlignedBatch | None:
    """The aligned batch for ambient occlusion along shared directions, or None."""
    if not isinstance(integrator, AmbientOcclusion) or integrator.directions != "shared":
        return None
    n_points = frame.width * frame.height * frame.spp
    t_max = integrator.core().max_distance or math.inf
    hopeless = integrator.engine == "auto" and _core.vlf.is_hopeless(scene._core, n_points, t_max)
    none = integrator.engine in ("embree", "field") or hopeless
    return None if none else scene.aligned_batch()


def _field_for(
    scene: Scene, integrator: Integrator, frame: _core.FrameSettings
) -> _core.vlf.VisibilityField | None:
    """The visibility field for shared directions, or None."""
    if not isinstance(integrator, AmbientOcclusion) or integrator.directions != "shared":
        return None
    if integrator.engine != "field":
        return None
    return scene.caster(Vlf(n_directions=integrator.n_samples), threads=frame.threads)


def _sky_batch(
    scene: Scene, geometry: Scene, environment: str, visibility: Exact
) -> _core.vlf.AlignedBatch | None:
    """The aligned batch for shared directions of lights, or None."""
    kinds = {light["kind"] for light in scene.lights}
    sky = environment == "shared"
    shared = "directional" in kinds or (sky and bool(kinds & {"constant", "environment"}))
    if visibility.sky_engine == "embree" or not shared:
        return None
    hopeless = _core.vlf.is_hopeless(scene._core, MOST_POINTS_OF_A_TILE)
    return None if visibility.sky_engine == "auto" and hopeless else geometry.aligned_batch()


def _warnings(scene: Scene, integrator: Integrator, visibility: Any) -> list[str]:
    texts = list(scene.warnings)
    if isinstance(integrator, AmbientOcclusion):
        texts = [w for w in texts if "no light" not in w]
    if isinstance(integrator, Bdpt):
        texts += lit_coats(scene._core)
    core = visibility.core() if isinstance(visibility, Aqvc) else None
    if core and core.c_n % 2 and core.normal_mode in ("round", "floor"):
        texts.append(
            f"odd c_n ({core.c_n}): grids stand oblique on axis-aligned walls and cost several "
            "times the rays of an even c_n"
        )
    return texts


def frame_settings(
    size: tuple[int, int], spp: int, seed: int, threads: int | None
) -> _core.FrameSettings:
    """The C++ settings of a frame, checked."""
    width, height = size
    cores = checked_threads(threads) or len(os.sched_getaffinity(0))
    return _core.FrameSettings(width=width, height=height, spp=spp, seed=seed, threads=cores)
