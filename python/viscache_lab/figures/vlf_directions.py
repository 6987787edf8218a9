"""Beyond the visibility field's paper: ambient occlusion over the number of directions (X2)."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import images, lines
from viscache_lab.figures.bands import vlf as bands
from viscache_lab.figures.vlf_tracers import first_hits, free_bits, starts

COUNTS, QUICK_COUNTS = (9, 33, 129, 513, 2049), (9, 33, 129, 513)
#: X2: reference rays per point, uniform over the hemisphere, and the size of the points' picture.
REFERENCE, QUICK_REFERENCE = 16_384, 512
X2_SIZE, QUICK_X2_SIZE = (48, 48), (20, 20)
X2_TRIANGLES, QUICK_X2_TRIANGLES = 15_000, 3_000


@FIGURES.add("vlf-x2", "error of ambient occlusion over the number of directions")
def x2(trial: Trial) -> None:
    """Error of ambient occlusion by number of directions, with equal and solid-angle weights."""
    triangles = QUICK_X2_TRIANGLES if trial.quick else X2_TRIANGLES
    scene: vc.Scene = vc.scenes.bumpy_spheres(triangles=triangles)
    size = QUICK_X2_SIZE if trial.quick else X2_SIZE
    points, normals, seen = first_hits(scene, scene.cameras[0], size)
    reference = hemisphere_reference(
        scene, points, normals, QUICK_REFERENCE if trial.quick else REFERENCE
    )
    counts = QUICK_COUNTS if trial.quick else COUNTS
    errors: dict[str, dict[int, npt.NDArray[np.float64]]] = {"equal": {}, "solid angle": {}}
    for count in counts:
        free = free_bits(scene, points, normals, count)
        weights = vc.vlf.direction_weights(count).astype(float)
        errors["equal"][count] = free.mean(axis=1) - reference
        errors["solid angle"][count] = free @ weights / weights.sum() - reference
    rmse = {w: {n: _rms(e) for n, e in found.items()} for w, found in errors.items()}
    bias = {
        w: {n: float(e.mean() / reference.mean()) for n, e in found.items()}
        for w, found in errors.items()
    }
    trial.rows += _error_rows(counts, rmse, bias)
    points_of = {w: (counts, [rmse[w][n] for n in counts]) for w in errors}
    trial.draw("vlf-x2.png", lines(points_of, x="directions", y="RMSE"))
    shown = {"reference": reference} | {
        f"{n} directions": reference + e for n, e in errors["solid angle"].items()
    }
    panels = images({title: _image(values, seen) for title, values in shown.items()}, 1.0)
    trial.draw("vlf-x2-bands.png", [panels], (3.0 * len(panels), 3.2))
    trial.csv(
        "vlf-x2.csv",
        [
            {"n_directions": n, "weights": w, "rmse": rmse[w][n], "bias": bias[w][n]}
            for w in errors
            for n in counts
        ],
    )
    trial.notes.append(
        "All points share the directions, so the error is no noise but bands: vlf-x2-bands.png. "
        "Ambient occlusion is the uniform mean over the hemisphere, without the cosine, as in the "
        "paper's Section 7."
    )


def hemisphere_reference(
    scene: vc.Scene, points: npt.NDArray[np.float32], normals: npt.NDArray[np.float32], rays: int
) -> npt.NDArray[np.float64]:
    """Share of unoccluded directions among `rays` uniform random directions per point."""
    rng = np.random.default_rng(11)
    share = np.zeros(len(points))
    for i, (start, n) in enumerate(zip(starts(scene, points, normals), normals, strict=True)):
        d = rng.normal(size=(rays, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        d *= np.where(d @ n >= 0, 1, -1)[:, None]
        o = np.broadcast_to(start, d.shape)
        share[i] = 1 - scene.occluded(o, d.astype(np.float32)).mean()
    return share


def _rms(errors: npt.NDArray[np.float64]) -> float:
    return math.sqrt(float((errors**2).mean()))


def _error_rows(
    counts: tuple[int, ...], rmse: dict[str, dict[int, float]], bias: dict[str, dict[int, float]]
) -> list[Row]:
    rows = [
        Row(
            f"RMSE, {n} directions, {w} weights", rmse[w][n], note=f"bias {100 * bias[w][n]:+.2f} %"
        )
        for n in counts
        for w in rmse
    ]
    fine = [n for n in counts if n >= 33]
    sizes = {w: float(np.mean([abs(bias[w][n]) for n in fine])) for w in bias}
    weighted = "solid angle"
    return [
        *rows,
        Row(
            "RMSE, 513 directions over 33, solid-angle weights",
            rmse[weighted][513] / rmse[weighted][33],
            band=bands.ERROR_FALLS,
        ),
        Row(
            "bias, 513 directions, solid-angle weights",
            bias[weighted][513],
            band=bands.WEIGHTED_BIAS,
        ),
        Row(
            "size of the bias, solid-angle over equal weights",
            sizes[weighted] / sizes["equal"],
            band=bands.WEIGHTS_PAY,
        ),
    ]


def _image(values: npt.NDArray[np.float64], seen: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    image = np.zeros((*seen.shape, 1))
    image[seen, 0] = values
    return image
