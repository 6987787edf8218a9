"""Figure 11 of the visibility-map paper: the control variate's integral as a preview."""

from __future__ import annotations

import numpy as np

import viscache as vc
from viscache.base.tonemap import auto_exposure, luminance, srgb_curve
from viscache.scenes.garage import sky_image
from viscache_lab.experiment import FIGURES, Trial
from viscache_lab.experiment.drawing import images
from viscache_lab.figures import vismap_printed as printed
from viscache_lab.figures.bands import vismap as bands
from viscache_lab.figures.vismap_records import VIEWS

#: The reference has four eye samples per pixel with this many light samples each.
SIZE, SAMPLES = (640, 480), 64
QUICK_SIZE, QUICK_SAMPLES = (80, 60), 32
#: The environment is rotated about the vertical by these angles.
TURNS_DEG = (0.0, 45.0, 180.0, 270.0)


@FIGURES.add("vismap-fig11", "the control variate's integral as a preview")
def figure11(trial: Trial) -> None:
    """Preview and reference of the garage, and the preview under rotated light, without rays."""
    scene, size = VIEWS["garage"].open(trial.quick), QUICK_SIZE if trial.quick else SIZE
    samples = QUICK_SAMPLES if trial.quick else SAMPLES
    cache = vc.VisibilityMapCache(scene)
    design = vc.Relighting(cache, size=size)
    traced, sky = cache.rays, sky_image()
    previews = [design.under(sky, rotation_deg=turn) for turn in TURNS_DEG]
    rays = sum(frame.counters["rays"] for frame in previews) + cache.rays - traced
    reference = trial.exact_frames()(
        scene,
        vc.Direct(n_environment=samples, n_brdf=samples),
        size=size,
        spp=4,
        progress=trial.progress,
    )
    trial.row("records", len(cache), printed=printed.PREVIEW_RECORDS)
    trial.row(
        "rays traced for lights that are turned", rays, printed="none", band=bands.PREVIEW_RAYS
    )
    trial.row(
        "correlation of displayed luminance, preview with reference",
        alike(previews[0], reference),
        printed="good enough",
        band=bands.PREVIEW_LOOKS_ALIKE,
    )
    trial.row(
        "seconds of a preview",
        previews[-1].timings["total_s"],
        note=f"{size[0]}x{size[1]}; the reference {reference.timings['total_s']:.3g} s",
    )
    shown = {"reference": reference, "preview": previews[0]}
    shown |= {f"turned by {d:g}°": f for d, f in zip(TURNS_DEG[1:], previews[1:], strict=True)}
    exposure = auto_exposure(reference.image, 95.0)
    trial.draw("vismap-fig11.png", [images(shown, exposure)], (4.0 * len(shown), 3.4), dpi=150)


def alike(preview: vc.Frame, reference: vc.Frame) -> float:
    """Pearson correlation of displayed luminance, of pixels that see only surfaces."""
    surface = reference.layers["coverage"][:, :, 0] == 1
    exposure = auto_exposure(reference.image, 95.0)
    shown = [srgb_curve(luminance(f.image) * exposure)[surface] for f in (preview, reference)]
    return float(np.corrcoef(*shown)[0, 1])
