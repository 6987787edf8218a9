"""vc.Progressive: passes of new eye samples, and what the quantized cache keeps between them."""

import numpy as np
import pytest

import viscache as vc
from render.test_progressive_oracles import LITTLE_ROOM
from viscache.passes.progressive_state import Sums

SIZE = (48, 32)
ROOM = "room?triangles=3000"
LIGHTS = vc.Whitted(n_vpls=64)


def picture(scene, **options):
    given = {"visibility": vc.Aqvc(c_e=12), "size": SIZE} | options
    return vc.Progressive(scene, LIGHTS, **given)


def test_passes_of_exact_visibility_are_frames_of_more_samples(room):
    """The first samples of a pixel are the same in both."""
    passes = picture(room, visibility="exact").passes(4)
    whole = vc.render(room, LIGHTS, size=SIZE, spp=4)
    np.testing.assert_allclose(passes.layers["coverage"], whole.layers["coverage"], atol=1e-6)
    for layer in ("depth", "normal", "albedo"):
        np.testing.assert_allclose(passes.layers[layer], whole.layers[layer], rtol=1e-4, atol=1e-5)
    # Mirrors play roulette with other numbers, so the light is compared as a whole
    assert passes.image.sum() == pytest.approx(whole.image.sum(), rel=0.01)


def test_a_later_pass_traces_what_is_new(room):
    alone = [
        vc.render(room, LIGHTS, visibility=vc.Aqvc(c_e=12), size=SIZE, first_sample=n).counters
        for n in range(6)
    ]
    kept = picture(room, use="replace")
    rays = [kept.passes(1).counters["rays"] for _ in range(6)]
    per_pass = np.diff([0, *rays])
    assert per_pass[0] == alone[0]["rays"]
    assert per_pass[-1] < 0.4 * alone[-1]["rays"]
    assert kept.rows.frames == 6 and kept.rows.bytes > 0


def test_what_rows_answer_is_the_cache_of_all_passes(room):
    """A second frame of the same samples finds every bit, and repeats the first."""
    rows, options = vc.AqvcRows(), {"visibility": vc.Aqvc(c_e=12), "size": SIZE}
    first, second = (vc.render(room, LIGHTS, keep=rows, **options) for _ in range(2))
    assert second.counters["rays"] == 0
    assert first.counters["rays"] > 0
    # What the first frame's finest cells learnt may settle cells that were unknown before
    assert np.abs(second.image - first.image).sum() < 0.02 * first.image.sum()


def test_parts_of_two_machines_merge(room):
    exact = {"visibility": "exact"}
    whole = picture(room, **exact).passes(6)
    first, second = picture(room, **exact), picture(room, first_pass=4, **exact)
    first.passes(4)
    second.passes(2)
    first.merge(second)
    assert first.n_passes == 6
    np.testing.assert_allclose(first.frame.image, whole.image, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(
        first.frame.layers["variance"], whole.layers["variance"], rtol=1e-4, atol=1e-9
    )
    assert first.frame.counters["queries"] == whole.counters["queries"]
    together = picture(room, **exact)
    together.passes(6)
    assert first.error() == pytest.approx(together.error(), rel=1e-4)
    with pytest.raises(ValueError, match="passes must be counted once"):
        first.merge(second)


def test_corrected_passes_have_larger_cells_unless_told_otherwise(room):
    def cache(given, use=None):
        return vc.Progressive(room, LIGHTS, visibility=given, use=use, size=SIZE).visibility

    for given in ("aqvc", vc.Aqvc()):
        made = cache(given)
        assert (made.c_e, made.c_n, made.c_z, made.c_r) == (16, 2, 1, 2)
        assert cache(given, "replace") == vc.Aqvc()
    assert cache(vc.Aqvc(c_e=10, c_n=8)) == vc.Aqvc(c_e=10, c_n=8, c_z=1, c_r=2)
    for preset in ("fast", "paper"):
        assert cache(vc.Aqvc(preset=preset)) == vc.Aqvc(preset=preset)
    picture = vc.Progressive(room, LIGHTS, visibility="aqvc", size=SIZE)
    assert picture.passes(1).parameters["visibility"]["c_n"] == 2


def test_passes_whose_lights_are_all_exact_cost_nothing_more(room, tmp_path):
    """After the first one they are exact passes; with more lights they are not."""
    few, many = vc.Whitted(n_vpls=16), vc.Whitted(n_vpls=64)

    def made(lights, visibility="aqvc", **options):
        return vc.Progressive(room, lights, visibility=visibility, size=SIZE, **options)

    corrected = made(few)
    corrected.passes(1)
    assert corrected._drawn()[0] == vc.Exact()
    corrected.save(tmp_path / "state.npz")
    resumed = made(few)
    resumed.load(tmp_path / "state.npz")
    want = made(few, "exact").passes(3)
    for p in (corrected, resumed):
        frame = p.passes(2)
        assert frame.sha256 == want.sha256
        assert frame.counters["exact_queries"] == frame.counters["queries"]
        assert frame.counters["rays"] == want.counters["rays"]
    for p in (made(many), made(few, renew=2), made(few, use="replace")):
        p.passes(1)
        assert p._drawn()[0] == p.visibility


def test_lights_are_renewed(room):
    renewed = picture(room, renew=2, use="replace")
    rays = np.diff([0, *(renewed.passes(1).counters["rays"] for _ in range(4))])
    assert rays[1] < 0.9 * rays[0]
    assert rays[2] > 1.5 * rays[1]


def test_little_room_is_for_whole_tiles(room):
    """What is saved is the share of the rows that have room."""
    cache = {"visibility": vc.Aqvc(c_e=4, exact_groups=("area",)), "use": "replace"}
    small = picture(room, **LITTLE_ROOM, **cache)
    whole = picture(room, size=LITTLE_ROOM["size"], **cache)
    saved = []
    for p in (small, whole):
        first = p.passes(1).counters["rays"]
        saved.append(2 * first - p.passes(1).counters["rays"])
    assert 0 < small.frame.counters["tiles_not_kept"] < 40  # 8 × 5 tiles of 32²
    assert whole.frame.counters["tiles_not_kept"] == 0
    assert 0 < small.rows.bytes <= small.rows.max_bytes < whole.rows.bytes
    kept = small.rows.cells / whole.rows.cells
    # Tiles of few cells are kept first, and their cells save more
    assert kept <= saved[0] / saved[1] < 1.3 * kept
    tiles = [{tile for tile, _, _ in p.rows._state()} for p in (small, whole) if p.rows]
    assert len(tiles[1] - tiles[0]) == small.frame.counters["tiles_not_kept"]


@pytest.mark.stat
def test_passes_that_learn_have_the_energy_and_the_blocks_of_exact_ones(room):
    """Shares by class and the scale come from the first two passes: all 16 are unbiased."""

    def alone(p):
        sums = [p.passes(1).image * np.float64(n + 1) for n in range(16)]
        return list(np.diff(np.stack([np.zeros_like(sums[0]), *sums]), axis=0))

    options = {"size": (96, 64)}
    exact = alone(picture(room, visibility="exact", **options))
    cache = {"visibility": vc.Aqvc(c_e=24)}
    corrected = picture(room, **cache, **options)
    found = vc.testing.assert_unbiased(alone(corrected), exact, energy=0.005, paired=True)
    assert found.blocks == 6
    assert corrected._sums.shares is not None
    replaced = alone(picture(room, use="replace", **cache, **options))
    with pytest.raises(AssertionError, match="the frames are biased"):
        vc.testing.assert_unbiased(replaced, exact, paired=True)


def test_the_error_is_estimated_from_the_passes(room):
    options = {"visibility": "exact"}
    truth = vc.render(room, LIGHTS, size=SIZE, spp=128, first_sample=1024).image
    short = picture(room, **options)
    for n in (8, 24):
        frame = short.passes(n)
        error = float(np.abs(frame.image - truth).sum() / truth.sum())
        # Two parts of a well-spread sequence are less alike than independent ones
        assert 0.9 * error < short.error() < 2 * error
    done = picture(room, **options).until(rel_l1=1.1 * short.error(), passes=50)
    assert done.parameters["passes"] <= 32


def test_the_error_of_well_spread_samples_is_not_that_of_single_passes():
    """The noise between 64 passes of ambient occlusion tells more than twice their error."""

    def made(first):
        light = vc.AmbientOcclusion(n_samples=4, max_distance=None)
        given = {"visibility": "exact", "size": SIZE, "first_pass": first}
        return vc.Progressive("cube_on_plane", light, **given)

    truth = np.mean([made(1024 + 512 * k).passes(64).image for k in range(4)], axis=0)
    picture = made(0)
    frame = picture.passes(64)
    error = float(np.abs(frame.image - truth).sum() / truth.sum())
    assert 0.9 * error < picture.error() < 2 * error
    between = np.sqrt(frame.layers["variance"]).sum() / truth.sum() * np.sqrt(2 / np.pi)
    assert between > 2 * error


@pytest.mark.stat
@pytest.mark.parametrize("n", [2, 3, 5, 8, 11, 24, 64])
def test_parts_of_independent_passes_tell_the_error_of_their_mean(n):
    rng = np.random.Generator(np.random.PCG64(n))
    sums, truth = Sums(), 5.0
    for k in range(n):
        color = (truth + rng.standard_normal((60, 80, 3))).astype(np.float32)
        frame = vc.Frame(layers={"color": color}, counters={}, timings={}, parameters={})
        sums = sums.plus(frame, k)
    estimated = np.sqrt((sums.deviation() ** 2).mean())
    assert estimated == pytest.approx(1 / np.sqrt(n), rel=0.03)  # 14,400 draws: 4.5 deviations
    m = min((m for m, _ in sums.parts), key=lambda m: abs(2 * m - n))
    assert n / 4 <= m <= 3 * n / 4
    assert len(sums.parts) <= 2


def test_until_stops_by_seconds_or_passes(room):
    quick = picture(room)
    quick.until(seconds=1e-9)
    assert quick.n_passes == 1
    quick.until(seconds=1e9, passes=2)
    assert quick.n_passes == 3


def test_notebooks_show_the_picture_while_it_gets_better(room, monkeypatch):
    from IPython import display

    shown = []

    class Handle:
        def update(self, made):
            shown.append(made.data)

    monkeypatch.setattr(display, "display", lambda *a, **k: Handle())
    p = picture(room)
    p.passes(3, show=True)
    assert 2 <= len(shown) <= 3  # the first, the last, and one a second
    assert all("<img" in text for text in shown)
    assert shown[-1] == p._repr_html_() != shown[0]


def test_wrong_input_is_refused(room, tmp_path):
    p = picture(room)
    odd = {"size": SIZE, "spp": 2, "first_sample": 1}
    for call, message in (
        (lambda: p.frame, "there must be a pass"),
        (p.until, "rel_l1 or seconds must be given"),
        (lambda: p.until(rel_l1=-1), "rel_l1 must be > 0"),
        (
            lambda: picture(room, use="replace").until(rel_l1=0.01),
            'use must be "correct" for rel_l1',
        ),
        (lambda: p.passes(-1), "n must be a whole number"),
        (lambda: picture(room, renew=0), "renew must be a whole number"),
        (lambda: picture(room, first_pass=-1), "first_pass must be a whole number"),
        (lambda: picture(room, max_bytes=3), "max_bytes must be a whole number"),
        (lambda: vc.render(room, LIGHTS, **odd), "first_sample must be a multiple of spp"),
    ):
        with pytest.raises(ValueError, match=message):
            call()


def test_states_of_something_else_are_refused(room, tmp_path):
    file = tmp_path / "state.npz"
    p = picture(room)
    p.passes(1)
    p.save(file)
    with pytest.raises(FileNotFoundError):
        p.load(tmp_path / "absent.npz")
    file.write_bytes(file.read_bytes()[:999])
    with pytest.raises(ValueError, match="must be a saved state"):
        p.load(file)
    assert p.n_passes == 1


def test_numbers_of_numpy_are_saved(room, tmp_path):
    numbers = {name: np.uint64(2) for name in ("seed", "spp", "renew", "first_pass")}
    p = picture(room, visibility="exact", **numbers)
    p.passes(1)
    p.save(tmp_path / "state.npz")
    same = picture(room, visibility="exact", **dict.fromkeys(numbers, 2))
    same.load(tmp_path / "state.npz")
    assert same.frame.sha256 == p.frame.sha256
