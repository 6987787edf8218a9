"""The lists of experiments: figures of the papers, benches, families of numerical extremes."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeVar

from viscache.commands.shared import print_json
from viscache.settings.checks import require
from viscache.settings.spelling import nearest

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True, kw_only=True, slots=True)
class Experiment:
    """A figure or table, a bench, or a family of checks."""

    description: str
    function: Callable[..., Any]
    """Takes a `Trial`; that of a family takes `full` and gives its cases."""
    sized: bool = False  # whether its pictures can have another size
    every_isa: bool = True  # of a family: whether `--full` repeats it for every instruction set
    most_bytes: int | None = None  # of a family: address space of its process
    cases: Sequence[Any] = ()
    """If there are any, the function takes a `Trial`, a case and its scene; see `Trial.scenes`."""
    quick_cases: Sequence[Any] = ()
    note: str = ""  # how to read its numbers

    def fill(self, trial: Any) -> None:
        """Run it, case by case where it has cases."""
        if self.cases:
            for case, scene in trial.scenes(self.quick_cases if trial.quick else self.cases):
                self.function(trial, case, scene)
        else:
            self.function(trial)
        trial.notes += [self.note] if self.note else []


class Registry(dict[str, Experiment]):
    """Name to experiment. The modules of `package`, but those named `peer_…`, declare them.

    `kind` is what messages call one of them. `papers` are the first words of all names, in their
    order. `gone` are names that were known once, to what takes their place.
    """

    def __init__(
        self,
        kind: str,
        package: str,
        papers: tuple[str, ...] = (),
        gone: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        super().__init__()
        self.kind, self.package, self.papers, self.gone = kind, package, papers, gone

    def add(self, name: str, description: str, **about: Any) -> Callable[[Function], Function]:
        """Declare a function as an experiment; `about` are further fields of `Experiment`."""
        first = name.partition("-")[0]
        if self.papers:
            require(first in self.papers, f"a {self.kind}'s paper must be one of {self.papers}",
                    name)  # fmt: skip
        require(name not in self, f"a {self.kind}'s name must be its own", name)

        def declare(function: Function) -> Function:
            self[name] = Experiment(description=description, function=function, **about)
            return function

        return declare

    def find(self, name: str) -> Experiment:
        """The experiment of a name; ValueError gives the nearest known one, or what replaces it."""
        if name in self.gone:
            raise ValueError(f"the {self.kind} {name!r} is gone: use {self.gone[name]}")
        if name not in self:
            raise ValueError(f"unknown {self.kind} {name!r}{nearest(name, self)}")
        return self[name]

    def load(self) -> None:
        """Import all modules of the package, and sort what they declare."""
        for module in pkgutil.iter_modules(importlib.import_module(self.package).__path__):
            if not module.name.startswith("peer_"):
                importlib.import_module(f"{self.package}.{module.name}")
        ordered = sorted(self.items(), key=lambda item: self._place(item[0]))
        self.clear()
        self.update(ordered)

    def _place(self, name: str) -> tuple[int, int, int, str]:
        """In the order of the papers: figures and tables by number, then the others."""
        paper, _, rest = name.partition("-")
        if paper not in self.papers:
            return 0, 0, 0, name
        numbered = re.fullmatch(r"(fig|tab)(\d+)", rest)
        kind = ("fig", "tab").index(numbered[1]) if numbered else 2
        return self.papers.index(paper), kind, int(numbered[2]) if numbered else 0, rest


def print_list(registry: Registry, *, as_json: bool) -> int:
    """Print the names with their descriptions; exit status 0."""
    if as_json:
        plural = f"{registry.kind}{'es' if registry.kind == 'bench' else 's'}"
        print_json({plural: [{registry.kind: name} for name in registry]})
    else:
        for name, one in registry.items():
            print(f"{name} ({one.description})")
    return 0


#: Figures and tables in the order of the papers; the trade of all methods and their extremes.
FIGURES = Registry(
    "figure",
    "viscache_lab.figures",
    ("aqvc", "vlf", "vismap", "trade", "extremes"),
    gone={
        "aqvc-correct": "viscache reproduce trade",
        "vlf-x3": "viscache.VisibilityField.memory_estimate",
        "vlf-x4": "viscache bench vlf-ao",
        "vlf-x5": "viscache bench vlf-build",
    },
)
BENCHES = Registry(
    "bench",
    "viscache_lab.bench",
    gone={
        "aligned": "scripts/aligned_costs.py",
        "frames": "viscache bench peers --only 'AO*', and --only '*point lights*'",
        "memory": "viscache bench loading",
        "oracle": "viscache bench aqvc-lookup for queries, and bench which-cache for Python",
        "tune": "vc.tune, whose result has the error, its interval and the pilots",
        "notebook-slider": "the milliseconds of vc.notebook.sliders",
        "shafts-elsewhere": "viscache bench shafts",
        "watertight": "viscache bench rays, and viscache doctor --only leaks",
    },
)
FAMILIES = Registry("family", "viscache_lab.extremes.families")
