"""One run of an experiment: what was asked for, and what was found."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import viscache as vc
from viscache.scenes.sources import is_builtin, made_by_others
from viscache.sweeps.exact_frames import ExactFrames
from viscache_lab.experiment import amounts, drawing
from viscache_lab.experiment.amounts import Sample
from viscache_lab.experiment.rows import Row


@dataclass(kw_only=True, slots=True)
class Trial:
    """One run of an experiment, which its function fills; `options` are its own alone."""

    folder: Path = Path()
    quick: bool = False
    progress: bool = False
    size: tuple[int, int] | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    rows: list[Row] = field(default_factory=list)  # measured values beside the papers' and bands
    figures: list[dict[str, Any]] = field(default_factory=list)
    """Amounts, and ratios to a baseline of the same run."""
    answers: list[dict[str, Any]] = field(default_factory=list)
    """Each check of an answer, and whether it holds."""
    files: list[Path] = field(default_factory=list)
    drawn: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    """File name to what its axes show."""
    skipped: list[dict[str, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def repeats(self, full: int, quick: int = 1) -> int:
        """Turns of what is timed."""
        return quick if self.quick else full

    def exact_frames(self) -> ExactFrames:
        """Converged pictures, which the figures of a folder share; do not use them for timings."""
        return ExactFrames(self.folder / "references")

    def row(self, what: str, measured: float | None, **more: Any) -> None:
        """Record a measured value; see `Row`."""
        self.rows.append(Row(what, measured, **more))

    def figure(self, name: str, value: float, unit: str, **more: Any) -> None:
        """Record an amount; see `amounts.figure`."""
        self.figures.append(amounts.figure(name, value, unit, **more))

    def at_most(self, name: str, value: float, unit: str, limit: float | None, **more: Any) -> None:
        """Record an amount that holds up to a limit; see `amounts.at_most_figure`."""
        self.figures.append(amounts.at_most_figure(name, value, unit, limit, **more))

    def ratio(
        self, name: str, ours: Sequence[Sample], theirs: Sequence[Sample], **more: Any
    ) -> dict[str, Any]:
        """Record how many times faster ours is, and give the row; see `amounts.ratio_figure`."""
        self.figures.append(amounts.ratio_figure(name, ours, theirs, **more))
        return self.figures[-1]

    def check(self, what: str, value: float, limit: float) -> None:
        """Record a check that holds if value <= limit."""
        holds = bool(value <= limit)  # not-a-number does not hold
        self.answers.append({"what": what, "value": float(value), "limit": limit, "holds": holds})

    @property
    def answers_hold(self) -> bool:
        """True if every answer that was checked is right."""
        return all(a["holds"] for a in self.answers)

    def skip(self, what: str, reason: str) -> None:
        """Record what was left out, and why."""
        self.skipped.append({"what": what, "reason": reason})

    def extend(self, other: Trial) -> None:
        """Append the figures, answers, skips and notes of another trial."""
        self.figures += other.figures
        self.answers += other.answers
        self.skipped += other.skipped
        self.notes += other.notes

    def scenes(self, cases: Iterable[Any]) -> Iterator[tuple[Any, vc.Scene]]:
        """Each case (`name` and `scene`), or spec, with its scene; without its file it is skipped.

        A scene is a spec, or a folder of $VISCACHE_SCENES and a file in it.
        """
        kept: tuple[str, vc.Scene | None] = "", None
        for case in cases:
            name, spec = (case, case) if isinstance(case, str) else (case.name, case.scene)
            if spec != kept[0]:
                kept = spec, opened(spec)  # one at a time
            if kept[1] is None:
                self.skip(name, "VISCACHE_SCENES has no such file")
            else:
                yield case, kept[1]

    def csv(self, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write a table; columns are in the order of their first occurrence."""
        columns = list(dict.fromkeys(column for row in rows for column in row))
        with (self.folder / name).open("w", encoding="utf-8", newline="") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(columns)
            table.writerows([_cell(row.get(column, "")) for column in columns] for row in rows)
        self.files.append(self.folder / name)

    def draw(
        self,
        name: str,
        panels: drawing.Panels,
        inches: tuple[float, float] = (6.0, 4.0),
        dpi: int = 120,
    ) -> None:
        """Draw and write rows of panels."""
        self.save(drawing.draw(panels, inches), name, dpi)

    def save(self, figure: Any, name: str, dpi: int = 120) -> None:
        """Write a picture of Matplotlib, and record what its axes show."""
        figure.savefig(self.folder / name, dpi=dpi)
        self.files.append(self.folder / name)
        self.drawn[name] = drawing.described(figure)


def opened(spec: str) -> vc.Scene | None:
    """A built-in scene or a file in the folder of scenes by others; None without the file."""
    if is_builtin(spec):
        return amounts.build_scene(spec)
    path = made_by_others(spec)
    return None if path is None else vc.load_scene(path)


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
