"""What stores load is checked: damage is mended and told, or refused by name in one line."""

import shutil
import sqlite3
from contextlib import closing

import numpy as np
import pytest

import viscache as vc
from base.kept_formats import DIRECT, measured, swept
from viscache import cli
from viscache.base.array_digests import layer_digests
from viscache.base.formats import FormatError
from viscache.correlation import work_store
from viscache.sweeps.store import Store

pytestmark = pytest.mark.usefixtures("without_netcdf")


def picture(folder, of):
    """The picture of the first frame whose parameters have these words."""
    with closing(sqlite3.connect(folder / "sweep.sqlite")) as db, db:
        query = "select file from frames where record like ? order by key"
        return folder / db.execute(query, (f'%"parameters": %{of}%',)).fetchone()[0]


def forget_comparisons(folder):
    with closing(sqlite3.connect(folder / "sweep.sqlite")) as db, db:
        db.execute("delete from comparisons")


def brighter(path):
    frame = vc.Frame.load(path)
    frame.layers["color"] *= 3
    frame.save(path)


def other_layer(layer):
    """A whole picture whose other layers are as they were."""

    def exchange(path):
        frame = vc.Frame.load(path)
        frame.layers[layer] = frame.layers[layer] + np.float32(0.25)
        frame.save(path)

    return exchange


def without_a_layer(path):
    frame = vc.Frame.load(path)
    del frame.layers["depth"]
    frame.save(path)


def cut(path):
    path.write_bytes(path.read_bytes()[:-200])


#: Every layer of a frame of direct light.
LAYERS = sorted(vc.render("cube_on_plane", DIRECT, size=(8, 8)).layers)


def content(path):
    return layer_digests(vc.Frame.load(path).layers)


@pytest.mark.parametrize(
    "damage", [brighter, cut, without_a_layer, *(other_layer(n) for n in LAYERS)]
)
@pytest.mark.parametrize("of", ['"Exact"', '"Aqvc"'])
def test_a_picture_that_is_not_the_stored_one_is_rendered_again(finished, tmp_path, damage, of):
    before = swept(shutil.copytree(finished, tmp_path, dirs_exist_ok=True))
    target = picture(tmp_path, of)
    good = content(target)
    damage(target)
    forget_comparisons(tmp_path)
    after = swept(tmp_path)
    np.testing.assert_array_equal(after["rel_l1"], before["rel_l1"])
    assert target.name in after.attrs["mended"] and "\n" not in after.attrs["mended"]
    assert content(target) == good
    assert "mended" not in swept(tmp_path).attrs


def test_the_command_says_in_one_line_what_it_rendered_again(tmp_path, capsys):
    toml = tmp_path / "s.toml"
    toml.write_text(
        'scene = "cube_on_plane"\nsize = [8, 8]\nmetrics = ["rel_l1"]\n[over]\nc_e = [4]\n'
    )
    command = ["sweep", str(toml), "-o", str(tmp_path / "out")]
    assert cli.main(command) == 0
    brighter(picture(tmp_path / "out", '"Exact"'))
    forget_comparisons(tmp_path / "out")
    capsys.readouterr()
    assert cli.main(command) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if "rendered again" in line]
    assert len(lines) == 1 and ".exr" in lines[0]


def test_a_report_refuses_another_picture_by_name(tmp_path, capsys):
    swept(tmp_path)
    target = picture(tmp_path, '"Exact"')
    brighter(target)
    assert cli.main(["report", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert str(target) in told and "delete it and run the sweep again" in told
    with Store(tmp_path) as store, pytest.raises(FormatError, match=target.name):
        store.frame(next(k for k in store.finished() if target.name in f"frames/{k[:20]}.exr"))


def damaged(data, start, step):
    changed = bytearray(data)
    for i in range(start, len(changed), step):
        changed[i] ^= 0xFF
    return bytes(changed)


@pytest.mark.parametrize("seed", range(6))
def test_a_damaged_database_is_one_line_with_its_name(finished, tmp_path, seed, capsys):
    shutil.copytree(finished, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "sweep.sqlite"
    with closing(sqlite3.connect(path)) as db, db:
        db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        db.execute("PRAGMA journal_mode=DELETE")
    rng = np.random.default_rng(seed)
    good = path.read_bytes()
    path.write_bytes(damaged(good, int(rng.integers(0, 9000)), int(rng.integers(7, 2000))))
    try:
        swept(tmp_path)
    except (ValueError, OSError) as error:
        assert "sweep.sqlite" in str(error)
    path.write_bytes(damaged(good, int(rng.integers(0, 9000)), int(rng.integers(7, 2000))))
    assert cli.main(["report", str(tmp_path)]) in (0, 1, 2)
    assert "Traceback" not in capsys.readouterr().err


def correlation(folder, **more):
    return measured(directory=folder, **more)


def blocks(folder):
    return sorted(p for p in folder.rglob("*.npz") if p.name != "points.npz")


def short(path):
    path.write_bytes(path.read_bytes()[:100])


def flipped(path):
    path.write_bytes(damaged(path.read_bytes(), 150, 500))


def exchanged(path):
    """A whole file with other numbers."""
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    key = next(k for k in arrays if arrays[k].dtype.kind in "iuf")
    np.savez(path, **(arrays | {key: arrays[key] + 1}))


@pytest.mark.parametrize("damage", [short, flipped, exchanged])
def test_a_damaged_block_of_a_correlation_is_computed_again(tmp_path, damage):
    good = correlation(tmp_path)
    assert len(blocks(tmp_path)) >= 2 and "mended" not in good.attrs
    for path in blocks(tmp_path):
        damage(path)
    again = correlation(tmp_path)
    np.testing.assert_array_equal(again["mean"], good["mean"])
    lines = again.attrs["mended"].splitlines()
    assert len(lines) == len(blocks(tmp_path))
    assert all(p.name in "".join(lines) for p in blocks(tmp_path))
    assert "mended" not in correlation(tmp_path).attrs


def test_damaged_rows_are_traced_again(tmp_path):
    good = correlation(tmp_path)
    path = next(tmp_path.rglob("rows.npy"))
    path.write_bytes(damaged(path.read_bytes(), 256, 97))
    again = correlation(tmp_path, theta_edges_deg=3)  # other bins, so that pairs are counted anew
    assert "rows-0-16.npz" in again.attrs["mended"]
    np.testing.assert_array_equal(
        again["mean"], correlation(tmp_path / "new", theta_edges_deg=3)["mean"]
    )
    assert good.sizes["theta"] != again.sizes["theta"]


def test_a_process_that_comes_second_takes_the_rows_of_the_first(tmp_path):
    """Both saw no file; the second must not put another one over it."""
    first = work_store.FolderStore(tmp_path, (4, 8))
    first.bits[:] = 7
    work_store._create_rows(first.path, (4, 8))
    second = work_store.FolderStore(tmp_path, (4, 8))
    assert (second.bits == 7).all()
    second.bits[1] = 9
    assert (first.bits[1] == 9).all()
    assert [p.name for p in tmp_path.iterdir()] == ["rows.npy"]


#: Changes of the header of `rows.npy`; the spaces that fill it make room for more digits.
DAMAGES = {
    "no array": lambda whole: b"no array",
    "a header that ends too soon": lambda whole: whole.replace(b"}", b"(", 1),
    "a shape beyond 64 bits": lambda whole: whole.replace(b"(", b"(9" + 22 * b"0", 1).replace(
        23 * b" ", b"", 1
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_rows_that_are_no_array_are_refused_by_name(tmp_path, damage):
    correlation(tmp_path)
    path = next(tmp_path.rglob("rows.npy"))
    whole = path.read_bytes()
    path.write_bytes(DAMAGES[damage](whole))
    with pytest.raises(ValueError, match=r"rows\.npy cannot be read: .*delete it"):
        correlation(tmp_path)
