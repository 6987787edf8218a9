"""All formats that are read back: what writes them, what reads them, and how to change a file."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

import viscache as vc
from viscache.base import formats
from viscache.base.formats import Format, FormatError
from viscache.correlation import dataset, pair_table, tasks, work_store
from viscache.frame import frame as frame_file
from viscache.passes import progressive_state
from viscache.sweeps import flip_maps, records
from viscache.sweeps.store import Store
from viscache.vismap import cache_file

DIRECT = vc.Direct(n_area=1, n_environment=1, n_brdf=1)
SIZE = (8, 6)


@dataclass(frozen=True)
class Kept:
    """A format, what makes a file of it, and what reads that file as users do."""

    form: Format
    make: Callable[[Path], Path]
    read: Callable[[Path], Any]

    def take(self, path: Path):
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
        return arrays.pop(formats.HEAD).tobytes(), arrays

    def put(self, path: Path, head: bytes | None, arrays) -> None:
        if head is not None:
            arrays = arrays | {formats.HEAD: np.frombuffer(head, np.uint8)}
        np.savez(path, **arrays)

    def sealed(self, form: Format, fields, arrays) -> bytes:
        return form.sealed(fields, arrays).encode()

    def content(self, path: Path) -> bytes:
        """The bytes in which damage is tried."""
        return path.read_bytes()

    def damage(self, path: Path, content: bytes) -> None:
        path.write_bytes(content)


class Row(Kept):
    """A row of a store; its record is the head."""

    def take(self, path: Path):
        return self.content(path), {}

    def put(self, path: Path, head: bytes | None, arrays) -> None:
        self.damage(path, b"" if head is None else head)

    @property
    def table(self) -> str:
        tables = {
            "sweep": records.SWEEP,
            "frames": records.FRAME,
            "comparisons": records.COMPARISON,
        }
        return next(name for name, form in tables.items() if form is self.form)

    def content(self, path: Path) -> bytes:
        with closing(sqlite3.connect(path / "sweep.sqlite")) as db:
            query = f"SELECT CAST(record AS BLOB) FROM {self.table} ORDER BY rowid"
            return bytes(db.execute(query).fetchone()[0])

    def damage(self, path: Path, content: bytes) -> None:
        with closing(sqlite3.connect(path / "sweep.sqlite")) as db, db:
            first = f"(SELECT min(rowid) FROM {self.table})"
            db.execute(f"UPDATE {self.table} SET record = ? WHERE rowid = {first}", (content,))


class Exr(Kept):
    """A frame: the head is an attribute, and the pixels have hashes among its fields."""

    def take(self, path: Path):
        with OpenEXR.File(str(path), separate_channels=True) as file:
            return file.header()[frame_file.ATTRIBUTE].encode(), {}

    def put(self, path: Path, head: bytes | None, arrays) -> None:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            header = {n: v for n, v in file.header().items() if n != "channels"}
            planes = {n: np.array(c.pixels) for n, c in file.channels().items()}
        header[frame_file.ATTRIBUTE] = "" if head is None else head.decode()
        OpenEXR.File(header, planes).write(str(path))


class NetCdf(Kept):
    """A dataset: the head is a line after the content."""

    def take(self, path: Path):
        content, line = path.read_bytes().rstrip(b"\n").rsplit(b"\n", 1)
        return line, {"content": np.frombuffer(content, np.uint8)}

    def put(self, path: Path, head: bytes | None, arrays) -> None:
        content = b"".join(array.tobytes() for array in arrays.values())
        path.write_bytes(content + (b"" if head is None else b"\n" + head + b"\n"))


def picture() -> vc.Progressive:
    lights = vc.Whitted(n_vpls=4, n_area=1, n_environment=1, n_brdf=1)
    return vc.Progressive(
        "cube_on_plane", lights, visibility=vc.Aqvc(exact_groups=()), size=SIZE, threads=1
    )


def make_state(folder: Path) -> Path:
    made = picture()
    made.passes(2)
    made.save(folder / "state.npz")
    return folder / "state.npz"


def read_state(path: Path):
    """A refused state changes nothing."""
    made = picture()
    assert made.rows is not None
    made.passes(1)
    sums, cells = made._sums, made.rows.cells
    try:
        made.load(path)
    except ValueError:
        assert made._sums is sums and made.rows.cells == cells
        raise
    found = made._sums
    layers = {name: layer.tobytes() for name, layer in found.layers.items()}
    return layers, found.numbers, found.counters, found.warnings, made.rows.cells


def maps() -> vc.VisibilityMapCache:
    return vc.VisibilityMapCache("cube_on_plane", vc.MapSettings(m=4, n_startup=5))


def make_maps(folder: Path) -> Path:
    made = maps()
    made.update(size=SIZE, threads=1)
    made.save(folder / "maps.npz")
    return folder / "maps.npz"


def read_maps(path: Path):
    found = vc.VisibilityMapCache.load(path, "cube_on_plane")
    arrays = found._core.records()
    return found.settings, found.rays, {name: a.tobytes() for name, a in arrays.items()}


def make_frame(folder: Path) -> Path:
    vc.render("cube_on_plane", DIRECT, size=SIZE, threads=1).save(folder / "frame.exr")
    return folder / "frame.exr"


def read_frame(path: Path):
    found = vc.Frame.load(path)
    return {name: layer.tobytes() for name, layer in found.layers.items()}, found.summary()


def measured(**more):
    given = {"n_points": 16, "map_size": 4, "d_edges": 4, "theta_edges_deg": 4}
    return vc.correlation.measure("cube_on_plane", threads=1, **(given | more))


def make_dataset(folder: Path) -> Path:
    vc.correlation.save_dataset(measured(), folder / "correlation.nc")
    return folder / "correlation.nc"


def read_dataset(path: Path):
    found = vc.correlation.load_dataset(path)
    return {n: v.values.tobytes() for n, v in found.variables.items()}, str(found.attrs)


def make_table(folder: Path) -> Path:
    sums = {name: np.ones((1, 2, 3), np.int64) for name in pair_table.SUMS}
    edges = {"d_edges": np.arange(3.0), "theta_edges_deg": np.arange(4.0)}
    pair_table.PairTable(**sums, **edges).to_npz(folder / "pairs.npz")
    return folder / "pairs.npz"


def read_table(path: Path):
    found = pair_table.PairTable.from_npz(path)
    return [getattr(found, name).tolist() for name in pair_table.FORMAT.arrays]


@cache
def two_frames() -> list[vc.Frame]:
    return [vc.render("cube_on_plane", DIRECT, size=(12, 11), seed=s, threads=1) for s in (0, 1)]


def make_flip(folder: Path) -> Path:
    flip_maps.flip_map_of(*two_frames(), folder)
    (path,) = (folder / "flip").iterdir()
    return path


def read_flip(path: Path):
    """A sweep measures it again."""
    frames = two_frames()
    found = flip_maps.kept(frames[0], frames[1], path.parents[1])
    if found is None:
        raise FormatError(f"{path} is measured again")
    return found.errors.tobytes(), found.mean


def make_block(name: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        measured(directory=folder)
        return next(folder.rglob(name))

    return make


def read_block(path: Path):
    """A measurement computes it again, and says so."""
    folder = next(f for f in path.parents if (f / "rows.npy").exists())
    opened = work_store.FolderStore(folder, np.load(folder / "rows.npy", mmap_mode="r").shape)
    name = str(path.relative_to(folder).with_suffix(""))
    rows = slice(0, 16) if name.startswith("rows") else None
    found = opened.get(name, rows)
    if found is None:
        (line,) = opened.mended
        assert str(path) in line and line.endswith("computed again")
        raise FormatError(line)
    return {name: array.tobytes() for name, array in found.items()}


def read_points(path: Path):
    _, arrays = tasks.POINTS.read_npz(path)
    return {name: array.tobytes() for name, array in arrays.items()}


def make_points(folder: Path) -> Path:
    points = np.ones((5, 3), np.float32)
    given = tasks.Points(positions=points, normals=points, group=np.zeros(5, np.int32))
    tasks.write_points(folder / "work", given, points)
    return folder / "work" / "points.npz"


def swept(folder: Path, **more):
    """A small sweep in a folder; what is there already is taken."""
    given = {"over": {"c_e": [4, 8]}, "size": (12, 11), "metrics": ["rel_l1"]}
    return vc.sweep("cube_on_plane", DIRECT, directory=folder, threads=1, **(given | more))


def make_sweep(folder: Path) -> Path:
    swept(folder, over={"c_e": [4.0]})
    return folder


def opened_store(read):
    def run(path: Path):
        with Store(path) as opened:
            return read(opened)

    return run


def read_comparison(opened: Store):
    point = opened.definition()["points"][0]
    return opened.compared(point["key"], point["paired"])


def read_records(opened: Store):
    keys = sorted(key for (key,) in opened._db.execute("SELECT key FROM frames"))
    return [opened.get(key) for key in keys]


KEPT = {
    "state": Kept(progressive_state.FORMAT, make_state, read_state),
    "maps": Kept(cache_file.FORMAT, make_maps, read_maps),
    "frame": Exr(frame_file.FORMAT, make_frame, read_frame),
    "dataset": NetCdf(dataset.FORMAT, make_dataset, read_dataset),
    "pair table": Kept(pair_table.FORMAT, make_table, read_table),
    "flip map": Kept(flip_maps.FORMAT, make_flip, read_flip),
    "rows": Kept(work_store.ROWS, make_block("rows-*.npz"), read_block),
    "pairs": Kept(work_store.PAIRS, make_block("pairs-0*.npz"), read_block),
    "points": Kept(tasks.POINTS, make_points, read_points),
    "sweep": Row(records.SWEEP, make_sweep, opened_store(Store.definition)),
    "frame of a sweep": Row(records.FRAME, make_sweep, opened_store(read_records)),
    "comparison": Row(records.COMPARISON, make_sweep, opened_store(read_comparison)),
}

#: Values of every type of JSON, out of every range.
WRONG = (
    *(None, True, -1, 1.5, 2**70, float("nan"), "", "x", [], [1], [[3, 1]], ["x"]),
    *({}, {"a": None}, {"a": [1, 2]}, {"a": {}}, {"rays": "many"}),
)
