"""A table kept over frames: what it reuses, drops and refuses, and how stale bits are found."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core
from viscache.aqvc.table import ENTRY

SIZE = (72, 48)
#: Without shared cells: every eye sample has its own bit.
ALONE = vc.Aqvc(c_e=1e-3)
#: Eye samples of several tiles.
TILED = (560, 40)


def scene(*, blocker=False, intensity=3.0, far=False):
    """A floor under a lamp, with a plate between them that the camera does not see."""
    d = _core.SceneDescription()
    d.name = "floor and lamp"
    floor = np.float32([[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]])
    faces = np.uint32([[0, 1, 2], [0, 2, 3]])
    grey = d.add_material(base_color=(0.5, 0.5, 0.5))
    d.add_mesh(floor, faces, material=grey)
    if blocker:
        d.add_mesh(floor * np.float32(0.1) + np.float32([0.3, 1.8, 0]), faces, material=grey)
    if far:
        d.add_mesh(floor * np.float32(0.1) + np.float32([0, -30, 0]), faces, material=grey)
    d.add_point_light((0.3, 2.0, 0.1), (intensity,) * 3)
    return vc.Scene.from_description(d)


def camera():
    return vc.look_at((0, 1.5, 3.5), (0, 0, 0), (0, 1, 0), 45)


def frame(of, table=None, cache=ALONE, **given):
    passed = {"size": SIZE, "camera": camera()} | given
    return vc.render(of, vc.Direct(), visibility=cache, keep=table, **passed)  # type: ignore[arg-type]


def exact(of):
    return vc.render(of, vc.Direct(), size=SIZE, camera=camera())


def test_a_frame_that_was_seen_before_needs_no_ray():
    table = vc.AqvcTable(table_bytes=1 << 25)
    first, second = (frame(scene(), table) for _ in range(2))
    assert first.counters["rays"] == first.counters["queries"] > 1000
    assert second.counters["rays"] == 0 and second.sha256 == first.sha256
    assert second.counters["reused_kept"] == second.counters["queries"]
    assert first.counters["reused_kept"] == 0
    assert first.counters["table_writes"] == first.counters["rays"]
    assert table.frames == 2 and table.occupancy == pytest.approx(
        1 - np.exp(-first.counters["rays"] / (1 << 23)), rel=0.05
    )
    assert first.parameters["keep"]["frames"] == 1 and second.parameters["keep"]["frames"] == 2


def test_the_first_frame_is_that_of_tiles_without_a_kept_table():
    cache = vc.Aqvc(c_e=8)
    kept = frame(vc.scenes.stairs(), vc.AqvcTable(), cache, camera=None)
    alike = vc.Aqvc(c_e=8, paper=vc.PaperForm(form="pairs", scale_free=True))
    plain = frame(vc.scenes.stairs(), None, alike, camera=None)
    assert kept.sha256 == plain.sha256 and kept.counters["rays"] == plain.counters["rays"]


@pytest.mark.parametrize("forget", [False, True])
def test_kept_frames_and_entries_are_the_same_for_any_number_of_threads(forget):
    found = []
    for threads in (1, 2, 3):
        table, frames = vc.AqvcTable(table_bytes=1 << 16, check=0.3), []
        for c_e in (8, 6, 8):
            given = {"camera": None, "threads": threads, "size": TILED}
            frames.append(frame(vc.scenes.stairs(), table, vc.Aqvc(c_e=c_e), **given))
            if forget and len(frames) < 3:
                table.forget()
        found.append(([(f.sha256, f.counters) for f in frames], table.entries().tolist()))
    assert found[0] == found[1] == found[2]
    assert (frames[1].counters["reused_kept"] > 0) != forget
    # A table that is too small drops bits, so the third frame repeats rays of the first
    assert frames[2].counters["rays"] > 0 and frames[2].counters["evictions"] > 0
    current = table.entries()["current"]
    assert len(current) > 500 and (0 < current.mean() < 1 if forget else current.all())


def test_a_new_epoch_forgets_everything_at_once():
    table = vc.AqvcTable(table_bytes=1 << 25)
    first = frame(scene(), table)
    table.forget()
    after = frame(scene(), table)
    assert after.counters["reused_kept"] == 0 and table.epoch == 1
    assert after.counters["rays"] == first.counters["rays"] and after.sha256 == first.sha256
    assert frame(scene(), table).counters["rays"] == 0
    # Words of the previous epoch still use slots
    assert after.counters["table_occupied"] > 1.9 * first.counters["table_occupied"]


def test_stale_bits_are_exactly_those_whose_visibility_changed():
    before, after = exact(scene()), exact(scene(blocker=True))
    changed = after.counters["occluded"] - before.counters["occluded"]
    assert changed > 100 and after.counters["queries"] == before.counters["queries"]
    table = vc.AqvcTable(table_bytes=1 << 24, check=1.0)
    assert frame(scene(), table).sha256 == before.sha256
    table.moved(scene(blocker=True), forget=False)
    stale = frame(scene(blocker=True), table)
    assert stale.sha256 == before.sha256 and stale.counters["rays"] == 0
    assert stale.counters["wrong_kept"] == changed
    assert stale.counters["checked_kept"] == stale.counters["queries"]
    table.moved(scene(blocker=True))
    fresh = frame(scene(blocker=True), table)
    assert fresh.sha256 == after.sha256 and fresh.counters["reused_kept"] == 0


def test_repair_answers_with_the_ray_and_writes_it_down():
    after = exact(scene(blocker=True))
    table = vc.AqvcTable(table_bytes=1 << 24, check=1.0, repair=True)
    frame(scene(), table)
    table.moved(scene(blocker=True), forget=False)
    repaired, again = (frame(scene(blocker=True), table) for _ in range(2))
    assert repaired.sha256 == again.sha256 == after.sha256
    assert repaired.counters["rays"] == repaired.counters["queries"]
    assert repaired.counters["wrong_kept"] == repaired.counters["table_writes"] > 100
    assert again.counters["wrong_kept"] == 0


def test_a_share_of_the_reused_bits_is_checked_by_frame():
    table = vc.AqvcTable(table_bytes=1 << 24, check=0.25)
    frame(scene(), table)
    table.moved(scene(blocker=True), forget=False)
    counts = [frame(scene(blocker=True), table).counters for _ in range(3)]
    for c in counts:
        n = c["reused_kept"]
        assert abs(c["checked_kept"] - 0.25 * n) < 4 * np.sqrt(0.25 * 0.75 * n)
    assert len({c["wrong_kept"] for c in counts}) > 1


def test_bits_outlive_the_growth_of_the_scene_where_cells_are_scale_free():
    for free in (True, False):
        table = vc.AqvcTable(table_bytes=1 << 22)
        cache = vc.Aqvc(c_e=6, paper=vc.PaperForm(scale_free=free))
        first = frame(scene(), table, cache)
        table.moved(scene(far=True), forget=False)
        if not free:
            with pytest.raises(ValueError, match=r"bounding sphere must be .* frames before"):
                frame(scene(far=True), table, cache)
            continue
        grown = frame(scene(far=True), table, cache)
        assert first.counters["rays"] > 50 and grown.counters["rays"] < 0.1 * first.counters["rays"]
        assert grown.counters["reused_kept"] > 0.9 * grown.counters["queries"]


def test_light_and_camera_may_change_and_geometry_may_not():
    assert scene().geometry_hash == scene(intensity=5.0).geometry_hash
    assert scene().content_hash != scene(intensity=5.0).content_hash
    assert scene().geometry_hash != scene(blocker=True).geometry_hash
    table = vc.AqvcTable(table_bytes=1 << 25)
    frame(scene(), table)
    brighter = frame(scene(intensity=6.0), table)
    assert brighter.counters["rays"] == 0
    frame(scene(), table, camera=vc.look_at((0, 1.6, 3.5), (0, 0, 0), (0, 1, 0), 45))
    with pytest.raises(ValueError, match="geometry of the table's frames before"):
        frame(scene(blocker=True), table)
    # Refused frames leave the table as it was
    assert frame(scene(), table).counters["rays"] == 0


@pytest.mark.parametrize(
    ("visibility", "says"),
    [
        (vc.Aqvc(paper=vc.PaperForm(form="waves")), 'form must be "pairs" with keep'),
        (vc.Aqvc(paper=vc.PaperForm(storage="exact")), 'storage must be "table" with keep'),
        (vc.Exact(), "visibility must be vc.Aqvc"),
    ],
)
def test_what_a_kept_table_cannot_do_is_refused(visibility, says):
    table = vc.AqvcTable(table_bytes=1 << 20)
    frame(scene(), table)
    with pytest.raises(ValueError, match=says):
        frame(scene(), table, visibility)


def test_what_is_no_table_is_refused():
    table = vc.AqvcTable(table_bytes=1 << 20)
    with pytest.raises(ValueError, match=r"integrator must be vc.Direct"):
        vc.render(scene(), vc.Bdpt(), visibility=vc.Aqvc(), size=(8, 8), keep=table)
    with pytest.raises(ValueError, match=r"keep must be vc.AqvcTable"):
        frame(scene(), "table")  # type: ignore[arg-type]
    for wrong in ({"table_bytes": 3}, {"check": 1.5}, {"repair": 1}, {"check": True}):
        with pytest.raises(ValueError, match=f"{next(iter(wrong))} must be"):
            vc.AqvcTable(**wrong)  # type: ignore[arg-type]


def test_an_interrupted_frame_writes_nothing():
    table = vc.AqvcTable(table_bytes=1 << 20)

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        frame(scene(), table, progress=stop, size=(1024, 768))
    assert table.frames == 0
    assert frame(scene(), table).counters["reused_kept"] == 0


def test_entries_are_the_occupied_slots_with_their_bits():
    table = vc.AqvcTable(table_bytes=1 << 14)
    counters, entries = frame(scene(), table).counters, table.entries()
    assert entries.dtype == ENTRY
    replaced = counters["evictions"] + counters["duplicates"]
    assert counters["evictions"] > 0
    assert len(entries) == counters["table_occupied"] == counters["table_writes"] - replaced
    assert len(entries) == round(table.occupancy * counters["table_slots"])
    assert (np.diff(entries["slot"].astype(int)) > 0).all()
    assert entries["slot"].max() < counters["table_slots"]
    assert entries["digest"].min() > 0 and entries["digest"].max() < 1 << 31
    assert entries["current"].all()


def test_the_bits_of_entries_are_the_visibility_that_was_traced():
    exactly = exact(scene(blocker=True)).counters
    table = vc.AqvcTable(table_bytes=1 << 25)
    counters = frame(scene(blocker=True), table).counters
    entries = table.entries()
    replaced = counters["evictions"] + counters["duplicates"]
    visible = exactly["queries"] - exactly["occluded"]
    assert 0.1 < exactly["occluded"] / exactly["queries"] < 0.9
    assert visible - replaced <= entries["visible"].sum() <= visible
    assert replaced < 0.01 * visible


def test_no_entry_is_current_after_forgetting():
    table = vc.AqvcTable(table_bytes=1 << 14)
    frame(scene(), table)
    before = table.entries()
    table.forget()
    forgotten = table.entries()
    assert not forgotten["current"].any()
    for name in ("slot", "digest", "visible"):
        np.testing.assert_array_equal(forgotten[name], before[name])
    c, after = frame(scene(), table).counters, table.entries()
    assert 0 < after["current"].sum() < len(after) == c["table_occupied"]
    # Words of this frame are current; the others keep the previous epoch
    old = after[~after["current"]]
    kept = before[np.isin(before["slot"], old["slot"])]
    for name in ("slot", "digest", "visible"):
        np.testing.assert_array_equal(old[name], kept[name])
    frame(scene(), table)
    again = table.entries()
    assert set(again["slot"][again["current"]]) >= set(after["slot"][after["current"]])
    table.forget()
    assert not table.entries()["current"].any()


def test_a_table_serves_one_frame_at_a_time():
    table = vc.AqvcTable(table_bytes=1 << 20)
    assert table.entries().shape == (0,)

    def ask_again(done, total):
        others = (table.entries, table.forget, lambda: table.moved(scene()))
        for call in (lambda: frame(scene(), table), *others):
            with pytest.raises(ValueError, match="the table must not be in use by another call"):
                call()

    frame(scene(), table, progress=ask_again)
    assert (table.frames, table.epoch) == (1, 0) and len(table.entries()) > 0
