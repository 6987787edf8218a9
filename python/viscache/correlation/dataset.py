"""Converts results to an `xarray.Dataset`; saves and loads NetCDF files."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscache.base.formats import ArrayField, Format
from viscache.base.netcdf import write_netcdf
from viscache.base.provenance import provenance
from viscache.correlation.bins import Bins, Floats, centers
from viscache.correlation.derived import (
    LEVELS,
    correlation_lengths,
    high_correlation_box,
    predicted_variance_ratio,
)
from viscache.correlation.run import Counted
from viscache.correlation.statistics import Sums, statistics

if TYPE_CHECKING:
    import xarray

MEANINGS = {
    "mean": "mean correlation of visibility",
    "sigma": "population standard deviation of the pairs' correlations",
    "se": "standard error of the mean, jackknife over spatial groups",
    "se_naive": "sigma over the root of n, as if pairs were independent",
    "n": "pairs",
    "n_undefined": "pairs without a correlation: a point sees nothing",
    "variance_ratio": "mean of 1 - rho^2: variance left by a control variate",
}
#: The head is a line after the content: HDF5 may never come back from damaged files, so it gets
#: only what fits the hash.
FORMAT = Format(
    kind="a NetCDF file of correlation statistics",
    version=1,
    arrays={"content": ArrayField("u1", ("bytes",))},
)
#: Type and dimensions of what a file must have.
VARIABLES = {
    **dict.fromkeys(("mean", "sigma", "se"), ("f8", ("d", "theta"))),
    "n": ("i8", ("d", "theta")),
    **{name: ("f8", (name,)) for name in ("d", "theta")},
}
#: Record spacings of the table, as fractions of the end of the d bins.
SPACINGS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)


def to_dataset(counted: Counted, bins: Bins) -> xarray.Dataset:
    """Convert counted pairs to statistics.

    Returns
    -------
    xarray.Dataset
        On (d, theta): mean, sigma, se, se_naive, n, n_undefined, variance_ratio. On `theta_near`:
        the slice d < slice_d, as near_mean, near_sigma, … On `d_aligned`: the slice θ <
        slice_theta_deg, as aligned_mean, … The slices have their own bins. Coordinates are bin
        centres, with `_low` and `_high` limits, in scene units and degrees. `corner` is the mean
        over the pairs common to both slices. correlation_length on (level, theta): d at which ρ̄
        falls to the level. predicted_variance_ratio on (spacing,): for records with this spacing
        and normals within 10°. pair_share on (d,): fraction of all pairs that was counted; 1 where
        the pass was exhaustive. Attributes: box_d_max and box_theta_max_deg of the spatial maps,
        d_near, slice_d, slice_theta_deg, n_pairs, pairs_s, provenance.
    """
    import xarray

    table, exhaustive_to = _table(counted, bins)
    near, near_is_whole = _near_slice(counted, bins)
    aligned = table.merged(1, bins.theta_cells, np.array([0.0, bins.slice_theta_deg]))
    over_d = table.merged(0, bins.d_cells, bins.d_edges)
    variables = (
        _variables("", ("d", "theta"), over_d.merged(1, bins.theta_cells, bins.theta_edges_deg))
        | _variables(
            "near_",
            ("one", "theta_near"),
            near.merged(1, bins.theta_cells, bins.slice_theta_edges_deg),
        )
        | _variables(
            "aligned_", ("d_aligned", "one"), aligned.merged(0, bins.d_cells, bins.slice_d_edges)
        )
    )
    coordinates = (
        _coordinates("d", bins.d_edges, "scene units", bins.d_end)
        | _coordinates("theta", bins.theta_edges_deg, "degrees", None)
        | _coordinates("d_aligned", bins.slice_d_edges, "scene units", bins.d_end)
        | _coordinates("theta_near", bins.slice_theta_edges_deg, "degrees", None)
    )
    dataset = xarray.Dataset(variables).squeeze("one").assign_coords(coordinates)
    share = np.where(bins.d_edges[1:] <= exhaustive_to, 1.0, counted.far_share)
    dataset["pair_share"] = ("d", share)
    _add_corner(dataset, near, bins)
    _add_derived(dataset)
    box = high_correlation_box(dataset)
    return dataset.assign_attrs(
        {
            "box_d_max": box.d_max,
            "box_theta_max_deg": box.theta_max_deg,
            "box_mean": box.mean,
            "slice_d": bins.slice_d,
            "slice_theta_deg": bins.slice_theta_deg,
            "d_max": float(bins.d_end or 0.0),
            "d_near": counted.d_near or 0.0,
            "near_slice_exhaustive": int(near_is_whole),
            "far_share": counted.far_share,
            "n_pairs": counted.n_pairs,
            "pairs_s": counted.seconds,
            "n_groups": int(table.second.max()) + 1,
            "provenance": json.dumps(provenance()),
        }
    )


def _table(counted: Counted, bins: Bins) -> tuple[Sums, float]:
    """All cells, with near ones from the exhaustive pass; and the limit of that pass."""
    if counted.near is None or counted.d_near is None:
        return counted.far, np.inf if counted.far_share == 1.0 else 0.0
    # An edge shared by table and slice, so that no bin mixes the two passes
    shared = np.intersect1d(bins.d_edges, bins.slice_d_edges)
    edge = float(shared[shared <= counted.d_near].max(initial=0.0))
    n_cells = int(np.searchsorted(bins.d_cells, edge))
    return counted.far.with_near(counted.near, n_cells), edge


def _near_slice(counted: Counted, bins: Bins) -> tuple[Sums, bool]:
    """Pairs with d < slice_d in one bin of d and all cells of θ; True if all pairs were counted."""
    limits = np.array([0.0, bins.slice_d])
    if counted.near is not None and counted.d_near is not None and bins.slice_d <= counted.d_near:
        cells = bins.d_cells[bins.d_cells <= counted.d_near]
        return counted.near.merged(0, cells, limits), True
    return counted.far.merged(0, bins.d_cells, limits), counted.far_share == 1.0


def _add_corner(dataset: xarray.Dataset, near: Sums, bins: Bins) -> None:
    limits = np.array([0.0, bins.slice_theta_deg])
    found = statistics(near.merged(1, bins.theta_cells, limits))
    for name, value, text in (
        ("corner", found.mean, "mean correlation of pairs in both slices"),
        ("corner_se", found.se, "its standard error"),
        ("corner_n", found.n, "their number"),
    ):
        dataset[name] = ((), value.item(), {"long_name": text, "units": "1"})


def _variables(prefix: str, dims: tuple[str, str], sums: Sums) -> dict[str, Any]:
    found = statistics(sums)
    values = {
        "mean": found.mean,
        "sigma": found.sigma,
        "se": found.se,
        "se_naive": found.se_naive,
        "n": found.n,
        "n_undefined": found.n_undefined,
        "variance_ratio": 1.0 - found.mean_square,
    }
    return {
        prefix + name: (dims, value, {"long_name": MEANINGS[name], "units": "1"})
        for name, value in values.items()
    }


def _coordinates(name: str, edges: Floats, unit: str, end: float | None) -> dict[str, Any]:
    closed = edges.copy()
    if np.isinf(closed[-1]) and end is not None and end > closed[-2]:
        closed[-1] = end
    text = "distance of the points" if name.startswith("d") else "angle between the normals"
    attributes = {"units": unit, "long_name": text}
    return {
        name: (name, centers(closed), attributes),
        f"{name}_low": (name, edges[:-1], {"units": unit}),
        f"{name}_high": (name, edges[1:], {"units": unit}),
    }


def _add_derived(dataset: xarray.Dataset) -> None:
    unit = {"units": "scene units"}
    dataset.coords["level"] = ("level", np.array(LEVELS))
    dataset["correlation_length"] = (
        ("level", "theta"),
        correlation_lengths(dataset),
        unit | {"long_name": "distance at which the mean correlation falls to the level"},
    )
    ends = dataset["d_high"].values
    largest = float(ends[np.isfinite(ends)].max(initial=float(dataset["d"].values[-1])))
    spacing = np.array(SPACINGS) * largest
    dataset.coords["spacing"] = ("spacing", spacing, unit)
    theta = max(10.0, float(dataset["theta_high"].values[0]))
    dataset["predicted_variance_ratio"] = (
        "spacing",
        predicted_variance_ratio(dataset, spacing, theta),
        {
            "units": "1",
            "long_name": "variance left with records this far apart",
            "theta_max_deg": theta,
        },
    )


def save_dataset(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """Write a NetCDF file atomically: completely or not at all.

    Raises
    ------
    OSError
        The file cannot be written, as on a full disk. A file of before stays as it is.
    """
    write_netcdf(dataset, Path(path), _trailer)


def load_dataset(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Read a NetCDF file into memory.

    Raises
    ------
    ValueError
        The file does not hold correlation statistics, or not those that `save_dataset` wrote.
    """
    import xarray

    where = os.fspath(path)
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError as error:
        raise ValueError(f"no such file: {path}") from error
    start = content.rfind(b"\n", 0, -1)
    content, line = content[: max(start, 0)], content[start + 1 :]
    head = line if line.startswith(b"{") and line.endswith(b"\n") else None
    FORMAT.opened(where, head, {"content": np.frombuffer(content, np.uint8)})
    try:
        with xarray.open_dataset(io.BytesIO(content), engine="h5netcdf") as file:
            dataset = file.load()
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError) as error:
        raise FORMAT.refusal(where, error) from error
    for name, (dtype, dims) in VARIABLES.items():
        found = dataset.variables.get(name)
        if found is None or found.dtype != dtype or found.dims != dims:
            given = "none" if found is None else f"{found.dtype} {found.dims}"
            raise FORMAT.refusal(where, f"{name} must be {np.dtype(dtype)} {dims}, got {given}")
    return dataset


def _trailer(content: bytes) -> bytes:
    """The line after the content of a file."""
    head = FORMAT.sealed({}, {"content": np.frombuffer(content, np.uint8)})
    return f"\n{head}\n".encode()
