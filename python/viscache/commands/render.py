"""`viscache render SCENE -o out.exr`, or .png, .jpg."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path
from typing import Any

import viscache as vc
from viscache.base.progress import progress_bar
from viscache.commands.shared import (
    add_scene,
    add_shot,
    at_least_one,
    chosen_scene,
    chosen_settings,
    chosen_shot,
    print_json,
    print_table,
)
from viscache.frame.audit_result import audit_rows
from viscache.frame.frame import checked_suffix
from viscache.settings import by_name
from viscache.settings.checks import require

#: Least seconds between two saves of a state, and least work between them as a multiple of a save.
SAVE_EVERY_S = 10.0
LEAST_WORK = 20.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT.exr",
        required=True,
        help="all layers as .exr, or a picture to look at: .png, .jpg",
    )
    parser.add_argument(
        "--exposure",
        type=float,
        metavar="FACTOR",
        help="of a .png or .jpg; by the picture by default",
    )
    parser.add_argument(
        "--integrator", default="whitted", choices=list(by_name.NAMES["integrator"])
    )
    parser.add_argument("--rays", default="embree", choices=list(by_name.NAMES["rays"]))
    parser.add_argument(
        "--visibility",
        default="exact",
        choices=[*by_name.NAMES["visibility"], *by_name.RAYS_AS_VISIBILITY],
    )
    add_shot(parser)
    parser.add_argument(
        "--passes",
        type=at_least_one,
        metavar="N",
        help="N passes of --spp new samples each; what a cache traced is kept (vc.Progressive)",
    )
    parser.add_argument(
        "--state",
        metavar="FILE.npz",
        help="with --passes: go on from this file if it exists, and save to it",
    )
    parser.add_argument(
        "--audit",
        metavar="pixels[:N]|queries[:SHARE]",
        type=_audit,
        help="estimate the error of a cache: exact rays answer some pixels or queries as well",
    )
    parser.add_argument("--json", action="store_true", help="counters, timings, parameters, sha256")


def run(arguments: argparse.Namespace) -> int:
    target = Path(arguments.output)
    is_exr = checked_suffix(target) == "exr"
    require(
        not is_exr or arguments.exposure is None,
        "--exposure must be left out for .exr",
        arguments.exposure,
    )
    folder = target.resolve().parent
    if not folder.is_dir():
        raise ValueError(f"output must lie in an existing folder, got {arguments.output}")
    if target.is_dir() or not os.access(folder, os.W_OK):
        raise ValueError(f"output must be a file that can be written, got {arguments.output}")
    chosen = chosen_settings(arguments)
    scene = chosen_scene(arguments)
    require(
        arguments.passes is not None or arguments.state is None,
        "--state must come with --passes",
        arguments.state,
    )
    options: dict[str, Any] = {
        "rays": chosen["rays"],
        "visibility": chosen["visibility"],
        **chosen_shot(arguments),
    }
    require(
        arguments.passes is None or arguments.audit is None,
        "--audit must be left out with --passes",
        arguments.audit,
    )
    if arguments.passes is None:
        frame = vc.render(
            scene,
            chosen["integrator"],
            audit=arguments.audit,
            progress=sys.stderr.isatty(),
            **options,
        )
    else:
        frame = _in_passes(vc.Progressive(scene, chosen["integrator"], **options), arguments)
    frame.save(target, exposure=arguments.exposure)
    if arguments.json:
        print_json(frame.summary())
        return 0
    wanted = ("queries", "rays", "ray_reduction")
    print_table(
        {
            **{
                k: v
                for k, v in frame.timings.items()
                if k in ("total_s", "visibility_s", "shading_s")
            },
            **{k: frame.counters[k] for k in wanted if k in frame.counters},
            **audit_rows(frame.counters.get("audit")),
            "sha256": frame.sha256,
            "written": str(target),
        }
    )
    for warning in frame.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    return 0


def _in_passes(picture: vc.Progressive, arguments: argparse.Namespace) -> vc.Frame:
    """Render passes; a state file is saved between passes, so that a kill loses seconds at most."""
    shown = sys.stderr.isatty()
    if arguments.state is None:
        return picture.passes(arguments.passes, progress=shown)
    state = Path(arguments.state)
    if state.exists():
        picture.load(state)
    due = time.monotonic() + SAVE_EVERY_S

    def after_pass(done: int, n: int) -> None:
        nonlocal due
        if report:
            report(done, n)
        began = time.monotonic()
        if done < n and began >= due:
            picture.save(state)
            ended = time.monotonic()
            due = ended + max(SAVE_EVERY_S, LEAST_WORK * (ended - began))

    try:
        with progress_bar(shown, unit="pass") as report:
            return picture.passes(arguments.passes, progress=after_pass)
    finally:
        picture.save(state)


def _audit(text: str) -> vc.AuditPixels | vc.AuditQueries:
    """`pixels`, `pixels:4096`, `queries`, `queries:0.05`."""
    kind, colon, number = text.partition(":")
    try:
        if kind == "pixels":
            return vc.AuditPixels(n=int(number)) if colon else vc.AuditPixels()
        if kind == "queries":
            return vc.AuditQueries(share=float(number)) if colon else vc.AuditQueries()
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{error} in {text!r}") from error
    raise argparse.ArgumentTypeError(f"must be pixels[:N] or queries[:SHARE], got {text!r}")
