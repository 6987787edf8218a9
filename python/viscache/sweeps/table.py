"""The table of a sweep: rows for CSV, a dataset for xarray."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache.base.netcdf import write_netcdf
from viscache.sweeps.csv_file import append_csv, write_csv
from viscache.sweeps.plan import Point
from viscache.sweeps.store import Record, Store, picture_name

if TYPE_CHECKING:
    import xarray

#: Folders whose tables this process made. A dataset that came as a file may name any folder.
_FOLDERS: set[str] = set()

#: What is measured of a frame beside its errors, in the order of the columns, with units.
MEASURED = {
    **dict.fromkeys(("rays", "queries", "ray_reduction"), "1"),
    **dict.fromkeys(("total_s", "visibility_s", "cpu_s", "exact_total_s", "exact_cpu_s"), "s"),
    "exact_rays": "",
    **dict.fromkeys(("speedup", "cpu_speedup"), "1"),
    "alone": "",
}


def table_rows(store: Store) -> list[dict[str, Any]]:
    """One row per finished point and repeat: setting, seed, metrics, counts, times."""
    definition = store.definition()
    rows = (row_of(store, point, definition["metrics"]) for point in definition["points"])
    return [row for row in rows if row is not None]


def row_of(store: Store, point: Mapping[str, Any], metrics: Sequence[str]) -> dict[str, Any] | None:
    """The row of a point as the definition has it; None where it is not finished."""
    record, paired = store.get(point["key"]), store.get(point["paired"])
    if record is None or paired is None:
        return None
    known = store.compared(point["key"], point["paired"])
    if not all(m in known for m in metrics):
        return None
    row = {**point["values"], "repeat": point["repeat"], "seed": point["seed"]}
    row |= {m: known[m] for m in metrics}
    if point["converged"] is not None:
        total = store.compared(point["key"], point["converged"])
        exact = store.compared(point["paired"], point["converged"])
        row |= {f"converged_{m}": total.get(m) for m in metrics}
        row |= {f"exact_converged_{m}": exact.get(m) for m in metrics}
    row |= _measured(record, paired)
    row |= {name: v for name, v in known.items() if "/" in name}
    return {**row, "frame": picture_name(record.key), "key": record.key}


class TableFile:
    """`table.csv` of a running sweep.

    The file is rewritten at the beginning and at the end, in the order of the plan. In between,
    rows are appended as points are finished.
    """

    def __init__(self, store: Store, names: Sequence[str], metrics: Sequence[str]) -> None:
        self._store, self._names, self._metrics = store, names, metrics
        self._columns: list[str] = []

    def rewrite(self) -> None:
        """Rewrite all rows, atomically."""
        if self._store.directory is None:
            return
        rows = table_rows(self._store)
        columns = columns_of(rows, self._names, self._metrics)
        self._columns = columns if rows else []
        write_csv(self._store.directory / "table.csv", rows, columns)

    def append(self, point: Point) -> None:
        """Add the row of a finished point; one with a new column rewrites the file."""
        if self._store.directory is None:
            return
        row = row_of(self._store, asdict(point), self._metrics)
        if row is None or not set(row) <= set(self._columns):
            self.rewrite()
        else:
            append_csv(self._store.directory / "table.csv", row, self._columns)


def _measured(record: Record, paired: Record) -> dict[str, Any]:
    """Counts and times of a frame, and its speed-up over the exact one."""
    counters, timings = record.counters, record.timings
    total, exact = _frame_time(timings), _frame_time(paired.timings)
    rays, queries = counters.get("rays"), counters.get("queries")
    row = {
        "rays": rays,
        "queries": queries,
        "ray_reduction": _ratio(queries, rays),
        "total_s": total,
        "visibility_s": timings.get("visibility_s"),
        "cpu_s": timings.get("cpu_s"),
        "exact_total_s": exact,
        "exact_cpu_s": paired.timings.get("cpu_s"),
        "exact_rays": paired.counters.get("rays"),
        "speedup": _ratio(exact, total),
        "cpu_speedup": _ratio(paired.timings.get("cpu_s"), timings.get("cpu_s")),
        "alone": int(all(r.provenance.get("alone", False) for r in (record, paired))),
    }
    for group, counts in counters.get("groups", {}).items():
        row |= {f"{name}/{group}": counts.get(name) for name in ("rays", "queries")}
    return row


def _ratio(a: float | None, b: float | None) -> float | None:
    return a / b if a is not None and b else None


def _frame_time(timings: Mapping[str, float]) -> float | None:
    """Wall time without building the ray caster, which only a scene's first frame pays."""
    total = timings.get("total_s")
    return None if total is None else total - timings.get("build_s", 0.0)


def columns_of(
    rows: Sequence[Mapping[str, Any]], names: Sequence[str], metrics: Sequence[str]
) -> list[str]:
    """Columns in a fixed order; per-group ones read `rays/vpl`."""
    first = [*names, "repeat", "seed", *metrics]
    seen = dict.fromkeys(column for row in rows for column in row)
    fixed = [*first, *MEASURED]
    late = [c for c in seen if c not in fixed and c not in ("frame", "key")]
    return [*fixed, *late, "frame", "key"]


def to_dataset(names: Sequence[str], store: Store) -> xarray.Dataset:
    """The table as a dataset; points that are not finished are NaN."""
    import numpy as np
    import xarray

    definition = store.definition()
    rows = {row["key"]: row for row in table_rows(store)}
    coords = {n: (dim, _coordinate(values)) for n, (dim, values) in definition["coords"].items()}
    lengths = {dim: len(values) for dim, values in definition["coords"].values()}
    dims = [*definition["dims"], "repeat"]
    shape = (*(lengths[d] for d in definition["dims"]), definition["repeats"])
    skipped = {*names, "repeat", "seed", "frame", "key"}
    columns = [
        c for c in columns_of(list(rows.values()), names, definition["metrics"]) if c not in skipped
    ]
    groups = list(dict.fromkeys(c.partition("/")[2] for c in columns if "/" in c))
    data: dict[str, Any] = {}
    for column in columns:
        values = np.full(shape, np.nan)
        for point in definition["points"]:
            value = rows.get(point["key"], {}).get(column)
            values[tuple(point["index"])] = np.nan if value is None else value
        data[column] = values
    variables: dict[str, Any] = {c: (dims, v) for c, v in data.items() if "/" not in c}
    for name in dict.fromkeys(c.partition("/")[0] for c in columns if "/" in c):
        nothing = np.full(shape, np.nan)
        stack = np.stack([data.get(f"{name}/{g}", nothing) for g in groups], axis=-1)
        variables[f"{name}_by_group"] = ([*dims, "group"], stack)
    seeds = definition["seed"] + np.arange(definition["repeats"])
    coords |= {"repeat": ("repeat", np.arange(definition["repeats"])), "seed": ("repeat", seeds)}
    if groups:
        coords["group"] = ("group", np.array(groups, dtype=object))
    dataset = xarray.Dataset(variables, coords, _attributes(definition, store))
    for name, unit in MEASURED.items():
        if unit and name in dataset:
            dataset[name].attrs["units"] = unit
    return dataset


def _coordinate(values: Sequence[Any]) -> Any:
    """Numbers as numbers, anything else as text, so that netCDF can hold it."""
    import numpy as np

    if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
        return np.asarray(values)
    return np.array([str(v) for v in values], dtype=object)


def _attributes(definition: Mapping[str, Any], store: Store) -> dict[str, Any]:
    texts = "cpu scene scene_hash integrator rays visibility size spp converged metrics provenance"
    attributes: dict[str, Any] = {
        name: v if isinstance(v := definition[name], (str, int)) else json.dumps(v)
        for name in texts.split()
    }
    if store.directory is not None:
        attributes["directory"] = str(store.directory)
        _FOLDERS.add(str(store.directory))
    return attributes


def folder_of(dataset: xarray.Dataset) -> Path | None:
    """The folder of the sweep that a dataset shows; None unless this process ran or opened it."""
    kept = dataset.attrs.get("directory")
    if not isinstance(kept, str) or kept not in _FOLDERS or not Store.exists(kept):
        return None
    return Path(kept)


def write_table(dataset: xarray.Dataset, path: Path) -> None:
    """Write `table.nc` atomically, without the directory of the sweep."""
    kept = dataset.drop_attrs(deep=False).assign_attrs(
        {k: v for k, v in dataset.attrs.items() if k != "directory"}
    )
    write_netcdf(kept, path)


def open_dataset(directory: str | os.PathLike[str]) -> xarray.Dataset:
    """The table of the finished points in a directory; ValueError if there is no sweep."""
    if not Store.exists(directory):
        raise ValueError(f"{directory} holds no sweep: it has no sweep.sqlite")
    with Store(directory) as store:
        return to_dataset(store.definition()["names"], store)
