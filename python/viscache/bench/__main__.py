"""`python -m viscache.bench NAME|all|list [--quick] [--json]`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

from viscache.bench.registry import BENCHES, run
from viscache.settings import NotThereYetError


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status 0: done; 1: an answer was wrong; 2: bad usage."""
    parser = argparse.ArgumentParser(prog="viscache bench", description=__doc__)
    parser.add_argument("name", help="a bench, `all` or `list`")
    parser.add_argument("--quick", action="store_true", help="small scenes and few repeats")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    given = parser.parse_args(arguments)
    if given.name == "list":
        return _list(given.json)
    names = [n for n, b in BENCHES.items() if b.is_there] if given.name == "all" else [given.name]
    results = []
    for name in names:
        try:
            result = run(name, given.quick)
        except NotThereYetError as error:
            print(error, file=sys.stderr)
            return 1
        except ValueError as error:
            print(error, file=sys.stderr)
            return 2
        results.append(result)
        if not given.json:
            print(text(result))
    if given.json:
        print(json.dumps(results[0] if given.name != "all" else {"benches": results}))
    return 0 if all(r["answers_hold"] for r in results) else 1


def text(result: dict[str, Any]) -> str:
    """A bench's result as a table."""
    lines = [
        f"{result['bench']}   {result['machine']['processor']}, {result['machine']['cores']} cores"
    ]
    for f in result["figures"]:
        line = f"  {f['name']:<62} {f['value']:>9.4g} {f['unit']}"
        if f["ratio"] is not None:
            line += f"  {f['ratio']:.2f}x [{f['low']:.2f}, {f['high']:.2f}]"
        if f["goal"] is not None:
            line += f"  goal {f['goal']:g}: {'holds' if f['holds'] else 'missed'}"
        if f.get("rel_l1") is not None:
            line += f"  rel_l1 {f['rel_l1']:.4f}"
        lines.append(line)
    for s in result["skipped"]:
        lines.append(f"  skipped: {s['what']}: {s['reason']}")
    wrong = [a for a in result["answers"] if not a["holds"]]
    lines.append(f"  {len(result['answers'])} answers checked, {len(wrong)} wrong")
    lines += [f"  WRONG {a['what']}: {a['value']:g} > {a['limit']:g}" for a in wrong]
    return "\n".join(lines)


def _list(as_json: bool) -> int:
    rows = [
        {"name": n, "is_there": b.is_there, "description": b.description}
        for n, b in BENCHES.items()
    ]
    if as_json:
        print(json.dumps({"benches": rows}))
    else:
        for row in rows:
            note = "" if row["is_there"] else "   (not there yet)"
            print(f"{row['name']:<16} {row['description']}{note}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
