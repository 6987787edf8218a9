"""Any file is read or refused by its name: files of scenes, pictures and everything that is saved.

Each case changes a whole file in one to eight places and reads it in a child of its own.
"""

import json
import random
import shutil
import warnings

import numpy as np
import pytest

from base.kept_formats import KEPT, WRONG
from fuzz import readers
from fuzz.mutate import mutated
from fuzz.outcome import CLEAN, of_error
from fuzz.readers import CORPUS, READERS
from viscache.base.formats import FormatError

MOST_BYTES = 1 << 20
CORPUS_KINDS = {path.name for path in CORPUS.iterdir()}


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
    "saved": tuple(sorted(set(READERS) - CORPUS_KINDS - {"sweep", "correlation", "flip map"})),
    "stores": ("correlation", "flip map", "sweep"),
}


def changed_file(reader, path, content):
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


def target(wholes):

    def case(seeded):
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
def test_any_file_is_read_or_refused_by_its_name(name, fuzz, tmp_path):
    wholes = []
    for kind in TARGETS[name]:
        (tmp_path / kind).mkdir()
        wholes += [(READERS[kind], path) for path in READERS[kind].seeds(tmp_path / kind)]
    for reader, path in wholes:
        reader.read(changed_file(reader, path, path.read_bytes()))
    fuzz(target(wholes), name)


#: What users do with what was read, beside `Kept.read`.
USES = {"state": readers.state, "maps": readers.cache, "sweep": readers.swept}
USES |= {"frame of a sweep": readers.swept, "comparison": readers.swept}


def exchanged(fields, dice):
    """Put another value in the place of one, at any depth."""
    at = fields
    while True:
        keys = list(at) if isinstance(at, dict) else list(range(len(at)))
        key = dice.choice(keys)
        if not isinstance(at[key], dict | list) or not at[key] or dice.random() < 0.3:
            break
        at = at[key]
    at[key] = dice.choice([*WRONG, *values_of(fields), at[key]])


def values_of(fields):
    return list(fields.values()) if isinstance(fields, dict) else list(fields)


def other_array(array, dice):
    kinds = ("i1", "u4", "i8", "f4", "f8", "?", "U3")
    return dice.choice(
        [
            array.reshape(-1)[: dice.randrange(9)],
            np.zeros(array.shape, dice.choice(kinds)),
            np.zeros((dice.randrange(4),) * dice.randrange(4), array.dtype),
            np.full_like(array, dice.choice([0, 1, 100])),
            array[::-1] if array.ndim else array,
        ]
    )


@pytest.mark.fuzz
@pytest.mark.slow
@pytest.mark.parametrize("name", KEPT)
def test_what_was_changed_with_its_hash_is_read_or_refused_by_its_name(name, fuzz, tmp_path):
    kept, whole = KEPT[name], tmp_path / "whole"
    whole.mkdir()
    place = kept.make(whole).relative_to(whole)

    def case(dice):
        shutil.rmtree(tmp_path / "changed", ignore_errors=True)
        path = shutil.copytree(whole, tmp_path / "changed") / place
        head, arrays = kept.take(path)
        fields = json.loads(head)["fields"]
        for _ in range(dice.randint(1, 3)):
            if arrays and (not fields or dice.random() < 0.5):
                one = dice.choice(sorted(arrays))
                arrays[one] = other_array(arrays[one], dice)
            elif fields:
                exchanged(fields, dice)
        kept.put(path, kept.sealed(kept.form, fields, arrays), arrays)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                kept.read(path)
            except FormatError as error:
                if "changed" not in str(error):
                    raise NamelessError(str(error)) from error
                raise
            USES.get(name, lambda _: None)(path)

    fuzz(case, name)


def test_every_reader_has_a_target():
    assert sorted(kind for kinds in TARGETS.values() for kind in kinds) == sorted(READERS)


def test_mutations_change_files_and_follow_their_seed():
    content = (CORPUS / "ply" / "ascii.ply").read_bytes()
    changed = [mutated(content, random.Random(seed)) for seed in range(200)]
    assert changed == [mutated(content, random.Random(seed)) for seed in range(200)]
    assert len(set(changed)) > 150


def test_the_corpus_is_small():
    sizes = [path.stat().st_size for path in CORPUS.glob("*/*")]
    assert len(sizes) > 30 and sum(sizes) < MOST_BYTES
