"""vc.Progressive with every oracle: what passes keep, threads, stops, states and expectations."""

import functools
from dataclasses import dataclass

import numpy as np
import pytest

import viscache as vc
from viscache.base.formats import FormatError
from viscache.passes import progressive, progressive_state
from viscache.testing import assert_unbiased

SIZE = (48, 32)
LIGHTS, SKY = vc.Whitted(n_vpls=64), vc.Direct(n_environment=8)
#: Coarse, so that its errors show.
VOXELS = vc.NeePlusPlus(n_voxels=4, learn_pixels=768, relearn_pixels=64)


@dataclass(frozen=True)
class HalfBlind:
    """Sees nothing of every n-th lamp, and all of the others."""

    n: int = 3

    def block(self, eyes, lamps, wanted):
        seen = wanted.copy()
        seen[:, :: self.n] = False
        return seen


@pytest.fixture(scope="module")
def window():
    return vc.scenes.window_room()


def picture(scene, visibility, use=None, **options):
    maps = isinstance(visibility, vc.VisMaps) or options.pop("sky", False)
    given = {"visibility": visibility, "use": use, "size": SIZE} | options
    return vc.Progressive(scene, SKY if maps else LIGHTS, **given)


CASES = [
    *((vc.Aqvc(c_e=12), use) for use in ("correct", "replace")),
    (vc.Aqvc(c_e=4, exact_groups=("area",)), "correct"),
    (vc.VisMaps(), None),
    (vc.VisMaps(), "replace"),
    (vc.VisMaps(count_misses=True, sampling="guided"), None),
    *((VOXELS, use) for use in ("replace", "correct", vc.Correct(share=0.2))),
    *((HalfBlind(), use) for use in ("correct", vc.Correct(share=0.2), "replace")),
    (vc.ShadowMap(resolution=64, vpls=True), "correct"),
    (vc.Unoccluded(), "correct"),
]
#: The same tiles keep their rows, whoever comes first; what has no room is traced.
LITTLE_ROOM = {"size": (256, 160), "max_bytes": 1 << 20}


@pytest.mark.parametrize(
    ("visibility", "use"), CASES, ids=[f"{type(v).__name__}-{u}" for v, u in CASES]
)
def test_bytes_depend_on_neither_threads_nor_stops(room, window, tmp_path, visibility, use):
    scene = window if isinstance(visibility, vc.VisMaps) else room
    little = LITTLE_ROOM if isinstance(visibility, vc.Aqvc) and visibility.c_e == 4 else {}
    # From the third pass on the quantized cache uses what the first two have learnt
    n, stop = (5, 2) if isinstance(visibility, vc.Aqvc) and not little else (3, 1)
    whole, parts, resumed, another = (
        picture(scene, visibility, use, threads=threads, first_pass=first, **little)
        for threads, first in ((1, 0), (3, 0), (2, 0), (2, 8))
    )
    want = whole.passes(n).sha256
    parts.passes(stop)
    parts.save(tmp_path / "state.npz")
    resumed.load(tmp_path / "state.npz")
    assert resumed.n_passes == stop
    assert resumed.passes(n - stop).sha256 == parts.passes(n - stop).sha256 == want
    np.testing.assert_array_equal(resumed.frame.layers["variance"], whole.frame.layers["variance"])
    assert resumed.error() == parts.error() == whole.error() > 0
    if little:
        for p in (parts, resumed):
            for name in ("tiles_not_kept", "rays"):
                assert p.frame.counters[name] == whole.frame.counters[name] > 0
            assert p.rows.bytes == whole.rows.bytes > 0
    another.passes(1)
    resumed.merge(another)
    assert resumed.n_passes == n + 1
    with pytest.raises(ValueError, match=r"(visibility\.\w+|size) must be"):
        resumed.merge(picture(scene, vc.Exact(), use, sky=scene is window))


@pytest.mark.parametrize("before", [0, 1])
@pytest.mark.parametrize(
    "visibility",
    [vc.Aqvc(c_e=12), vc.VisMaps(), vc.VisMaps(count_misses=True), VOXELS],
    ids=["rows", "maps", "misses", "voxels"],
)
def test_an_interrupted_pass_leaves_nothing(room, window, visibility, before, monkeypatch):
    scene = window if isinstance(visibility, vc.VisMaps) else room
    want = picture(scene, visibility).passes(before + 2).sha256
    stopped = picture(scene, visibility)
    if before:
        stopped.passes(before)
    whole = progressive.render_part

    def stop(done, total):
        raise KeyboardInterrupt

    monkeypatch.setattr(progressive, "render_part", functools.partial(whole, progress=stop))
    with pytest.raises(KeyboardInterrupt):
        stopped.passes(1)
    monkeypatch.undo()
    assert stopped.n_passes == before
    assert stopped.passes(2).sha256 == want


def test_a_later_pass_adds_the_records_that_it_lacks(window):
    maps = picture(window, vc.VisMaps(n_startup=20))
    records = []
    for _ in range(4):
        frame = maps.passes(1)
        records.append(len(maps.maps.cache))
        assert frame.counters["records"] == records[-1]
    assert 0 < records[0] < records[-1] < 3 * records[0]
    assert frame.counters["records_inserted"] >= records[-1]
    assert frame.counters["records_rays"] == maps.maps.cache.rays
    assert picture(window, vc.Exact(), sky=True).maps is None


def test_wrong_records_are_removed_where_misses_are_counted(window):
    """Their number falls where nearly every error counts as too many."""
    strict = vc.VisMaps(count_misses=True, eps_max=1e-4)
    pictures = [picture(window, v) for v in (strict, vc.VisMaps(eps_max=1e-4))]
    for p in pictures:
        p.passes(3)
    removed = pictures[0].frame.counters["records_inserted"] - len(pictures[0].maps.cache)
    assert removed > 0
    assert len(pictures[1].maps.cache) == pictures[1].frame.counters["records_inserted"]


def test_a_given_cache_stays_as_it_is(window):
    cache = vc.VisibilityMapCache(window)
    cache.update(size=(16, 12))
    before = len(cache)
    fixed = picture(window, vc.VisMaps(cache=cache))
    grown = picture(window, vc.VisMaps(cache=cache, update=True))
    want = fixed.passes(2).sha256
    grown.passes(2)
    assert fixed.maps is None
    assert len(grown.maps.cache) > len(cache) == before
    # The records count, not the object
    copy = vc.VisibilityMapCache(window)
    copy.update(size=(16, 12))
    same = picture(window, vc.VisMaps(cache=copy), first_pass=2)
    same.passes(1)
    fixed.merge(same)
    copy.update(size=SIZE)
    with pytest.raises(ValueError, match=r"visibility\.\w+ must be"):
        fixed.merge(picture(window, vc.VisMaps(cache=copy)))
    assert want != fixed.frame.sha256


def test_voxels_go_on_from_pass_to_pass(room):
    p = picture(room, VOXELS)
    learnt = []
    for _ in range(3):
        learnt.append(p.passes(1).counters["learning_rays"])
    assert all(0 < more < 0.2 * learnt[0] for more in np.diff(learnt))
    assert p.counts.frames == 3
    # Roulette has no bias that passes could not tell
    roulette = picture(room, VOXELS, "replace")
    assert roulette.is_unbiased
    roulette.until(rel_l1=10, passes=5)
    assert picture(room, VOXELS).is_unbiased


@pytest.mark.parametrize(
    ("visibility", "lost"),
    [(vc.Aqvc(c_e=12), "part 1"), (VOXELS, "kept "), (vc.VisMaps(), "kept ")],
    ids=["sums", "voxels", "maps"],
)
def test_a_state_that_lacks_something_is_refused_and_changes_nothing(
    room, window, tmp_path, visibility, lost
):
    """Even where its hash fits."""
    scene, file = window if isinstance(visibility, vc.VisMaps) else room, tmp_path / "state.npz"
    p, other = (picture(scene, visibility) for _ in range(2))
    p.passes(2)
    p.save(file)
    want = other.passes(1).sha256
    fields, arrays = progressive_state.FORMAT.read_npz(file)
    less = {n: values for n, values in arrays.items() if not n.startswith(lost)}
    assert less.keys() < arrays.keys()
    progressive_state.FORMAT.write_npz(file, fields, less)
    with pytest.raises(FormatError, match=lost if lost == "part 1" else "its parts do not fit"):
        other.load(file)
    assert (other.n_passes, other.frame.sha256) == (1, want)


def passes(p, n=36):
    """The picture of each pass, (n, H, W, 3)."""
    sums = [p.passes(1).image.astype(np.float64) * (i + 1) for i in range(n)]
    return np.diff(sums, axis=0, prepend=np.zeros((1, *sums[0].shape)))


@pytest.fixture(scope="module")
def exact(room):
    return passes(picture(room, vc.Exact()))


@pytest.mark.stat
@pytest.mark.parametrize(
    ("visibility", "use"),
    [
        (VOXELS, "correct"),
        (VOXELS, "replace"),
        (HalfBlind(), "correct"),
        (HalfBlind(), vc.Correct(share=0.25)),
    ],
    ids=["means", "roulette", "own", "own, even"],
)
def test_passes_converge_to_exact_visibility(room, exact, visibility, use):
    """2.5 percent of the light would show, and so does the bias of an oracle alone."""
    assert_unbiased(passes(picture(room, visibility, use)), exact, energy=0.025, paired=True)
    if visibility == HalfBlind() and use == "correct":
        with pytest.raises(AssertionError, match="the frames are biased"):
            assert_unbiased(passes(picture(room, visibility, "replace")), exact, paired=True)


#: Numbers of passes for a mean over them, and with a bias that shows soon.
MANY, FEW = 24, 12
COARSE = {"m": 4, "n_startup": 1, "d_max": 1000.0}


@pytest.fixture(scope="module")
def product(window):
    """Passes of product sampling, which have the same eye samples."""
    light = vc.Direct(n_environment=64, environment="product")
    return passes(vc.Progressive(window, light, visibility="exact", size=SIZE), MANY)


@pytest.mark.stat
@pytest.mark.parametrize("options", [{}, {"count_misses": True}], ids=["grow", "removed too"])
def test_passes_of_refined_maps_converge_to_exact_visibility(window, product, options):
    maps = vc.VisMaps(**COARSE, **options)
    assert_unbiased(passes(picture(window, maps), MANY), product, energy=0.03, paired=True)
    if not options:  # in place of visibility they are found wrong
        alone = passes(picture(window, maps, "replace"), FEW)
        with pytest.raises(AssertionError, match="the frames are biased"):
            assert_unbiased(alone, product[:FEW], paired=True)
