"""Error that more passes do not remove: corrected passes beside exact ones of the same samples."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc

__all__ = ["differences", "energy_z", "persistent_z"]

Array = npt.NDArray[np.float64]

#: Edge of the blocks of pixels between which the standard error is taken.
BLOCK = 16
#: First passes of the two pictures: other blocks of samples.
FIRST = (0, 512)


def differences(
    scene: vc.Scene, light: Any, caches: dict[Any, Any], size: tuple[int, int], passes: int
) -> tuple[dict[str, Array], float]:
    """By use of a cache: passes minus exact ones of the same eye samples; and the mean light.

    The arrays are (pass, row, column, channel): of two pictures, half each, with what each learns
    from its first passes. Their draws are independent.
    """

    def both(visibility: Any, use: Any = None) -> Array:
        pictures = [
            vc.Progressive(scene, light, visibility=visibility, use=use, first_pass=n, size=size)
            for n in FIRST
        ]
        return np.concatenate([alone(p, passes // 2) for p in pictures])

    exact = both("exact")
    found = {use: both(cache, use) - exact for use, cache in caches.items()}
    return found, float(exact.mean())


def alone(picture: vc.Progressive, passes: int) -> Array:
    """Each pass by itself."""
    sums = [picture.passes(1).image.astype(np.float64) * (i + 1) for i in range(passes)]
    return np.diff(np.stack([np.zeros_like(sums[0]), *sums]), axis=0)


def energy_z(found: Array) -> float:
    """The mean difference of the energy in its standard errors, by the spread between passes."""
    energies = found.mean(axis=(1, 2, 3))
    error = float(energies.std(ddof=1)) / math.sqrt(len(energies))
    return float(energies.mean()) / max(error, 1e-300)


def persistent_z(found: Array, light: float) -> tuple[float, float]:
    """Squared bias of pixels over the squared mean light, and how many standard errors it is.

    The first half times the second: their noise is independent, and what both have is the bias.
    """
    half = len(found) // 2
    product = found[:half].mean(axis=0) * found[half:].mean(axis=0) / light**2
    h, w = (n // BLOCK for n in product.shape[:2])
    cut = product[: h * BLOCK, : w * BLOCK].reshape(h, BLOCK, w, BLOCK, -1)
    blocks = cut.mean(axis=(1, 3, 4)).ravel()
    error = float(blocks.std(ddof=1)) / math.sqrt(len(blocks))
    return float(blocks.mean()), float(blocks.mean()) / max(error, 1e-300)
