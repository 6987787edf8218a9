"""Frames have the expectation of the exact ones: a test that knows what it could have seen."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.real_numbers import real_array
from viscache.metrics import Comparable
from viscache.settings.checks import is_number, require
from viscache.settings.spelling import spelled
from viscache.testing import student
from viscache.testing.advice import is_paired
from viscache.testing.failure import PictureError, lines, told

Floats = npt.NDArray[np.float64]

#: Edge of the blocks in pixels.
BLOCK_PX = 32


@dataclass(frozen=True, kw_only=True, slots=True)
class Bias:
    """How far the mean of frames is from the exact ones, and what the test could see."""

    energy: float
    """Σ(frames - exact) / Σexact of the means."""
    interval: tuple[float, float]
    """Its 95 % interval (Student's t)."""
    t: float
    """The energy over its standard error."""
    detectable: float
    """The bias of the energy that the test finds with probability `power`, either way."""
    power: float
    """That probability."""
    block: tuple[int, int]
    """Row and column of the pixel in the middle of the block with the t furthest from 0."""
    block_energy: float
    """Relative difference of that block, in the channel with the t furthest from 0."""
    block_t: float
    """Its t."""
    block_detectable: float
    """The relative bias of a block that the test finds with probability `power`: the median."""
    blocks: int
    """Number of blocks, of one channel."""
    frames: int
    """Number of frames."""
    paired: bool
    """Whether frame i was compared with exact frame i, which has the same seed."""
    energy_p: float
    """Two-sided p of the energy."""
    block_p: float
    """Of the worst block, corrected for the number of blocks and channels (Šidák 1967)."""

    @property
    def p(self) -> float:
        """Of both tests together."""
        return min(1.0, 2 * min(self.energy_p, self.block_p))

    def __str__(self) -> str:
        low, high = self.interval
        return (
            f"energy {self.energy:+.3%} (95 %: {low:+.3%} to {high:+.3%}), p = {self.p:.2g};"
            f" {self.frames} frames find a bias of {self.detectable:.2%} of the energy, or"
            f" {self.block_detectable:.2%} of a block, with probability {self.power:g}"
        )


@spelled
def assert_unbiased(
    frames: Sequence[Comparable],
    exacts: Sequence[Comparable] | Comparable,
    *,
    energy: float = 0.01,
    alpha: float = 1e-3,
    power: float = 0.99,
    paired: bool | None = None,
) -> Bias:
    """Raise an AssertionError if frames are biased, or too few to know.

    The energy of the whole picture and the means of its blocks of 32 × 32 pixels are compared by
    Student's t over frames. Single pixels are not: their noise has heavy tails if few rays carry
    large weights.

    Parameters
    ----------
    frames : sequence of Frame or (H, W, C) array
        At least two, of different seeds.
    exacts : sequence of the same, or one picture
        Exact frames. One picture: a converged one, whose own noise does not count.
    energy : float in (0, 1)
        The bias that the test must be able to see, as a share of the energy.
    alpha : float in (0, 0.5)
        Share of sound comparisons that fail, if seeds are drawn at random. Half of it is for the
        energy, half for all blocks and channels together (Šidák 1967).
    power : float in (0.5, 1)
        Probability with which a bias of `energy` must be found.
    paired : bool, optional
        Whether frame i and exact frame i have the same seed, so that the noise they share cancels.
        By default known from the frames' parameters; False for arrays.

    Returns
    -------
    Bias
        What was found, and which bias would have been.

    Raises
    ------
    PictureError
        An AssertionError: the frames are biased; or noise would have hidden a bias of `energy`, and
        the message says how many frames it takes; or sizes differ, or pixels are not finite.
    ValueError
        Frames that are not independent, or a black reference.

    Notes
    -----
    Standard errors are at least 2e-5 of the picture, because sums of single precision differ by
    rounding. The power follows from the noise that was measured (noncentral t).

    Examples
    --------
    >>> import viscache as vc
    >>> scene, size = vc.scenes.cube_on_plane(), (32, 20)
    >>> exact = [vc.render(scene, vc.Direct(), size=size, seed=s) for s in range(8)]
    >>> cache = {"visibility": vc.Unoccluded(), "use": vc.Correct(share=0.5), "size": size}
    >>> frames = [vc.render(scene, vc.Direct(), seed=s, **cache) for s in range(8)]
    >>> vc.testing.assert_unbiased(frames, exact, energy=0.05).paired
    True
    """
    __tracebackhide__ = True
    for name, value, low, high in (
        ("energy", energy, 0, 1),
        ("alpha", alpha, 0, 0.5),
        ("power", power, 0.5, 1),
    ):
        fits = is_number(value) and low < value < high
        require(fits, f"{name} must be in ({low}, {high})", value)
    many = isinstance(exacts, (list, tuple)) or (
        isinstance(exacts, np.ndarray) and exacts.ndim == 4
    )
    references: list[Any] = list(exacts) if many else [exacts]  # type: ignore[arg-type]
    a, b = _stack(list(frames), "frames"), _stack(references, "exacts")
    _check(a, b)
    if paired is None:
        paired = len(a) == len(b) and all(map(is_paired, frames, references))
    require(not paired or len(a) == len(b), "pairs must be as many", (len(a), len(b)))
    found, whole = _bias(a, b, alpha, power, paired)
    if found.p < alpha or found.detectable > energy:
        if found.p < alpha:
            head, tips = _says_biased(found, alpha)
        else:
            wanted = energy * float(b.sum(axis=(1, 2, 3)).mean())
            need = student.frames_for(wanted, float(whole.error), len(a), alpha / 2, power)
            head, tips = _says_weak(found, energy, need)
        numbers = _numbers(found)
        rows = {**numbers, "first frame": told(frames[0]), "first exact": told(references[0])}
        means = (a.mean(axis=0), b.mean(axis=0))
        raise PictureError(lines(head, rows, tips), means[0], means[1], numbers)
    return found


def _stack(images: list[Comparable], name: str) -> Floats:
    """(N, H, W, C) of finite pictures of one size, without alpha."""
    require(bool(images), f"{name} must be at least one picture", "none")
    given = [real_array(getattr(image, "image", image), name) for image in images]
    planes = [pixels.astype(np.float64) for pixels in given]
    shapes = {plane.shape for plane in planes}
    if len(shapes) > 1:
        raise PictureError(f"{name} must be pictures of one size, got {sorted(shapes)}")
    stack = np.stack(planes)
    stack = stack[..., None] if stack.ndim == 3 else stack[..., : 3 if stack.shape[-1] > 2 else 1]
    require(stack.ndim == 4, f"{name} must have shape (H, W, C)", planes[0].shape)
    bad = np.flatnonzero(~np.isfinite(stack).all(axis=(1, 2, 3)))
    if len(bad):
        raise PictureError(f"{name} must be finite, got pixels that are not in number {bad[0]}")
    return stack


def _check(a: Floats, b: Floats) -> None:
    if a.shape[1:] != b.shape[1:]:
        shapes = f"{a.shape[1:]} and {b.shape[1:]}"
        raise PictureError(f"frames and exacts must have one size, got {shapes}")
    require(len(a) >= 2, "frames must be at least 2", len(a))
    known: dict[bytes, int] = {}
    for number, image in enumerate(a):
        first = known.setdefault(hashlib.sha256(image.tobytes()).digest(), number)
        what = "frames must be independent (have different seeds, and noise)"
        require(first == number, what, f"the same picture as numbers {first} and {number}")
    require(float(b.sum()) > 0, "exacts must not be black", float(b.sum()))


def _bias(
    a: Floats, b: Floats, alpha: float, power: float, paired: bool
) -> tuple[Bias, student.Difference]:
    """What is found, and the difference of the energies."""
    from scipy.stats import t  # type: ignore[import-untyped,unused-ignore]

    whole = student.difference(a.sum(axis=(1, 2, 3)), b.sum(axis=(1, 2, 3)), paired=paired)
    level = float(b.sum(axis=(1, 2, 3)).mean())
    cells_a, cells_b = (student.blocks(stack, BLOCK_PX) for stack in (a, b))
    cells = student.difference(cells_a, cells_b, paired=paired)
    p = cells.p
    where = tuple(int(i) for i in np.unravel_index(int(np.argmin(p)), p.shape))
    worst = float(-np.expm1(p.size * np.log1p(-min(float(p.min()), 1 - 1e-16))))
    each = float(-np.expm1(np.log1p(-alpha / 2) / p.size))
    base = cells_b.mean(axis=0)
    lit = base > 1e-3 * base.max()
    noise = float(np.median((cells.error / np.maximum(base, 1e-300))[lit]))
    usual = float(np.median(cells.freedom))
    half = float(t.ppf(0.975, whole.freedom) * whole.error) / level
    share = float(whole.value) / level
    row, column = (int((where[i] + 0.5) * a.shape[1 + i] / p.shape[i]) for i in range(2))
    found = Bias(
        energy=share,
        interval=(share - half, share + half),
        t=float(whole.t),
        detectable=student.detectable(float(whole.error), float(whole.freedom), alpha / 2, power)
        / level,
        power=power,
        block=(row, column),
        block_energy=float(cells.value[where] / max(base[where], 1e-300)),
        block_t=float(cells.t[where]),
        block_detectable=student.detectable(noise, usual, each, power),
        blocks=p.shape[0] * p.shape[1],
        frames=len(a),
        paired=paired,
        energy_p=float(whole.p),
        block_p=worst,
    )
    return found, whole


def _numbers(found: Bias) -> dict[str, str]:
    low, high = found.interval
    return {
        "energy": f"{found.energy:+.4%} (95 %: {low:+.4%} to {high:+.4%}), t = {found.t:.2f}",
        "worst block": f"{found.block_energy:+.2%} around row {found.block[0]}, column"
        f" {found.block[1]} of {found.blocks} blocks, t = {found.block_t:.2f}",
        "power": f"{found.frames} {'pairs' if found.paired else 'frames'} find a bias of"
        f" {found.detectable:.2%} of the energy with probability {found.power:g}",
    }


def _says_biased(found: Bias, alpha: float) -> tuple[str, list[str]]:
    where = "their energy" if 2 * found.energy_p < alpha else "a block of the picture"
    return f"the frames are biased in {where}: p = {found.p:.2g}", [
        "a bias stays where more frames are rendered, and t grows with their root;"
        " where rare rays carry large weights, t falls again",
        'a cache that replaces visibility is biased; use="correct" is not',
    ]


def _says_weak(found: Bias, wanted: float, need: int) -> tuple[str, list[str]]:
    head = (
        f"the test is too weak: it must find a bias of {wanted:.2%} of the energy, and finds"
        f" one of {found.detectable:.2%} with probability {found.power:g}"
    )
    tips = [f"about {need} frames, or more samples for each"]
    if not found.paired:
        tips.append("exact frames of the same seeds: the noise that both share cancels")
    return head, [*tips, f"a larger energy=, of which this test finds {found.detectable:.2g}"]
