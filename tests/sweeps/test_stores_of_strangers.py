"""Stores that somebody else made: nothing outside their folder is read, replaced or removed."""

import json
import pickle
import shutil
import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import xarray

import viscache as vc
from base.kept_formats import DIRECT, measured, swept
from viscache import report
from viscache.sweeps.flip_maps import flip_map_of
from viscache.sweeps.store import DATABASE_FILES, Store, picture_name
from viscache.sweeps.table import open_dataset

pytestmark = pytest.mark.usefixtures("without_netcdf")
PRECIOUS = b"precious"


@pytest.fixture
def store(finished, tmp_path):
    """A copy of a finished sweep's folder."""
    return shutil.copytree(finished, tmp_path / "store")


@pytest.fixture
def victim(tmp_path):
    path = tmp_path / "victim"
    path.write_bytes(PRECIOUS)
    return path


def change(folder, *statements, **values):
    with closing(sqlite3.connect(folder / "sweep.sqlite")) as db, db:
        for statement in statements:
            db.execute(statement, values)


def names(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*.exr"))


def reference(folder):
    """The name of the picture that all points are compared with."""
    with Store(folder) as opened:
        return picture_name(opened.definition()["points"][0]["paired"])


@pytest.mark.parametrize("name", ["../victim", "{folder}/victim", "frames/../../victim", ""])
@pytest.mark.parametrize("damaged", [False, True])
def test_names_of_pictures_are_not_read(name, damaged, store, victim):
    before, pictures = swept(store), names(store)
    name = name.format(folder=store.parent)
    change(store, "update frames set file = :name", "delete from comparisons", name=name)
    if damaged:
        for picture in pictures:
            (store / picture).write_bytes(b"")
    after = swept(store)
    np.testing.assert_array_equal(after["rel_l1"], before["rel_l1"])
    assert victim.read_bytes() == PRECIOUS and names(store) == pictures
    assert ("mended" in after.attrs) is damaged


@pytest.mark.parametrize("name", ["../.bashrc", "{folder}/.bashrc"])
def test_shared_references_replace_no_file_of_the_user(name, finished, tmp_path):
    home, evil = tmp_path / "home", tmp_path / "evil"
    home.mkdir()
    shutil.copytree(finished, evil / "references")
    for folder, content in ((home, PRECIOUS), (evil, b"evil")):
        (folder / ".bashrc").write_bytes(content)
    change(evil / "references", "update frames set file = :name", name=name.format(folder=home))
    swept(home / "out", references=evil / "references")
    assert (home / ".bashrc").read_bytes() == PRECIOUS
    assert names(home) == [f"out/{name}" for name in names(evil / "references")]


@pytest.mark.parametrize("key", ["../../victim", "A" * 64, "a" * 63, "a" * 64 + "\n", 7])
def test_a_key_that_is_no_hash_is_refused(key, store, victim):
    with pytest.raises(ValueError, match="key of a frame must be 64 hexadecimal digits, got"):
        picture_name(key)
    with Store(store) as opened:
        definition = opened.definition()
        known = definition["points"][0]["key"]
        definition["points"][0]["key"] = key
        opened.define(definition)
    for read in (open_dataset, report.write):
        with pytest.raises(ValueError, match="must be a list of points, whose keys are hashes"):
            read(store)
    change(store, "update frames set key = :new where key = :old", new=key, old=known)
    with Store(store) as opened, pytest.raises(ValueError, match="64 hexadecimal digits"):
        opened.finished()
    assert victim.read_bytes() == PRECIOUS


@pytest.mark.parametrize(
    "name", ["picture", "frames", *(f"sweep.sqlite{e}" for e in DATABASE_FILES)]
)
def test_links_in_the_place_of_files_are_refused(name, store, tmp_path):
    outside = tmp_path / "outside"
    path = store / (reference(store) if name == "picture" else name)
    if path.exists():
        path.rename(outside)
    else:
        outside.write_bytes(PRECIOUS)
    path.symlink_to(outside)
    before = outside.read_bytes() if outside.is_file() else names(outside)
    for use in (swept, report.write, lambda folder: swept(tmp_path / "mine", references=folder)):
        with pytest.raises(ValueError, match="must be a file or folder of its own, got a link to"):
            use(store)
    assert path.is_symlink()
    assert before == (outside.read_bytes() if outside.is_file() else names(outside))


def test_what_is_written_replaces_links_and_not_their_targets(store, victim):
    for name in ("table.csv", "table.nc", "report.html"):
        (store / name).unlink(missing_ok=True)
        (store / name).symlink_to(victim)
    swept(store, over={"c_e": [4, 8, 16]})
    report.write(store)
    assert victim.read_bytes() == PRECIOUS
    assert not (store / "table.csv").is_symlink() and not (store / "report.html").is_symlink()


def test_maps_of_errors_are_neither_read_nor_kept_through_links(tmp_path, victim):
    pictures = [vc.render("cube_on_plane", DIRECT, size=(12, 11), seed=s) for s in range(2)]
    flip_map_of(*pictures, tmp_path)
    (kept,) = (tmp_path / "flip").iterdir()
    kept.unlink()
    kept.symlink_to(victim)
    with pytest.raises(ValueError, match="got a link to"):
        flip_map_of(*pictures, tmp_path)
    kept.unlink()
    (tmp_path / "flip").rename(tmp_path / "outside")
    (tmp_path / "flip").symlink_to(tmp_path / "outside")
    with pytest.raises(ValueError, match="got a link to"):
        flip_map_of(*pictures, tmp_path)
    assert victim.read_bytes() == PRECIOUS and not list((tmp_path / "outside").iterdir())


def journal(of, other):
    """A journal of a transaction over several databases; SQLite removes the file it names last."""
    magic, name = bytes.fromhex("d9d505f920a163d7"), str(other).encode()
    head = magic + struct.pack(">5I", 0, 0, of.stat().st_size // 4096, 512, 4096)
    page = (1 << 30) // 4096 + 1
    end = struct.pack(">2I", len(name), sum(name))
    return b"".join((head.ljust(512, b"\0"), struct.pack(">I", page), name, end, magic))


def test_a_journal_that_names_another_file_is_refused(store, victim):
    database = store / "sweep.sqlite"
    with closing(sqlite3.connect(database)) as db:
        db.execute("PRAGMA journal_mode=DELETE")
    (store / "sweep.sqlite-journal").write_bytes(journal(database, victim))
    with pytest.raises(ValueError, match="must be a journal of this store alone"):
        swept(store)
    assert victim.read_bytes() == PRECIOUS
    with closing(sqlite3.connect(database)) as db:  # what would have happened
        db.execute("SELECT count(*) FROM frames").fetchone()
    assert not victim.exists()


@pytest.mark.parametrize(
    ("statement", "what"),
    [
        ("CREATE TRIGGER t AFTER INSERT ON leases BEGIN DELETE FROM frames; END", "trigger 't'"),
        ("CREATE VIEW v AS SELECT * FROM frames", "view 'v'"),
        ("CREATE INDEX i ON frames (abs(finished))", "index 'i'"),
        ("CREATE VIRTUAL TABLE w USING fts5(x)", "table 'w'"),
    ],
)
def test_a_database_with_more_than_tables_is_refused(statement, what, store):
    try:
        change(store, statement)
    except sqlite3.OperationalError as error:
        pytest.skip(str(error))  # an SQLite without virtual tables
    with pytest.raises(ValueError, match=rf"must have tables only, got the {what}"):
        Store(store)


def test_a_dataset_that_came_as_a_file_opens_no_folder(store, tmp_path):
    """Its attribute may name any folder, such as another sweep of the user."""
    table = open_dataset(store)
    stranger = tmp_path / "mine"
    shutil.copytree(store, stranger)
    (stranger / "report.html").write_bytes(PRECIOUS)
    handed = xarray.Dataset(
        table.data_vars, table.coords, {**table.attrs, "directory": str(stranger)}
    )
    with pytest.raises(ValueError, match="path must be given for a sweep without a directory"):
        report.write(handed)
    assert (stranger / "report.html").read_bytes() == PRECIOUS
    assert report.write(table) == store / "report.html"


def test_definitions_name_no_files(store):
    """A store's texts have no path that is opened: names follow from keys alone."""
    with closing(sqlite3.connect(store / "sweep.sqlite")) as db, db:
        (text,) = db.execute("SELECT record FROM sweep").fetchone()
        keys = [key for (key,) in db.execute("SELECT key FROM frames")]
    assert names(store) == sorted(picture_name(key) for key in keys)
    assert ".exr" not in json.dumps(json.loads(text))


@pytest.mark.parametrize("name", ["rows.npy", "rows", "rows-0-16.npz", "pairs"])
def test_links_in_a_store_of_correlations_are_refused(name, tmp_path):
    def measure():
        return measured(directory=tmp_path / "store")

    measure()
    (rows,) = (tmp_path / "store").iterdir()
    place = {"rows": rows, "pairs": next(rows.glob("pairs-*"))}.get(name, rows / name)
    outside = tmp_path / "outside"
    place.rename(outside)
    place.symlink_to(outside)
    files = [outside] if outside.is_file() else [p for p in outside.rglob("*") if p.is_file()]
    before = {path: path.read_bytes() for path in files}
    with pytest.raises(ValueError, match="must be a file or folder of its own, got a link to"):
        measure()
    assert {path: path.read_bytes() for path in files} == before


class Program:
    """Starts when it is unpickled."""

    def __init__(self, started):
        self.started = started

    def __reduce__(self):
        return Path.touch, (self.started,)


@pytest.mark.parametrize("wrapped", [False, True])
def test_nothing_that_is_read_back_is_unpickled(wrapped, tmp_path):
    """Neither a pickle in the place of a file, nor objects among its arrays."""
    scene, started = vc.scenes.cube_on_plane(), tmp_path / "started"

    def replaced(path):
        objects = np.array([Program(started)], object)
        if not wrapped:
            path.write_bytes(pickle.dumps(objects))
        elif path.suffix == ".npy":
            np.save(path, objects)
        else:
            with np.load(path) as file:
                names = file.files
            np.savez(path, **dict.fromkeys(names, objects))
        return path

    picture = vc.Progressive(scene, DIRECT, visibility="aqvc", size=(8, 6))
    picture.passes(1)
    picture.save(tmp_path / "state.npz")
    cache = vc.VisibilityMapCache(scene, vc.MapSettings(m=4, n_startup=5))
    cache.update(size=(4, 4))
    cache.save(tmp_path / "cache.npz")
    frame, other = (vc.render(scene, DIRECT, size=(12, 11), seed=seed) for seed in range(2))
    flip_map_of(frame, other, tmp_path)
    with pytest.raises(ValueError, match=r"state\.npz"):
        picture.load(replaced(tmp_path / "state.npz"))
    with pytest.raises(ValueError, match=r"cache\.npz"):
        vc.VisibilityMapCache.load(replaced(tmp_path / "cache.npz"), scene)
    replaced(next((tmp_path / "flip").iterdir()))
    assert flip_map_of(frame, other, tmp_path) is not None

    def measure():
        return measured(directory=tmp_path / "store")

    measure()
    for path in (tmp_path / "store").rglob("*.npz"):
        replaced(path)
    measure()
    replaced(next((tmp_path / "store").rglob("rows.npy")))
    with pytest.raises(ValueError, match=r"rows\.npy"):
        measure()
    assert not started.exists()
    pickle.loads(pickle.dumps(Program(started)))
    assert started.exists()
