"""What a frame comes to: every argument resolved and checked, nothing traced."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from viscache import _core
from viscache.aqvc.rows import AqvcRows
from viscache.aqvc.table import AqvcTable
from viscache.frame.memory import require_memory
from viscache.oracles.correct import Correct, check_use
from viscache.oracles.written import is_written
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.settings import audit as audits
from viscache.settings.checks import is_whole, require
from viscache.settings.chosen_rays import check_rays
from viscache.settings.combinations import Request, check
from viscache.settings.integrators import AmbientOcclusion, Bdpt, eye_settings
from viscache.settings.registry import classes, is_setting
from viscache.settings.visibility import Aqvc, VisMaps
from viscache.shot.audited import watched_pixels
from viscache.shot.shot import BareShot, frame_settings
from viscache.shot.voxel_counts import VoxelCounts


@dataclass(frozen=True, kw_only=True)
class FramePlan:
    """What a frame, or a part of it, is rendered from.

    `request` has its settings, checked against each other. `scene` has the frame's environment,
    `geometry` is the scene as it was given.
    """

    request: Request
    scene: Scene
    geometry: Scene
    keep: AqvcTable | AqvcRows | VoxelCounts | None
    audit: audits.Audit | None
    view: _core.Camera
    frame: _core.FrameSettings
    core: _core.IntegratorSettings | _core.BdptSettings


def planned(
    shot: BareShot,
    part: tuple[int, int],
    *,
    keep: AqvcTable | AqvcRows | VoxelCounts | None,
    first_sample: int,
    audit: audits.Audit | Literal["pixels", "queries"] | None,
) -> FramePlan:
    """The plan of part i of n of a frame.

    ValueError if a parameter is out of range, or two of them do not work together.
    """
    geometry, use = shot.opened, shot.use
    integrator, rays, visibility = (shot.setting(r) for r in ("integrator", "rays", "visibility"))
    check_settings(geometry, integrator, rays, visibility, use, keep)
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
        first_sample=_checked_first(first_sample, shot.spp),
        parts=parts,
        audit=audit,
    )
    check(request)
    if isinstance(integrator, AmbientOcclusion):
        integrator = integrator.within(geometry.bounds)
        request = replace(request, integrator=integrator)
    scene = geometry
    if shot.env is not None:
        scene = geometry.with_environment(shot.env, threads=shot.threads)
    view = find_camera(scene, shot.camera)
    pixels = frame_size(shot.size, view)
    frame = frame_settings(pixels, shot.spp, shot.seed, shot.threads)
    require_memory(scene, integrator, pixels, corrects=use not in (None, "replace"))
    frame.part, frame.parts = number, parts
    frame.first_sample = request.first_sample
    if audit is None:
        frame.audit_pixels = watched_pixels(request, frame.width * frame.height)
    else:
        audits.set_audit(frame, audit)
    return FramePlan(
        request=request,
        scene=scene,
        geometry=geometry,
        keep=keep,
        audit=audit,
        view=view,
        frame=frame,
        core=integrator.core() if isinstance(integrator, Bdpt) else eye_settings(integrator),
    )


def check_settings(
    scene: Any, integrator: Any, rays: Any, visibility: Any, use: Any, keep: Any
) -> None:
    """Check the type of every argument."""
    require(isinstance(scene, Scene), "scene must be a Scene, a file or a built-in name", scene)
    known = f"integrator must be {classes('integrator')}"
    require(is_setting("integrator", integrator), known, integrator)
    require(
        is_setting("visibility", visibility) or is_written(visibility),
        f"visibility must be {classes('visibility')}, or an object with a method block",
        visibility,
    )
    check_rays(rays)
    check_use(use)
    maps = isinstance(use, Correct) and isinstance(visibility, VisMaps)
    require(not maps, 'use must be "replace" or "correct" with visibility maps', use)
    require(
        keep is None or isinstance(keep, AqvcTable | AqvcRows | VoxelCounts),
        "keep must be vc.AqvcTable(...), vc.AqvcRows(...) or vc.VoxelCounts()",
        keep,
    )


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
