"""Chi-squared tests of samplers against their densities, and integrals of densities."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import stats

Floats = npt.NDArray[np.floating]
Density = Callable[[Floats], Floats]


def uniforms(n: int, dims: int, seed: int = 1) -> npt.NDArray[np.float32]:
    """Random points in [0, 1), (n, dims), from NumPy's generator, not from the code under test."""
    return np.random.default_rng(seed).random((n, dims), dtype=np.float32)


def p_value(counts: Floats, expected: Floats) -> float:
    """Pearson's test; bins that expect fewer than five samples are joined."""
    counts, expected = counts.ravel().astype(float), expected.ravel().astype(float)
    assert abs(counts.sum() / expected.sum() - 1) < 0.02, "the density must integrate to one"
    rare = expected < 5
    rare_count, rare_expected = counts[rare].sum(), expected[rare].sum()
    c, e = counts[~rare], expected[~rare]
    if rare_expected >= 5:
        c, e = np.append(c, rare_count), np.append(e, rare_expected)
    elif rare_count > 25:
        return 0.0  # many samples where there should be next to none
    return float(stats.chi2.sf(((c - e) ** 2 / e).sum(), max(1, e.size - 1)))


def sphere_points(n_z: int, n_phi: int, z_range: tuple[float, float]) -> Floats:
    """Midpoints of the cells of equal solid angle in (z, phi), (n_z, n_phi, 3)."""
    z = z_range[0] + (np.arange(n_z) + 0.5) / n_z * (z_range[1] - z_range[0])
    phi = (np.arange(n_phi) + 0.5) / n_phi * 2 * np.pi
    r = np.sqrt(1 - z**2)
    return np.stack(
        [np.outer(r, np.cos(phi)), np.outer(r, np.sin(phi)), np.repeat(z[:, None], n_phi, 1)], -1
    )


def sphere_mass(
    density: Density, bins: tuple[int, int], z_range: tuple[float, float] = (-1, 1), sub: int = 8
) -> Floats:
    """Integrals of a density per solid angle over bins of (z, phi), each by sub × sub midpoints."""
    n_z, n_phi = bins
    points = sphere_points(n_z * sub, n_phi * sub, z_range).reshape(-1, 3)
    values = np.asarray(density(points.astype(np.float32)), dtype=float)
    solid_angle = (z_range[1] - z_range[0]) * 2 * np.pi / points.shape[0]
    return values.reshape(n_z, sub, n_phi, sub).sum((1, 3)) * solid_angle


def sphere_p_value(
    directions: Floats,
    density: Density,
    bins: tuple[int, int] = (16, 32),
    z_range: tuple[float, float] = (-1, 1),
    sub: int = 8,
    n_samples: int | None = None,
) -> float:
    """Chi-squared of directions; samples missing from `n_samples` fill a bin of their own."""
    n = n_samples or len(directions)
    mass = sphere_mass(density, bins, z_range, sub)
    x, y, z = np.asarray(directions, dtype=float).T
    counts = np.histogram2d(z, np.arctan2(y, x) % (2 * np.pi), bins, [z_range, (0, 2 * np.pi)])[0]
    expected = n * mass
    if n_samples is not None:
        counts = np.append(counts.ravel(), n - counts.sum())
        expected = np.append(expected.ravel(), max(0.0, n * (1 - mass.sum())))
    return p_value(counts, expected)
