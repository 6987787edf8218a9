"""Every format that is read back: its own is read; any other kind, version or content is refused.

The table has all formats of the package; each goes through all changes.
"""

import importlib
import json
import random
import re
import shutil
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest

import viscache as vc
from base.kept_formats import KEPT, WRONG, Row, make_sweep, measured, read_records
from codebase.repository import sources
from viscache.base.formats import FormatError
from viscache.correlation import dataset
from viscache.frame import frame as frame_file
from viscache.sweeps import flip_maps, store
from viscache.sweeps.store import Store

pytestmark = pytest.mark.usefixtures("without_netcdf")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder and the file of a format, made once."""
    made = {}

    def get(name):
        if name not in made:
            folder = tmp_path_factory.mktemp("whole")
            made[name] = (folder, KEPT[name].make(folder))
        return made[name]

    return get


@pytest.fixture(params=KEPT)
def case(request, whole, tmp_path):
    """A format and a copy of its file."""
    folder, path = whole(request.param)
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    return KEPT[request.param], copy / path.relative_to(folder)


def refused(kept, path, says=None):
    """The reader raises one clean error, which names the file, in one line or so."""
    with pytest.raises(ValueError, match=says) as told:
        kept.read(path)
    named = path.name if path.is_file() else "sweep.sqlite"
    assert named in str(told.value) and isinstance(told.value, FormatError)


def fields_of(head):
    return json.loads(head)["fields"]


def test_the_table_has_every_format_and_no_reader_goes_around_it():
    files = sources(".py", under="python/viscache/")
    made = {
        (path.removeprefix("python/viscache/"), name)
        for path, text in files.items()
        for name in re.findall(r"^(\w+) = Format\(", text, re.M)
    }
    forms = {id(kept.form) for kept in KEPT.values()}
    assert len(made) == len(forms) == len({kept.form.kind for kept in KEPT.values()})
    for path, name in made:
        module = importlib.import_module("viscache." + path[:-3].replace("/", "."))
        assert id(getattr(module, name)) in forms, f"{path}: {name} is not in the table"
    loads = {path for path, text in files.items() if "np.load(" in text}
    allowed = ("base/formats.py", "correlation/work_store.py")
    assert loads == {f"python/viscache/{name}" for name in allowed}


def test_what_was_written_is_read(case):
    kept, path = case
    first = kept.read(path)
    head, arrays = kept.take(path)
    kept.form.opened(path, head, arrays)
    assert kept.read(path) == first
    if not isinstance(kept, Row):
        kept.put(path, head, arrays)  # by another program, but the same
        assert kept.read(path) == first


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"kind": "a picture of another program"}, "its kind must be '.*', got 'a picture"),
        ({"version": 99}, "its version must be [0-9]+, got 99"),
        ({"version": 0}, "its version must be [0-9]+, got 0"),
    ],
)
def test_another_kind_or_version_is_refused(change, says, case):
    kept, path = case
    head, arrays = kept.take(path)
    other = replace(kept.form, **change)
    kept.put(path, kept.sealed(other, fields_of(head), arrays), arrays)
    refused(kept, path, None if kept.form is flip_maps.FORMAT else says)


@pytest.mark.parametrize("lost", ["kind", "version", "fields", "sha256", "head", "all"])
def test_a_head_that_lacks_something_is_refused(lost, case):
    kept, path = case
    head, arrays = kept.take(path)
    cut = {name: value for name, value in json.loads(head).items() if name != lost}
    others = {"head": None, "all": b"[]"}
    kept.put(path, others.get(lost, json.dumps(cut).encode()), arrays)
    refused(kept, path)


def test_changed_fields_and_arrays_do_not_fit_the_hash(case):
    kept, path = case
    head, arrays = kept.take(path)
    for name in list(arrays)[:8]:
        changed = arrays[name].copy()
        if changed.size:
            changed.reshape(-1).view(np.uint8)[0] ^= 1
            kept.put(path, head, arrays | {name: changed})
            refused(kept, path)
    for name, value in fields_of(head).items():
        known = json.loads(head)
        known["fields"][name] = [value, value]
        kept.put(path, json.dumps(known).encode(), arrays)
        refused(kept, path)


def test_a_field_of_another_type_is_refused_though_the_hash_fits(case):
    kept, path = case
    head, arrays = kept.take(path)
    fields = fields_of(head)
    assert fields.keys() == kept.form.fields.keys()
    tried = 0
    for name, field in kept.form.fields.items():
        for number, value in enumerate(v for v in WRONG if not field.fits(v)):
            sealed = kept.sealed(kept.form, fields | {name: value}, arrays)
            with pytest.raises(FormatError, match=rf"here must be .*: {name} must be"):
                kept.form.opened("here", sealed, arrays)
            if number < 2:
                kept.put(path, sealed, arrays)
                refused(kept, path, None if kept.form is flip_maps.FORMAT else f"{name} must be")
            tried += 1
    assert tried >= 6 * len(fields) - 18
    for other in ({**fields, "more": 1}, dict(list(fields.items())[1:])):
        if other != fields:
            kept.put(path, kept.sealed(kept.form, other, arrays), arrays)
            refused(kept, path)


def test_an_array_of_another_type_or_shape_is_refused_though_the_hash_fits(case):
    kept, path = case
    head, arrays = kept.take(path)
    fields = fields_of(head)
    for name in arrays:
        wanted = kept.form._array(name)
        assert wanted is not None
        if wanted.dtype is None:
            continue
        given = arrays[name]
        others = [np.zeros(given.shape, kind) for kind in ("f2", "c16")]
        if wanted.shape is not None:
            others += [given[None], np.zeros((0,) * (given.ndim + 1), given.dtype)]
            if given.ndim and any(isinstance(n, int) for n in wanted.shape):
                others.append(np.zeros((9,) * given.ndim, given.dtype))
        for other in others:
            changed = arrays | {name: other}
            kept.put(path, kept.sealed(kept.form, fields, changed), changed)
            refused(kept, path)
    for name in arrays:
        if name in kept.form.arrays:
            fewer = {n: a for n, a in arrays.items() if n != name}
            kept.put(path, kept.sealed(kept.form, fields, fewer), fewer)
            refused(kept, path)
    if arrays:
        more = arrays | {"more": np.zeros(3)}
        kept.put(path, kept.sealed(kept.form, fields, more), more)
        refused(kept, path)


def test_a_changed_byte_is_refused_or_changes_nothing(case):
    kept, path = case
    good, content = kept.read(path), kept.content(path)
    dice = random.Random(0)
    refusals = 0
    for _ in range(40):
        damaged = bytearray(content)
        damaged[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
        kept.damage(path, bytes(damaged))
        try:
            assert kept.read(path) == good
        except FormatError:
            refusals += 1
    assert refusals >= 10


@pytest.mark.parametrize("end", [0, 1, 100, 0.5, -1, -30])
def test_a_file_that_is_cut_off_is_refused(end, case):
    kept, path = case
    content = kept.content(path)
    kept.damage(path, content[: int(end * len(content)) if 0 < end < 1 else int(end)])
    refused(kept, path)


@pytest.mark.parametrize("change", ["dtype", "dims", "lost", "no NetCDF"])
def test_a_dataset_without_statistics_is_refused_though_the_hash_fits(change, tmp_path):
    found = measured()
    changed = {
        "dtype": found.assign(mean=found["mean"].astype("f4")),
        "dims": found.assign(mean=found["mean"].transpose()),
        "lost": found.drop_vars("se"),
        "no NetCDF": found,
    }[change]
    path = tmp_path / "changed.nc"
    vc.correlation.save_dataset(changed, path)
    if change == "no NetCDF":
        path.write_bytes(b"text" + dataset._trailer(b"text"))
    with pytest.raises(FormatError, match=r"changed\.nc must be a NetCDF file of corr"):
        vc.correlation.load_dataset(path)


def test_a_frame_of_other_numbers_is_refused(tmp_path):
    """Half the bits, but the same pixels and a hash that fits."""
    path = tmp_path / "frame.exr"
    vc.Frame(layers={"color": np.ones((4, 5, 3))}).save(path)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header = {n: v for n, v in file.header().items() if n != "channels"}
    pixels = {name: np.ones((4, 5), np.float16) for name in "RGB"}
    OpenEXR.File(header, pixels).write(str(path))
    with pytest.raises(FormatError, match="channels must be float32, got others in"):
        vc.Frame.load(path)
    del header[frame_file.ATTRIBUTE]
    OpenEXR.File(header, pixels).write(str(path))
    assert vc.Frame.load(path).image.max() == 1


def test_stores_of_others_and_of_before_are_refused_before_they_change(tmp_path):
    def made(*statements):
        path = tmp_path / "sweep.sqlite"
        path.unlink(missing_ok=True)
        with closing(sqlite3.connect(path)) as db, db:
            for statement in statements:
                db.execute(statement)
        return path

    application = f"PRAGMA application_id = {store.APPLICATION}"
    table = "CREATE TABLE frames (key TEXT PRIMARY KEY, spec TEXT)"
    for statements, given in (
        ([table], "a database without that version"),
        ([table, "PRAGMA user_version = 2"], "a database without that version"),
        ([table, application], "got 0"),
        ([table, application, "PRAGMA user_version = 3"], "got 3"),
    ):
        path = made(*statements)
        before = path.read_bytes()
        with pytest.raises(FormatError, match=rf"sweep\.sqlite must be .*version 2, .*{given}"):
            Store(tmp_path)
        assert path.read_bytes() == before
    made(application, f"PRAGMA user_version = {store.VERSION}", table)
    with pytest.raises(ValueError, match=r"sweep\.sqlite is not a sweep's store"), Store(tmp_path):
        pass


@pytest.mark.parametrize("change", ["swapped", "index", "dims"])
def test_rows_of_a_store_stand_where_they_belong(change, tmp_path):
    make_sweep(tmp_path)
    with Store(tmp_path) as opened:
        if change == "swapped":
            rows = opened._db.execute("SELECT record FROM frames ORDER BY key").fetchall()
            opened._db.execute("UPDATE frames SET record = ?", rows[0])
        else:
            definition = opened.definition()
            if change == "dims":
                definition["dims"] = ["other"]
            else:
                definition["points"][0]["index"] = [7, 0]
            opened.define(definition)
        with pytest.raises(FormatError, match=r"sweep\.sqlite"):
            read_records(opened), opened.definition()
