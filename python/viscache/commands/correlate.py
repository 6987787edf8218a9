"""`viscache correlate SCENE -o out.nc`: correlation statistics of a scene's visibility."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any, Literal, get_args

from viscache.commands.shared import (
    add_scene,
    add_workers,
    at_least_one,
    chosen_executor,
    chosen_scene,
    print_json,
    print_table,
    threads_of_a_worker,
)
from viscache.correlation.rows import RowEngine
from viscache.plots import FORMATS

#: Options that `measure` takes as they are.
MEASURED = (
    "n_points map_size pairs points camera seed d_edges theta_edges_deg d_max directions domain"
    " normals engine directory"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    parser.add_argument("-o", "--output", metavar="OUT.nc", required=True)
    parser.add_argument(
        "--points",
        dest="n_points",
        type=at_least_one,
        default=20_000,
        metavar="N",
        help="surface points (default: 20000; the paper: 195000)",
    )
    parser.add_argument(
        "--on",
        dest="points",
        choices=["camera", "area"],
        help="points seen by the camera, or evenly on all surfaces",
    )
    parser.add_argument(
        "--map-size",
        type=at_least_one,
        default=96,
        metavar="M",
        help="edge of the map of directions (default: 96)",
    )
    parser.add_argument("--pairs", type=_pairs, default="all", metavar="all|N")
    parser.add_argument("--d-max", type=float, metavar="D", help="end of the bins of distance")
    bins: dict[str, Any] = {"type": at_least_one, "metavar": "N"}
    parser.add_argument("--d-bins", dest="d_edges", default=128, **bins)
    parser.add_argument("--theta-bins", dest="theta_edges_deg", default=180, **bins)
    parser.add_argument("--directions", choices=["centres", "jittered", "lloyd"], default="centres")
    parser.add_argument("--domain", choices=["sphere", "joint", "union"], default="sphere")
    parser.add_argument(
        "--normals",
        choices=["geometric", "shading"],
        default="geometric",
        help="of the angle between points",
    )
    parser.add_argument(
        "--t-max",
        type=float,
        metavar="T",
        help="local visibility: occluders within T only; chosen in closed scenes, else no limit",
    )
    parser.add_argument(
        "--engine",
        choices=get_args(RowEngine),
        default="embree",
        help="who traces the rows; auto: by predicted cost",
    )
    parser.add_argument("--camera", metavar="NAME", help="name or index")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=at_least_one)
    add_workers(parser)
    parser.add_argument(
        "--store", dest="directory", metavar="DIR", help="keeps finished blocks; resumes there"
    )
    parser.add_argument("--plot", metavar="DIR", help="pictures of the result")
    parser.add_argument(
        "--format", action="append", choices=FORMATS, help="of --plot; repeat for more (png)"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    from viscache.correlation import measure, save_dataset

    target = Path(arguments.output)
    folder = target.resolve().parent
    if target.suffix.lower() != ".nc":
        raise ValueError(f"output must be an .nc file, got {arguments.output}")
    if arguments.format and arguments.plot is None:
        raise ValueError("--format must come with --plot DIR")
    if arguments.plot is not None:
        Path(arguments.plot).mkdir(parents=True, exist_ok=True)
    if not folder.is_dir() or target.is_dir() or not os.access(folder, os.W_OK):
        raise ValueError(f"output must lie in a folder that can be written, got {target}")
    scene = chosen_scene(arguments)
    with chosen_executor(arguments) as executor:
        given = {name: getattr(arguments, name) for name in MEASURED.split()}
        given["threads"] = arguments.threads or threads_of_a_worker(arguments)
        if arguments.t_max is not None:
            given["t_max"] = arguments.t_max
        dataset = measure(scene, executor=executor, progress=sys.stderr.isatty(), **given)
    if "mended" in dataset.attrs:
        print(dataset.attrs.pop("mended"), file=sys.stderr)
    save_dataset(dataset, target)
    summary = _summary(dataset, str(target))
    if arguments.plot is not None:
        from viscache.correlation import plots

        formats = arguments.format or ("png",)
        summary["plots"] = [str(path) for path in plots.save_all(dataset, arguments.plot, formats)]
    if arguments.json:
        print_json(summary)
    else:
        _print(summary)
    return 0


def _print(summary: dict[str, Any]) -> None:
    print_table({k: v for k, v in summary.items() if not isinstance(v, list)})
    print("\ntheta [deg]   d at rho 0.9   d at rho 0.5   [scene units]")
    for row in summary["correlation_lengths"]:
        nine, five = _number(row["d_at_0.9"]), _number(row["d_at_0.5"])
        print(f"{row['theta_deg']:<11g}   {nine:<12}   {five}")
    print("\nrecord spacing   predicted variance ratio 1 - rho^2")
    for row in summary["predicted_variance_ratio"]:
        print(f"{row['spacing']:<14.4g}   {_number(row['ratio'])}")
    print(*summary.get("plots", []), sep="\n")


def _summary(dataset: Any, path: str) -> dict[str, Any]:
    a = dataset.attrs
    rows = [
        {"theta_deg": float(dataset["theta"][t])}
        | {
            f"d_at_{level:g}": float(dataset["correlation_length"][k, t])
            for k, level in enumerate(dataset["level"].values)
        }
        for t in range(0, dataset.sizes["theta"], max(1, dataset.sizes["theta"] // 18))
    ]
    ratios = dataset["predicted_variance_ratio"]
    return {
        "scene": a["scene"],
        "n_points": a["n_points"],
        "n_pairs": a["n_pairs"],
        "n_rays": a["n_rays"],
        "batch_rays": a["batch_rays"],
        "t_max": a["t_max"],
        "t_max_by": a["t_max_by"],
        "rows_s": a["rows_s"],
        "pairs_s": a["pairs_s"],
        "corner": float(dataset["corner"]),
        "corner_se": float(dataset["corner_se"]),
        "d_max": a["d_max"],
        "d_near": a["d_near"],
        "box_d_max": a["box_d_max"],
        "box_theta_max_deg": a["box_theta_max_deg"],
        "box_mean": a["box_mean"],
        "correlation_lengths": rows,
        "predicted_variance_ratio": [
            {"spacing": float(s), "ratio": float(r)}
            for s, r in zip(ratios["spacing"].values, ratios.values, strict=True)
        ],
        "written": path,
    }


def _number(value: float) -> str:
    if value != value:
        return "too few pairs"
    return "not reached" if value == float("inf") else f"{value:.4g}"


def _pairs(text: str) -> int | Literal["all"]:
    return "all" if text == "all" else at_least_one(text)
