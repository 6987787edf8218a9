"""Disks that are really full: a tmpfs of 300 kB. Nothing is half written; work goes on later."""

import functools
import os
import subprocess
import sys

import numpy as np
import pytest

import viscache as vc
from viscache import cli

SCENE, LIGHTS = "cube_on_plane", vc.Direct(n_area=1, n_environment=1, n_brdf=1)


def run(*words):
    try:
        return subprocess.run([str(w) for w in words], capture_output=True, text=True)
    except FileNotFoundError as error:  # a machine without the program
        return subprocess.CompletedProcess(words, 127, "", str(error))


class SmallDisk:
    """A folder on a disk of its own."""

    def __init__(self, folder):
        self.folder = folder

    def fill(self, leave):
        at = os.statvfs(self.folder)
        (self.folder / "filler").write_bytes(bytes(at.f_bavail * at.f_frsize - leave))

    def make_room(self):
        (self.folder / "filler").unlink(missing_ok=True)
        assert run("mount", "-o", "remount,size=64m", self.folder).returncode == 0

    def files(self):
        found = (p for p in self.folder.rglob("*") if p.is_file())
        return {str(p.relative_to(self.folder)) for p in found} - {"filler"}


@pytest.fixture
def disk(tmp_path):
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = run("mount", "-t", "tmpfs", "-o", "size=300k", "viscache-test", folder)
    if mounted.returncode:
        pytest.skip(f"a tmpfs cannot be mounted: {mounted.stderr.strip()}")
    try:
        yield SmallDisk(folder)
    finally:
        if run("umount", folder).returncode:
            run("umount", "-l", folder)


def test_in_a_namespace_where_this_user_may_mount(tmp_path):
    """Runs this file again as the root of a user namespace, where mounting is refused here."""
    folder = tmp_path / "try"
    folder.mkdir()
    if run("mount", "-t", "tmpfs", "viscache-test", folder).returncode == 0:
        run("umount", folder)
        pytest.skip("this user may mount, so the other tests ran")
    inside = ("unshare", "-rm")
    if run(*inside, "mount", "-t", "tmpfs", "viscache-test", folder).returncode:
        pytest.skip("neither this user nor a user namespace may mount a tmpfs")
    done = run(*inside, sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", __file__)
    assert done.returncode == 0, done.stdout


def one_line(capsys, words):
    """What a command says that ends for lack of room."""
    capsys.readouterr()
    assert cli.main(words) == 2
    told = capsys.readouterr().err.strip().splitlines()[-1]
    assert "Traceback" not in told and "make room and run" in told
    return told


def test_a_state_is_the_last_whole_one(disk):
    def picture():
        return vc.Progressive(SCENE, LIGHTS, size=(24, 16), threads=1)

    going, state = picture(), disk.folder / "state.npz"
    going.passes(1)
    going.save(state)
    disk.fill(leave=8_000)
    going.passes(1)
    with pytest.raises(OSError, match=r"state\.npz"):
        going.save(state)
    assert disk.files() == {"state.npz"}
    again = picture()
    again.load(state)
    assert again.n_passes == 1
    assert again.passes(1).sha256 == going.passes(0).sha256
    disk.make_room()
    again.save(state)
    third = picture()
    third.load(state)
    assert third.n_passes == 2


def test_a_sweep_goes_on_when_there_is_room(disk, tmp_path, capsys):
    toml = tmp_path / "s.toml"
    toml.write_text(
        f'scene = "{SCENE}"\nsize = [48, 32]\nmetrics = ["rel_l1"]\n'
        "[over]\nc_e = [2, 4, 8, 16, 32]\n"
    )
    folder = disk.folder / "out"
    told = one_line(capsys, ["sweep", str(toml), "-o", str(folder)])
    assert str(folder) in told
    assert not [name for name in disk.files() if name.endswith(".part")]
    pictures = sorted((folder / "frames").glob("*.exr"))
    assert pictures
    for path in pictures:
        vc.Frame.load(path)
    disk.make_room()
    before = {path: path.stat().st_mtime_ns for path in pictures}
    assert cli.main(["sweep", str(toml), "-o", str(folder)]) == 0
    kept = [path for path in pictures if path.stat().st_mtime_ns == before[path]]
    assert kept  # finished frames are not rendered again
    assert cli.main(["sweep", str(toml), "-o", str(tmp_path / "whole")]) == 0
    tables = [(f / "table.csv").read_text().splitlines() for f in (folder, tmp_path / "whole")]
    assert errors(tables[0]) == errors(tables[1])


def errors(table):
    head = table[0].split(",")
    columns = [head.index("c_e"), head.index("rel_l1")]
    return sorted(tuple(row.split(",")[i] for i in columns) for row in table[1:])


def test_a_figure_is_drawn_when_there_is_room(disk, capsys):
    disk.fill(leave=4_096)
    command = ["reproduce", "vlf-fig1", "--quick", "-o", str(disk.folder)]
    told = one_line(capsys, command)
    assert str(disk.folder) in told
    assert not [name for name in disk.files() if name.endswith(".part")]
    disk.make_room()
    assert cli.main(command) == 0


CORRELATION = {
    "scene": SCENE, "n_points": 2000, "map_size": 32, "d_edges": 4, "theta_edges_deg": 4,
    "threads": 1,
}  # fmt: skip
CORRELATE = f"""
import sys, viscache as vc
try:
    vc.correlation.measure(directory=sys.argv[1], **{CORRELATION})
except OSError as error:
    sys.exit(f"OSError: {{error}}")
"""


@functools.cache
def with_room_from_the_start():
    return vc.correlation.measure(**CORRELATION)["mean"]


@pytest.mark.parametrize("leave", [0, 4_096, 100_000, 270_000])
def test_a_correlation_goes_on_when_there_is_room(disk, leave):
    """Its rows are mapped to memory: no page may be missing where they are written."""
    disk.fill(leave)
    store = disk.folder / "store"
    ended = run(sys.executable, "-c", CORRELATE, store)  # a missing page would end this process
    assert ended.returncode == 1, (ended.returncode, ended.stderr)
    told = ended.stderr.strip()
    assert told.startswith("OSError") and str(disk.folder) in told and "\n" not in told
    assert not [name for name in disk.files() if name.endswith(".part")]
    disk.make_room()
    again = vc.correlation.measure(directory=store, **CORRELATION)["mean"]
    np.testing.assert_array_equal(again, with_room_from_the_start())


WRITE_NETCDF = """
import os, subprocess, sys
from pathlib import Path
import numpy as np, xarray, viscache as vc
from viscache.sweeps.table import write_table
folder = Path(sys.argv[1])
lights = vc.Direct(environment="shared", n_environment=64)
conn = vc.connections(vc.scenes.cube_on_plane(), lights, size=(96, 60), env=1.0, threads=1)
noise = np.random.default_rng(0).random((4, 20_000))
names = ("mean", "se", "n", "sigma")
made = xarray.Dataset({name: ("x", noise[i]) for i, name in enumerate(names)})
writers = {
    "queries.nc": lambda path: vc.record_queries(conn, vc.Aqvc(), path, max_bytes=1 << 21),
    "dataset.nc": lambda path: vc.correlation.save_dataset(made, path),
    "table.nc": lambda path: write_table(made, path),
}
for name in writers:
    (folder / name).write_bytes(b"old")
for leave in (0, 4_096, 100_000):
    filler = folder / "filler"
    filler.unlink(missing_ok=True)
    at = os.statvfs(folder)
    filler.write_bytes(bytes(at.f_bavail * at.f_frsize - leave))
    for name, write in writers.items():
        try:
            write(folder / name)
        except OSError as error:
            print(error)
        assert (folder / name).read_bytes() == b"old"
        assert {p.name for p in folder.iterdir()} == {"filler", *writers}
subprocess.run(["mount", "-o", "remount,size=64m", folder], check=True)
for name, write in writers.items():
    write(folder / name)
    with xarray.open_dataset(folder / name, engine="h5netcdf") as file:
        assert all(np.isfinite(file[n].values).all() for n in file.data_vars)
"""


def test_a_netcdf_file_is_the_old_one_or_the_new_one(disk):
    """HDF5 would end the process some time after a write that its disk refused."""
    ended = run(sys.executable, "-c", WRITE_NETCDF, disk.folder)
    assert ended.returncode == 0, (ended.returncode, ended.stderr)
    names = ["queries.nc", "dataset.nc", "table.nc"] * 3
    for told, name in zip(ended.stdout.splitlines(), names, strict=True):
        assert told == f"[Errno 28] No space left on device: '{disk.folder / name}'"
    assert disk.files() == set(names)
