"""Results of benches as text."""

from __future__ import annotations

from typing import Any


def text(result: dict[str, Any]) -> str:
    """A bench's result as a table."""
    lines = [
        f"{result['bench']}   {result['machine']['processor']}, {result['machine']['cores']} cores"
    ]
    for f in result["figures"]:
        line = f"  {f['name']:<62} {f['value']:>9.4g} {f['unit']}"
        if f["ratio"] is not None:
            line += f"  {f['ratio']:.2f}x [{f['low']:.2f}, {f['high']:.2f}]"
        if f.get("gain_rel") is not None:
            line += f"  relMSE {f['gain_rel']:.2f}x"
        if f["goal"] is not None:
            line += f"  goal {f['goal']:g}: {'holds' if f['holds'] else 'missed'}"
        if f.get("at_most") is not None:
            line += f"  at most {f['at_most']:g}: {'holds' if f['holds'] else 'missed'}"
        if f.get("equal_error") is not None:
            low, high = f["equal_error_low"], f["equal_error_high"]
            line += f"  to equal error {f['equal_error']:.2f}x [{low:.2f}, {high:.2f}]"
        if f.get("rel_l1") is not None:
            line += f"  rel_l1 {f['rel_l1']:.4f}"
        if f.get("build_s") is not None:
            line += f"  without its build of {f['build_s']:.4g} s {f['ratio_without_build']:.2f}x"
        if f.get("equal_error_without_build") is not None:
            line += f", {f['equal_error_without_build']:.2f}x"
        lines.append(line)
    for s in result["skipped"]:
        lines.append(f"  skipped: {s['what']}: {s['reason']}")
    wrong = [a for a in result["answers"] if not a["holds"]]
    lines.append(f"  {len(result['answers'])} answers checked, {len(wrong)} wrong")
    lines += [f"  WRONG {a['what']}: {a['value']:g} > {a['limit']:g}" for a in wrong]
    return "\n".join(lines)
