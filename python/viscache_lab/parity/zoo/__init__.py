"""The zoo: scenes of one feature each, written as Mitsuba XML with the files they name."""

from __future__ import annotations

from pathlib import Path

from viscache_lab.parity.zoo.case import Case
from viscache_lab.parity.zoo.files import write_files
from viscache_lab.parity.zoo.materials import material_cases
from viscache_lab.parity.zoo.surfaces import shape_cases, texture_cases
from viscache_lab.parity.zoo.views import camera_cases, light_cases

__all__ = ["Case", "cases", "write"]


def cases(*, quick: bool = False) -> list[Case]:
    """All cases, or a sample of them that has each feature once."""
    makers = (shape_cases, material_cases, light_cases, texture_cases, camera_cases)
    every = [case for maker in makers for case in maker()]
    return [case for case in every if case.quick] if quick else every


def write(folder: Path, chosen: list[Case]) -> dict[str, Path]:
    """Write cases and the files that they name; the path of each case."""
    folder.mkdir(parents=True, exist_ok=True)
    write_files(folder)
    paths = {}
    for case in chosen:
        paths[case.name] = folder / case.file
        paths[case.name].write_text(case.text(), encoding="utf-8")
    return paths
