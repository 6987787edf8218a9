"""The table of a sweep: rows for CSV, a dataset for xarray."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscache.store import Record, Store

if TYPE_CHECKING:
    import xarray

UNITS = {
    "total_s": "s", "visibility_s": "s", "cpu_s": "s", "exact_total_s": "s", "rays": "1",
    "queries": "1", "ray_reduction": "1", "speedup": "1", "exact_cpu_s": "s",
    "cpu_speedup": "1",
}  # fmt: skip


def table_rows(store: Store) -> list[dict[str, Any]]:
    """One row per finished point and repeat: setting, seed, metrics, counts, times."""
    rows = []
    definition = store.definition()
    for point in definition["points"]:
        record, paired = store.get(point["key"]), store.get(point["paired"])
        if record is None or paired is None:
            continue
        known = store.compared(point["key"], point["paired"])
        if not all(m in known for m in definition["metrics"]):
            continue
        row = {**point["values"], "repeat": point["repeat"], "seed": point["seed"]}
        row |= {m: known[m] for m in definition["metrics"]}
        if point["converged"] is not None:
            total = store.compared(point["key"], point["converged"])
            exact = store.compared(point["paired"], point["converged"])
            row |= {f"converged_{m}": total.get(m) for m in definition["metrics"]}
            row |= {f"exact_converged_{m}": exact.get(m) for m in definition["metrics"]}
        row |= _measured(record, paired)
        row |= {name: v for name, v in known.items() if "/" in name}
        rows.append({**row, "frame": record.file, "key": record.key})
    return rows


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
    fixed = [
        *first, "rays", "queries", "ray_reduction", "total_s", "visibility_s", "cpu_s",
        "exact_total_s", "exact_cpu_s", "exact_rays", "speedup", "cpu_speedup",
    ]  # fmt: skip
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
    columns = [c for c in columns_of(list(rows.values()), names, definition["metrics"])
               if c not in skipped]  # fmt: skip
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
    for name, unit in UNITS.items():
        if name in dataset:
            dataset[name].attrs["units"] = unit
    return dataset


def _coordinate(values: Sequence[Any]) -> Any:
    """Numbers as numbers, anything else as text, so that netCDF can hold it."""
    import numpy as np

    if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
        return np.asarray(values)
    return np.array([str(v) for v in values], dtype=object)


def _attributes(definition: Mapping[str, Any], store: Store) -> dict[str, Any]:
    texts = (
        "cpu","scene", "scene_hash", "integrator", "rays", "visibility", "size", "spp", "converged",
             "metrics", "provenance")  # fmt: skip
    attributes: dict[str, Any] = {
        name: v if isinstance(v := definition[name], (str, int)) else json.dumps(v)
        for name in texts
    }
    if store.directory is not None:
        attributes["directory"] = str(store.directory)
    return attributes


def write_netcdf(dataset: xarray.Dataset, path: Path) -> None:
    """Write `table.nc` whole; where the sweep lay is left out of the file."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    kept = dataset.drop_attrs(deep=False).assign_attrs(
        {k: v for k, v in dataset.attrs.items() if k != "directory"}
    )
    kept.to_netcdf(partial, engine="h5netcdf")
    partial.replace(path)


def open_dataset(directory: str | os.PathLike[str]) -> xarray.Dataset:
    """The table of a swept directory as far as it got; ValueError where there is none."""
    if not Store.exists(directory):
        raise ValueError(f"{directory} holds no sweep: it has no sweep.sqlite")
    with Store(directory) as store:
        return to_dataset(store.definition()["names"], store)
