"""Virtual point lights of the caller's own."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from viscache.settings.checks import checked_floats, require
from viscache.settings.spelling import spelled


@spelled
class Vpls:
    """Virtual point lights that `Whitted(vpls=...)` takes as they are, in place of traced ones.

    Parameters
    ----------
    positions, normals : (M, 3) float
        On surfaces, scene units, and the side they shine on; normals are scaled to length 1.
    flux : (M, 3) or (M,) float >= 0
        Reflected radiant exitance × area / π, linear RGB: a light brings f · flux · cos · cos' /
        (d² + bound²) to a point at distance d.

    Raises
    ------
    ValueError
        Shapes that do not fit, values that are not finite.

    Examples
    --------
    >>> import viscache as vc
    >>> own = vc.Vpls([(0, 3, 0)], [(0, -1, 0)], [(5, 5, 5)])
    >>> len(own), vc.Whitted(vpls=own).n_vpls
    (1, 1024)
    """

    def __init__(self, positions: Any, normals: Any, flux: Any) -> None:
        self.positions = _rows(positions, "positions")
        self.normals = _rows(normals, "normals")
        lengths = np.linalg.norm(self.normals, axis=1, keepdims=True)
        require(bool((lengths > 0).all()), "normals must not be zero", "one that is")
        self.normals = (self.normals / lengths).astype(np.float32)
        flux = checked_floats(flux, "flux")
        self.flux = _rows(np.repeat(flux[:, None], 3, 1) if flux.ndim == 1 else flux, "flux")
        require(bool((self.flux >= 0).all()), "flux must be >= 0", "a value below")
        count = len(self.positions)
        same = len(self.normals) == count and len(self.flux) == count
        require(
            same, f"normals and flux must have {count} rows", (len(self.normals), len(self.flux))
        )
        joined = b"".join(a.tobytes() for a in (self.positions, self.normals, self.flux))
        self.content_hash = hashlib.sha256(joined).hexdigest()[:16]

    def __len__(self) -> int:
        return len(self.positions)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Vpls) and self.content_hash == other.content_hash

    def __hash__(self) -> int:
        return hash(self.content_hash)

    def __repr__(self) -> str:
        return f"Vpls({len(self)} lights, {self.content_hash})"

    def __deepcopy__(self, memo: dict[int, Any]) -> Vpls:
        return self


def _rows(values: Any, name: str) -> np.ndarray[Any, np.dtype[np.float32]]:
    rows = np.array(checked_floats(values, name))
    require(rows.ndim == 2 and rows.shape[1] == 3, f"{name} must have shape (M, 3)", rows.shape)
    require(bool(np.isfinite(rows).all()), f"{name} must be finite", "values that are not")
    rows.setflags(write=False)
    return rows
