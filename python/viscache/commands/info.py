"""`viscache info SCENE`: the content of a scene."""

from __future__ import annotations

import argparse
from collections import Counter

from viscache.commands.shared import add_scene, chosen_scene, print_json, print_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    info = chosen_scene(arguments).info()
    if arguments.json:
        print_json(info)
        return 0
    kinds = Counter(light["kind"] for light in info["lights"])
    cameras = [f"{c['name'] or 'unnamed'} ({c['size'][0]}x{c['size'][1]})" for c in info["cameras"]]
    share = info["coplanar_share"]
    plain = {k: v for k, v in info.items() if k not in ("warnings", "memory_bytes")}
    print_table(
        plain
        | {
            "bounds": " to ".join(
                "(" + ", ".join(f"{v:g}" for v in c) + ")" for c in info["bounds"]
            ),
            "lights": ", ".join(f"{n} {kind}" for kind, n in kinds.items()) or "none",
            "cameras": ", ".join(cameras) or "none",
            "coplanar_share": "not counted" if share is None else f"{share:.1%}",
            "memory": f"{info['memory_bytes'] / 2**20:,.1f} MiB with the ray caster (estimate)",
        }
    )
    for warning in info["warnings"]:
        print(f"warning: {warning}")
    return 0
