"""Do two renderers have the same expectation? z-tests per pixel, per block and over the image.

Each side is a stack of images of independent seeds. A cell of the test is a pixel, an 8 × 8 block
or the whole image, of one channel; the variance of its mean is estimated from the seeds, so Welch's
t decides. The smallest p of all cells is corrected for their number (Šidák 1967).
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from viscache.testing.student import ROUNDING, blocks, welch

#: A sound comparison falls below this once in a thousand seeds; tests fix theirs.
ALPHA = 1e-3


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
    scales = {"pixel": (a, b), "block": (blocks(a, edge), blocks(b, edge)), "image": whole}
    best = (np.inf, "", 0.0)
    cells = 0
    for name, (x, y) in scales.items():
        found = welch(x, y, tolerance)
        p, t = found.p, found.t
        cells += p.size
        worst = np.unravel_index(np.argmin(p), p.shape)
        where = f"{name} {tuple(int(i) for i in worst)}"
        best = min(best, (float(p[worst]), where, float(t[worst])))
    corrected = float(-np.expm1(cells * np.log1p(-min(best[0], 1 - 1e-16))))
    energy = float(whole[0].mean() / whole[1].mean() - 1) if whole[1].mean() else 0.0
    return ZTest(corrected, cells, best[1], best[2], energy)
