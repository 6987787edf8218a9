"""The zoo: scenes of one feature each, written as Mitsuba XML with the files they name."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from itertools import product
from pathlib import Path

from viscache_lab.parity.zoo.files import write_files

__all__ = ["Case", "cases", "scene_text", "write"]

#: A tag of `scenes.txt`, with its type, name, other attributes and whether it holds others.
_TAG = re.compile(r"(\w+)(?:\.(\w+))?(?::(\w+))?(?:\(([^)]*)\))?({)?|[};]|\s+")


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """A scene of one feature. The name, `group/what-it-has`, is also that of its file."""

    name: str
    text: str
    quick: bool

    @property
    def group(self) -> str:
        """The kind of feature."""
        return self.name.partition("/")[0]

    @property
    def file(self) -> str:
        """The name of the file."""
        return self.name.replace("/", "-") + ".xml"


def cases(*, quick: bool = False) -> list[Case]:
    """All cases, or a sample of them that has each feature once."""
    lists = _lists()
    sample = re.compile("|".join(lists["quick"]))
    every = [
        Case(name=name, text=_xml(text), quick=sample.fullmatch(name) is not None)
        for name, text in lists[""].items()
    ]
    return [case for case in every if case.quick] if quick else every


def write(folder: Path, chosen: list[Case]) -> dict[str, Path]:
    """Write cases and the files that they name; the path of each case."""
    folder.mkdir(parents=True, exist_ok=True)
    write_files(folder)
    paths = {}
    for case in chosen:
        paths[case.name] = folder / case.file
        paths[case.name].write_text(case.text, encoding="utf-8")
    return paths


def _lists() -> dict[str, dict[str, str]]:
    """The lists of `scenes.txt`; pieces are the list `$`, scenes the one without a name."""
    lists: dict[str, dict[str, str]] = defaultdict(dict)
    for line in (resources.files(__package__) / "scenes.txt").read_text("utf-8").splitlines():
        found = re.fullmatch(r"(?:<(\w+)> |(\$)(?=\w))?([^#|].*?)(?: \| ?(.*))?", line)
        if found is None:
            continue
        for name in found[3].split():
            kind = found[1] or found[2] or ""
            lists[kind] |= _each(name, found[4] or "", lists)
    return lists


def _each(name: str, text: str, lists: dict[str, dict[str, str]]) -> Iterator[tuple[str, str]]:
    """Name and text for each entry of the lists that stand in the name."""
    wanted = re.findall(r"<(\w+)>", name)
    for entries in product(*(lists[kind] for kind in wanted)):
        chosen = dict(zip(wanted, entries, strict=True))
        full = text
        for pieces in (lists["$"], {kind: lists[kind][entry] for kind, entry in chosen.items()}):
            full = _put(r"\$(\w+)", pieces, full)
        yield _put(r"<(\w+)>", chosen, name), _put(r"<(\w+)>", chosen, full)


def _put(pattern: str, pieces: dict[str, str], text: str) -> str:
    return re.sub(pattern, lambda found: pieces.get(found[1], found[0]), text)


def scene_text(text: str) -> str:
    """The file of a scene in the notation of `scenes.txt`, with its pieces."""
    ((_, full),) = _each("", text, _lists())
    return _xml(full)


def _xml(text: str) -> str:
    parents: list[str] = []

    def made(found: re.Match[str]) -> str:
        tag, kind, name, values, holds = found.groups(default="")
        if not tag:
            return f"</{parents.pop()}>" if found[0] == "}" else "\n" * (found[0] == ";")
        pairs = [("type", kind), ("name", name)]
        pairs += re.findall(r"(\w+)=(\S+)", values) or [("value", values)]
        parents.extend([tag] * bool(holds))
        words = [tag, *(f'{key}="{value}"' for key, value in pairs if value)]
        return f"<{' '.join(words)}{'' if holds else '/'}>"

    return f'<scene version="3.0.0">\n{_TAG.sub(made, text)}\n</scene>\n'
