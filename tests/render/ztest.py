"""Do two renderers have the same expectation? z-tests per pixel, per block and over the image.

Each side is a stack of images of independent seeds. A cell of the test is a pixel, an 8 × 8 block
or the whole image, of one channel; the variance of its mean is estimated from the seeds, so Welch's
t decides. The smallest p of all cells is corrected for their number (Šidák 1967).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

Images = npt.NDArray[np.float64]

#: A sound comparison falls below this once in a thousand seeds; tests fix theirs.
ALPHA = 1e-3
#: Differences that are rounding, relative to the cell and to the image.
ROUNDING = 2e-5


@dataclass(frozen=True)
class ZTest:
    """Outcome of a comparison."""

    p: float  #: smallest p of all cells, corrected for their number
    cells: int
    where: str  #: scale and place of the worst cell
    z: float  #: its signed t
    energy: float  #: relative difference of the image means

    @property
    def same(self) -> bool:
        return self.p >= ALPHA

    def __str__(self) -> str:
        worst = f"t = {self.z:.1f} at {self.where}"
        return f"p = {self.p:.2g} over {self.cells} cells, {worst}, energy {self.energy:+.4%}"


def _blocks(images: Images, edge: int) -> Images:
    """Means over edge × edge blocks; what does not fill a block is left out."""
    n, h, w, c = images.shape
    rows, columns = h // edge, w // edge
    cut = images[:, : rows * edge, : columns * edge]
    return cut.reshape(n, rows, edge, columns, edge, c).mean(axis=(2, 4))


def _t(a: Images, b: Images, tolerance: float) -> tuple[Images, Images]:
    """Welch's t and its degrees of freedom per cell; `tolerance` counts as noise of that size."""
    va, vb = a.var(axis=0, ddof=1) / len(a), b.var(axis=0, ddof=1) / len(b)
    difference = a.mean(axis=0) - b.mean(axis=0)
    rounding = tolerance * (np.abs(b.mean(axis=0)) + np.abs(b.mean()))
    # Noise far below rounding says nothing about a difference of that size
    variance = va + vb + rounding**2
    freedom = (va + vb) ** 2 / np.maximum(va**2 / (len(a) - 1) + vb**2 / (len(b) - 1), 1e-300)
    freedom = np.where((va + vb) > rounding**2, freedom, 1e9)
    return difference / np.sqrt(variance), np.maximum(freedom, 1.0)


def compare(
    ours: npt.ArrayLike, theirs: npt.ArrayLike, *, edge: int = 8, tolerance: float = ROUNDING
) -> ZTest:
    """Compare two stacks (seeds, H, W, C) of finite images.

    `tolerance` is a standard deviation allowed for known differences, relative to the cell and to
    the image.
    """
    a, b = np.asarray(ours, np.float64), np.asarray(theirs, np.float64)
    assert a.ndim == b.ndim == 4 and a.shape[1:] == b.shape[1:] and min(len(a), len(b)) >= 4
    assert np.isfinite(a).all() and np.isfinite(b).all()
    whole = (a.mean(axis=(1, 2), keepdims=True), b.mean(axis=(1, 2), keepdims=True))
    scales = {
        "pixel": (a, b),
        "block": (_blocks(a, edge), _blocks(b, edge)),
        "image": whole,
    }
    best = (np.inf, "", 0.0)
    cells = 0
    for name, (x, y) in scales.items():
        t, freedom = _t(x, y, tolerance)
        p = 2 * stats.t.sf(np.abs(t), freedom)
        cells += p.size
        worst = np.unravel_index(np.argmin(p), p.shape)
        best = min(
            best, (float(p[worst]), f"{name} {tuple(int(i) for i in worst)}", float(t[worst]))
        )
    corrected = float(-np.expm1(cells * np.log1p(-min(best[0], 1 - 1e-16))))
    energy = float(whole[0].mean() / whole[1].mean() - 1) if whole[1].mean() else 0.0
    return ZTest(corrected, cells, best[1], best[2], energy)
