"""Rendering: one call for every combination of integrator, rays and visibility."""

from __future__ import annotations

import hashlib
import math
import os
import time
from contextlib import ExitStack
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, Literal

from viscache import _core
from viscache.aqvc.rows import AqvcRows
from viscache.aqvc.table import AqvcTable
from viscache.base.progress import Progress, progress_bar
from viscache.base.provenance import provenance
from viscache.frame import Frame
from viscache.frame.frame import count_broken_pixels
from viscache.oracles.correct import use_in_words
from viscache.oracles.learned import PassMemory
from viscache.oracles.sources import oracle_source, parameters_of, shafts_for
from viscache.scene import Scene
from viscache.scene.about import lit_coats
from viscache.settings import audit as audits
from viscache.settings.combinations import check
from viscache.settings.integrators import AmbientOcclusion, Bdpt, Integrator, described
from viscache.settings.rays import Vlf
from viscache.settings.source_context import SourceContext
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Aqvc, Exact, VisMaps
from viscache.shot.audited import audit_record, error_warnings, nothing_found
from viscache.shot.exact_cost import cost_warnings
from viscache.shot.frame_plan import FramePlan, planned
from viscache.shot.shot import BareShot, ShotArguments, of_shot
from viscache.shot.voxel_counts import VoxelCounts
from viscache.vismap.rendering import render_with_maps

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: Eye samples of the largest tiles (render/tiles.h); mirrors may add some.
MOST_POINTS_OF_A_TILE = 1 << 16


@spelled
@of_shot()
def render(
    scene: Scene | str | os.PathLike[str],
    integrator: Integrator | str | None = None,
    *,
    keep: AqvcTable | AqvcRows | VoxelCounts | None = None,
    first_sample: int = 0,
    audit: audits.Audit | Literal["pixels", "queries"] | None = None,
    progress: Progress = False,
    **shot: Unpack[ShotArguments],
) -> Frame:
    """Render a frame.

    Parameters
    ----------
    scene, integrator, visibility, rays, use, size, spp, seed, threads, camera, env
        What to render: see `viscache.Shot`. The integrator is `vc.Direct()` by default, the rays
        `vc.Embree()`, the visibility exact.
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
        BareShot(scene, integrator, **shot),
        keep=keep,
        first_sample=first_sample,
        audit=audit,
        progress=progress,
    )


def render_part(
    shot: BareShot,
    part: tuple[int, int] = (0, 1),
    *,
    keep: AqvcTable | AqvcRows | VoxelCounts | None = None,
    first_sample: int = 0,
    audit: audits.Audit | Literal["pixels", "queries"] | None = None,
    progress: Progress = False,
    memory: PassMemory | None = None,
) -> Frame:
    """Part i of n of a frame: tiles i, i + n, i + 2n, ...; other tiles are black.

    `viscache.shot.tiles` joins parts. Every part traces the virtual lights again. `memory`: what
    passes of one picture hand on; its lights must be of this scene, integrator, size and seed.
    """
    plan = planned(shot, part, keep=keep, first_sample=first_sample, audit=audit)
    start, cpu = time.perf_counter(), time.process_time()
    caster = plan.scene.caster(plan.request.rays, threads=plan.frame.threads)
    build_s = time.perf_counter() - start
    with ExitStack() as stack:
        report = stack.enter_context(progress_bar(progress))
        source = _source(plan, caster, memory, stack)
        result = _traced(plan, caster, source, memory.lights if memory else None, report)
    times = {
        "total_s": time.perf_counter() - start,
        "cpu_s": time.process_time() - cpu,
        "build_s": build_s,
    }
    return _frame(plan, result, times)


def _source(
    plan: FramePlan, caster: _core.RayCaster, memory: PassMemory | None, stack: ExitStack
) -> _core.OracleSource:
    """The source of the frame's oracles; what is kept is in use until the stack is unwound."""
    request, frame, keep = plan.request, plan.frame, plan.keep
    batch = _sky_batch(plan)
    check(replace(request, batch=batch is not None))
    kept: Any = None
    if keep is not None:
        kept = stack.enter_context(keep._frame(plan.scene, request.visibility))
    context = SourceContext(
        scene=plan.scene._core,
        caster=caster,
        spp=frame.spp,
        # Oracles that draw at random do so anew for each first sample
        seed=seed_of(frame.seed, "oracle", frame.first_sample),
        # Corrections draw independently in epochs of passes
        lasting_seed=seed_of(frame.seed, "corrections", memory.epoch if memory else 0),
        batch=batch,
        shafts=shafts_for(plan.geometry, request.visibility, request.rays),
        kept=(kept, keep.check, keep.repair) if isinstance(keep, AqvcTable) else None,
        rows=kept if isinstance(keep, AqvcRows) else None,
        octaves=memory.octaves if memory else None,
        voxels=kept if isinstance(keep, VoxelCounts) else None,
        bidirectional=isinstance(request.integrator, Bdpt),
    )
    return oracle_source(request.visibility, request.use, context)


def _traced(
    plan: FramePlan,
    caster: _core.RayCaster,
    source: _core.OracleSource,
    lights: _core.KeptLights | None,
    report: Any,
) -> dict[str, Any]:
    """Layers, counters and timings from the core."""
    scene, request, frame = plan.scene, plan.request, plan.frame
    if isinstance(plan.core, _core.BdptSettings):
        return _core.render_bdpt(
            scene._core, caster, plan.view, plan.core, frame, source, progress=report
        )
    if isinstance(request.visibility, VisMaps):
        return render_with_maps(
            scene,
            plan.geometry,
            request.rays,
            caster,
            plan.view,
            plan.core,
            frame,
            request.visibility,
            source,
            replace=request.use == "replace",
            progress=report,
        )
    return _core.render_frame(
        scene._core,
        caster,
        plan.view,
        plan.core,
        frame,
        source,
        lights=lights,
        progress=report,
        **_of_shared_directions(scene, request.integrator, frame),
    )


def _frame(plan: FramePlan, result: dict[str, Any], times: dict[str, float]) -> Frame:
    """The frame that the core has traced, with all that is known of it."""
    scene, request, frame, audit = plan.scene, plan.request, plan.frame, plan.audit
    rays, visibility = request.rays, request.visibility
    timings = {**times, **result["timings"]}
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
            "integrator": described(request.integrator),
            "rays": {"name": type(rays).__name__, **asdict(rays)},
            "visibility": {"name": type(visibility).__name__, **parameters_of(visibility)},
            "use": use_in_words(request.use, visibility),
            "size": [frame.width, frame.height],
            "spp": frame.spp,
            "seed": frame.seed,
            **({"first_sample": frame.first_sample} if frame.first_sample else {}),
            "camera": plan.view.name,
            "tile_edge_px": result["tile_edge_px"],
            **({"engine": result["engine"]} if "engine" in result else {}),
            **({"keep": plan.keep.parameters()} if plan.keep is not None else {}),
            **({"audit": audits.in_words(audit)} if audit is not None else {}),
        },
        provenance={**provenance(), "threads": result["threads"]},
        warnings=_warnings(scene, request.integrator, visibility),
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


def seed_of(seed: int, purpose: str, number: int) -> int:
    """The seed of one of several draws from a seed: number 0 has the seed itself.

    A hash, so that no two seeds share a later one, however close they are.
    """
    if number == 0:
        return seed
    text = f"{seed} {purpose} {number}".encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little")


def _of_shared_directions(
    scene: Scene, integrator: Integrator, frame: _core.FrameSettings
) -> dict[str, Any]:
    """What traces the shared directions of ambient occlusion, if it is not Embree."""
    if not isinstance(integrator, AmbientOcclusion) or integrator.directions != "shared":
        return {}
    if integrator.engine == "field":
        rays = Vlf(n_directions=integrator.n_samples)
        return {"field": scene.caster(rays, threads=frame.threads)}
    n_points = frame.width * frame.height * frame.spp
    t_max = integrator.core().max_distance or math.inf
    hopeless = integrator.engine == "auto" and _core.vlf.is_hopeless(scene._core, n_points, t_max)
    none = integrator.engine == "embree" or hopeless
    return {} if none else {"batch": scene.aligned_batch()}


def _sky_batch(plan: FramePlan) -> _core.vlf.AlignedBatch | None:
    """The aligned batch for shared directions of lights, or None."""
    request, scene, visibility = plan.request, plan.scene, plan.request.visibility
    if not isinstance(visibility, Exact) or isinstance(request.integrator, Bdpt):
        return None
    kinds = {light["kind"] for light in scene.lights}
    sky = request.environment == "shared"
    shared = "directional" in kinds or (sky and bool(kinds & {"constant", "environment"}))
    if visibility.sky_engine == "embree" or not shared:
        return None
    hopeless = _core.vlf.is_hopeless(scene._core, MOST_POINTS_OF_A_TILE)
    return None if visibility.sky_engine == "auto" and hopeless else plan.geometry.aligned_batch()


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
