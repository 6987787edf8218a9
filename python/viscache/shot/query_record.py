"""Records of every query of a frame: both ends, truth, answer, cluster and level, as NetCDF."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.netcdf import netcdf_file
from viscache.oracles.points import EyePoints
from viscache.settings.aqvc import LIGHT_GROUPS
from viscache.settings.checks import is_whole, require
from viscache.shot.connections import Connections

#: Of a query in memory: its row of the oracle's log, and of the file.
BYTES_PER_QUERY = 32 + 64

#: Variables of the file: type, unit or meaning.
VARIABLES: dict[str, tuple[str, str]] = {
    "x": ("f4", "eye point, scene units"),
    "y": ("f4", "far end: position, or unit direction"),
    "eye": ("i8", "number of the eye point"),
    "far": ("i8", "number of the far end in its group"),
    "group": ("i1", "light group: " + ", ".join(f"{i} {g}" for i, g in enumerate(LIGHT_GROUPS))),
    "v": ("i1", "V: 1 where x sees y"),
    "answer": ("i1", "V~: what the oracle answered"),
    "cluster": ("i8", "queries with equal numbers share one answer"),
    "level": ("i1", "of refinement, 0 = coarsest"),
}


def record_queries(
    conn: Connections,
    visibility: Any,
    path: str | os.PathLike[str],
    *,
    max_bytes: int = 1 << 30,
    use: Any = None,
) -> int:
    """Write every query of a frame's shared lights to a NetCDF file, tile by tile.

    The file has one dimension "query" and the variables x and y (query, axis), eye, far, group, v,
    answer, cluster and level. xarray reads it, and pandas gets it by `to_dataframe`. It does not
    have samples that belong to one eye point each.

    Parameters
    ----------
    conn : Connections
        The frame's questions, from `viscache.connections`.
    visibility : Exact or Aqvc
        The setting that answers; `Aqvc` in its default form.
    path : path
        A file ".nc". It is complete or absent. It grows on the disk, tile by tile.
    max_bytes : int >= 2^16
        Memory for queries. A tile that needs more is asked several times, for some lights each.
    use : {"replace", "correct"} or Correct, optional
        As in `viscache.render`.

    Returns
    -------
    int
        Number of queries written.

    Raises
    ------
    ValueError
        The oracle has no clusters, or max_bytes is too small for the lights of one eye point.
    OSError
        The disk is full, or does not take the file for another reason. A file of before stays as it
        is.

    Examples
    --------
    >>> import tempfile, xarray, viscache as vc
    >>> conn = vc.connections(vc.scenes.cube_on_plane(), vc.Direct(), size=(16, 10))
    >>> path = tempfile.mkdtemp() + "/queries.nc"
    >>> count = vc.record_queries(conn, vc.Aqvc(c_e=4), path)
    >>> with xarray.open_dataset(path, engine="h5netcdf") as queries:
    ...     wrong = float((queries["v"] != queries["answer"]).mean())
    >>> count > 0, 0 <= wrong < 0.5
    (True, True)
    """
    require(
        is_whole(max_bytes) and max_bytes >= 1 << 16,
        "max_bytes must be a whole number >= 65536",
        max_bytes,
    )
    with netcdf_file(Path(path)) as run:
        run(_define)
        return _write_all(run, conn, visibility, use, int(max_bytes))


def _define(file: Any) -> None:
    file.dimensions = {"query": None, "axis": 3}
    for name, (kind, meaning) in VARIABLES.items():
        dims = ("query", "axis") if name in ("x", "y") else ("query",)
        chunks = (1 << 14, 3)[: len(dims)]
        variable = file.create_variable(name, dims, kind, chunks=chunks, compression="gzip")
        variable.attrs["long_name"] = meaning


def _append(file: Any, written: int, columns: dict[str, npt.NDArray[Any]]) -> None:
    end = written + len(columns["eye"])
    file.resize_dimension("query", end)
    for name, values in columns.items():
        file.variables[name][written:end] = values


def _write_all(
    run: Callable[[Callable[[Any], object]], None],
    conn: Connections,
    visibility: Any,
    use: Any,
    max_bytes: int,
) -> int:
    asked, truth = conn.oracle(visibility, use=use), conn.oracle("exact")
    written, clusters, first = 0, 0, 0
    for tile in conn.eyes._tiles or ():
        eyes = EyePoints(
            tile["positions"],
            tile["normals"],
            tile["density"],
            _origins=tile["origins"],
            _tiles=(tile,),
        )
        rows = slice(first, first + len(eyes))
        for group, ends in conn.groups.items():
            wanted = conn.wanted(group)[rows]
            step = max_bytes // (BYTES_PER_QUERY * max(1, len(eyes)))
            require(
                step >= 1,
                f"max_bytes must be >= {BYTES_PER_QUERY * len(eyes)} for a light of this tile",
                max_bytes,
            )
            seen = truth.block(eyes, ends, wanted)
            offset = clusters
            for begin in range(0, len(ends), step):
                some = slice(begin, begin + step)
                answer = asked.block(eyes, ends, wanted, clusters=some)
                log = answer.clusters
                columns = {
                    "x": eyes.positions[log["row"]],
                    "y": ends.positions[log["column"]],
                    "eye": log["row"].astype(np.int64) + first,
                    "far": log["column"],
                    "group": np.full(len(log), LIGHT_GROUPS.index(group)),
                    "v": _bits(seen.bits, log),
                    "answer": _bits(answer.bits, log),
                    "cluster": log["cluster"].astype(np.int64) + offset,
                    "level": log["level"],
                }
                run(partial(_append, written=written, columns=columns))
                written += len(log)
                if len(log):
                    offset += int(log["cluster"].max()) + 1
            clusters = offset
        first += len(eyes)
    return written


def _bits(rows: npt.NDArray[np.uint64], log: npt.NDArray[Any]) -> Any:
    words = rows[log["row"], log["column"] // 64]
    return words >> (log["column"] % 64).astype(np.uint64) & np.uint64(1)
