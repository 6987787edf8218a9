"""Small worlds over the sphere's map, where every integral is a sum that NumPy can do.

Maps are arrays in row-major order; `morton` brings cells into the order of the core.
"""

import numpy as np
import numpy.typing as npt

from reference.vismap import equal_area_directions
from viscache._core import MaterialKind
from viscache._core.sampling import ShadingPoint

Floats = npt.NDArray[np.floating]
Ints = npt.NDArray[np.integer]
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def luminance(rgb: Floats) -> npt.NDArray[np.float64]:
    """Rec. 709, in double."""
    return rgb.astype(np.float64) @ LUMINANCE


def morton(level: int) -> Ints:
    """Row-major numbers of the cells of a 2^level map in the order of the Morton curve."""
    z = np.arange(4**level)
    x = sum((z >> 2 * bit & 1) << bit for bit in range(level))
    y = sum((z >> 2 * bit + 1 & 1) << bit for bit in range(level))
    return np.asarray(y * 2**level + x)


def coarser(values: Floats, edge: int) -> Floats:
    """Sums over square blocks, down to edge × edge."""
    k = values.shape[0] // edge
    blocks = values.reshape(edge, k, edge, k, *values.shape[2:])
    return np.asarray(blocks.sum(axis=(1, 3)))


def sky(edge: int = 128, *, sun: float = 0.0, seed: int = 1) -> npt.NDArray[np.float32]:
    """A noisy blue sky with black patches and, in one texel, a sun."""
    rng = np.random.default_rng(seed)
    pixels = rng.uniform(0.2, 1.0, (edge, edge, 3)) * [0.5, 0.8, 1.0]
    pixels[: edge // 8, edge // 4 : edge // 2] = 0
    if sun:
        pixels[int(0.42 * edge), int(0.61 * edge)] = sun
    return pixels.astype(np.float32)


def directions(edge: int) -> Floats:
    """Centres of the texels, (edge, edge, 3)."""
    return equal_area_directions(edge).reshape(edge, edge, 3)


def surface(
    normal: tuple[float, float, float] = (0.3, -0.5, 0.81),
    *,
    glossy: bool = False,
    roughness: float = 0.2,
) -> ShadingPoint:
    """A point of a coloured surface seen at a slant."""
    n = np.asarray(normal) / np.linalg.norm(normal)
    tangent = np.cross(n, [0.0, 1.0, 0.2])
    wo = n + 0.9 * tangent / np.linalg.norm(tangent)
    return ShadingPoint(
        MaterialKind.GLOSSY if glossy else MaterialKind.DIFFUSE,
        tuple(wo / np.linalg.norm(wo)),
        ns=tuple(n),
        ng=tuple(n),
        base=(0.5, 0.4, 0.2),
        specular=(0.3, 0.3, 0.3),
        roughness=roughness,
    )


def cosine_lobe(edge: int, *, glossy: bool = True) -> npt.NDArray[np.float32]:
    """B = f·cos of a slanted surface as a table: a diffuse part and a narrow lobe."""
    d = directions(edge).astype(np.float64)
    normal = np.array([0.36, -0.48, 0.8])
    mirrored = np.array([-0.2, 0.7, 0.68])
    cosine = np.maximum(d @ normal, 0)
    lobe = np.maximum(d @ (mirrored / np.linalg.norm(mirrored)), 0) ** 40
    b = 0.5 / np.pi * cosine + (2.0 * lobe * (cosine > 0) if glossy else 0.0)
    return np.repeat(b[..., None], 3, axis=-1).astype(np.float32)


def grown(maps: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Every set cell with its eight neighbours on the sphere; maps (n, M, M)."""
    edge = maps.shape[1]
    found = np.zeros_like(maps)
    y, x = np.indices((edge, edge))
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            rows, columns = folded(y + dy, x + dx, edge)
            found |= maps[:, rows, columns]
    return found


def folded(y: Ints, x: Ints, edge: int) -> tuple[Ints, Ints]:
    """Where the square's borders continue."""
    out = (x < 0) | (x >= edge)
    x, y = (
        np.where(x < 0, -1 - x, np.where(x >= edge, 2 * edge - 1 - x, x)),
        np.where(out, edge - 1 - y, y),
    )
    out = (y < 0) | (y >= edge)
    y, x = (
        np.where(y < 0, -1 - y, np.where(y >= edge, 2 * edge - 1 - y, y)),
        np.where(out, edge - 1 - x, x),
    )
    return y, x


def dilations(maps: npt.NDArray[np.bool_]) -> list[npt.NDArray[np.bool_]]:
    """Grown by one cell, by a block of 2 × 2 and, from 64 × 64 cells on, by one of 4 × 4."""
    n, edge, _ = maps.shape
    levels = [maps]
    for k in (2, 4) if edge >= 64 else (2,):
        blocks = maps.reshape(n, edge // k, k, edge // k, k)
        levels.append(blocks.any(axis=(2, 4)))
    return [grown(level) for level in levels]


def blended(maps: npt.NDArray[np.bool_], beta: Floats, edge: int) -> npt.NDArray[np.float64]:
    """Σ β_i V_i over edge × edge texels."""
    mean = np.tensordot(beta.astype(np.float64), maps.astype(np.float64), axes=1)
    k = edge // maps.shape[1]
    return np.kron(mean, np.ones((k, k)))


def shares(n: int, seed: int = 0) -> npt.NDArray[np.float32]:
    """Random β, greater than zero with sum one."""
    beta = np.random.default_rng(seed).uniform(0.2, 1, n)
    return (beta / beta.sum()).astype(np.float32)
