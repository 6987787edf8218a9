"""Any file is read or refused by its name: files of scenes, pictures and everything that is saved.

Each case changes a whole file in one to eight places and reads it in a child of its own.
"""

from __future__ import annotations

import random
import shutil
import warnings
from pathlib import Path

import pytest

from fuzz import campaign
from fuzz.make_corpus import CORPUS, pictures, scenes
from fuzz.mutate import mutated
from fuzz.outcome import CLEAN, of_error
from fuzz.readers import READERS, Reader

MOST_BYTES = 1 << 20
CORPUS_KINDS = {path.partition("/")[0] for path in (*pictures(), *scenes())}


class NamelessError(Exception):
    """An error that does not name the file."""


# What shares the seconds of one target
TARGETS = {
    "obj": ("obj", "mtl"),
    "ply": ("ply",),
    "gltf": ("gltf", "glb"),
    "pbrt": ("pbrt",),
    "mitsuba": ("xml", "serialized"),
    "pictures": ("png", "jpg", "hdr", "bmp", "tga"),
    "saved": tuple(sorted(set(READERS) - CORPUS_KINDS - {"sweep", "correlation"})),
    "stores": ("correlation", "sweep"),
}


def changed_file(reader: Reader, path: Path, content: bytes) -> Path:
    """What to read: a file beside the whole one, or a folder with this file in its place."""
    if not reader.in_place:
        changed = path.with_name("changed" + path.suffix)
        changed.write_bytes(content)
        return changed
    whole = next(folder for folder in path.parents if folder.name == "whole")
    changed = whole.with_name("changed")
    shutil.rmtree(changed, ignore_errors=True)
    shutil.copytree(whole, changed)
    (changed / path.relative_to(whole)).write_bytes(content)
    return changed


def target(wholes: list[tuple[Reader, Path]]) -> campaign.Target:
    """A case: one of the files, changed and read."""

    def case(seeded: random.Random) -> None:
        reader, path = seeded.choice(wholes)
        changed = changed_file(reader, path, mutated(path.read_bytes(), seeded))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                reader.read(changed)
            except CLEAN as error:
                named = "changed" in str(error) or isinstance(error, MemoryError)
                if named or not of_error(error).allowed:
                    raise
                raise NamelessError(f"{type(error).__name__}: {error}") from error

    return case


@pytest.mark.fuzz
@pytest.mark.slow
@pytest.mark.parametrize("name", TARGETS)
def test_any_file_is_read_or_refused_by_its_name(
    name: str, fuzz_seconds: float, fuzz_cases: int | None, fuzz_seed: int, tmp_path: Path
) -> None:
    wholes = []
    for kind in TARGETS[name]:
        (tmp_path / kind).mkdir()
        wholes += [(READERS[kind], path) for path in READERS[kind].seeds(tmp_path / kind)]
    for reader, path in wholes:
        reader.read(changed_file(reader, path, path.read_bytes()))
    case = target(wholes)
    counts, bad = campaign.run(
        case, name, tmp_path, seconds=fuzz_seconds, cases=fuzz_cases, first=fuzz_seed
    )
    print(f"{name}: {sum(counts.values())} files, {dict(counts)}")
    assert not bad, "\n".join(bad)


def test_every_reader_has_a_target() -> None:
    assert sorted(kind for kinds in TARGETS.values() for kind in kinds) == sorted(READERS)


def test_mutations_change_files_and_follow_their_seed() -> None:
    content = (CORPUS / "ply" / "ascii.ply").read_bytes()
    changed = [mutated(content, random.Random(seed)) for seed in range(200)]
    assert changed == [mutated(content, random.Random(seed)) for seed in range(200)]
    assert len(set(changed)) > 150


def test_the_corpus_is_small_and_made_by_its_script() -> None:
    files = {path for path in CORPUS.rglob("*") if path.is_file()}
    assert sum(path.stat().st_size for path in files) < MOST_BYTES
    assert {path.relative_to(CORPUS).as_posix() for path in files} == {*pictures(), *scenes()}
