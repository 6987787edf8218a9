"""Oracles written in Python: rendered, swept, corrected; wrong ones are refused."""

from dataclasses import dataclass

import numpy as np
import pytest

import viscache as vc

SIZE = (64, 40)
ROOM = "room?triangles=3000"
WHITTED = vc.Whitted(n_vpls=40)


@dataclass(frozen=True)
class Rays:
    """Every wanted ray."""

    def block(self, eyes, lamps, wanted):
        return eyes.trace(lamps, wanted)


@dataclass(frozen=True)
class AsBits:
    """The same as rows of bits."""

    def block(self, eyes, lamps, wanted):
        seen = np.zeros((len(eyes), -(-len(lamps) // 64) * 64), dtype=bool)
        seen[:, : len(lamps)] = eyes.trace(lamps, wanted)
        return np.packbits(seen, axis=1, bitorder="little").view(np.uint64)

    def pairs(self, eyes, index, ends):
        return np.array([eyes[int(i)].trace(ends[k])[0, 0] for k, i in enumerate(index)])


@dataclass(frozen=True)
class Half:
    """A random half of the rays, which count twice: unbiased."""

    seed: int = 0
    weight: float = 2.0

    def block(self, eyes, lamps, wanted):
        random = np.random.default_rng([self.seed, len(lamps), int(wanted.sum())])
        kept = wanted & (random.random(wanted.shape) < 0.5)
        return eyes.trace(lamps, kept), np.full(wanted.shape, self.weight)


@dataclass(frozen=True)
class Grid:
    """One eye point asks for a whole cell of space."""

    cell: float = 0.25

    def block(self, eyes, lamps, wanted):
        facing = np.argmax(np.abs(eyes.normals), axis=1)
        key = np.column_stack([np.floor(eyes.positions / self.cell), facing])
        _, first, cell = np.unique(key, axis=0, return_index=True, return_inverse=True)
        asked = np.zeros((len(first), len(lamps)), dtype=bool)
        np.logical_or.at(asked, cell.ravel(), wanted)
        return eyes[first].trace(lamps, asked)[cell.ravel()]


@pytest.mark.parametrize("oracle", [Rays(), AsBits()])
@pytest.mark.parametrize(
    ("integrator", "options"),
    [
        (WHITTED, {}),
        (vc.Direct(), {"env": (0.4, 0.5, 0.6), "spp": 2}),
        (vc.AmbientOcclusion(n_samples=4, max_distance=1.0), {}),
        (vc.Bdpt(max_depth=3), {}),
    ],
    ids=["whitted", "direct", "ambient", "bdpt"],
)
def test_traced_rays_make_the_exact_frame(room, integrator, options, oracle):
    size = (8, 5) if isinstance(oracle, AsBits) else SIZE
    exact = vc.render(room, integrator, size=size, **options)
    for threads in (1, 3):
        made = vc.render(room, integrator, size=size, visibility=oracle, threads=threads, **options)
        assert made.sha256 == exact.sha256
        assert made.counters["queries"] == exact.counters["queries"]
        if isinstance(oracle, Rays):
            assert made.counters["rays"] == exact.counters["rays"]


def test_sweeps_go_over_its_fields_and_correct_it(room, tmp_path):
    cells = [0.1, 0.4]

    def swept(name, **use):
        given = {"visibility": Grid(), "size": SIZE, "metrics": ["rel_l1"], **use}
        over = {"visibility.cell": cells}
        return vc.sweep(room, WHITTED, over=over, directory=tmp_path / name, **given)

    plain, exact = swept("a"), swept("b", use=vc.Correct(share=1))
    assert list(plain["cell"].values) == cells
    for name in ("rays", "rel_l1"):
        fine, coarse = plain[name].values
        assert fine > coarse if name == "rays" else 0 < fine < coarse
    assert not exact["rel_l1"].values.any()
    assert (swept("c", use="correct")["rays"].values > plain["rays"].values).all()
    with pytest.raises(ValueError, match="use must be"):
        swept("d", use="repair")


def test_weights_count(room):
    exact = vc.render(room, WHITTED, size=SIZE)

    def halves(**options):
        oracles = [Half(seed=seed, **options) for seed in range(16)]
        return [vc.render(room, WHITTED, size=SIZE, visibility=o) for o in oracles]

    vc.testing.assert_unbiased(halves(), exact, energy=0.05)
    with pytest.raises(AssertionError, match="the frames are biased in their energy"):
        vc.testing.assert_unbiased(halves(weight=1.0), exact)


def test_it_may_be_told_of_frames_and_tiles(room):
    told = []

    class Told:
        def block(self, eyes, lamps, wanted):
            return eyes.trace(lamps, wanted)

        def begin_frame(self, lights):
            told.append(("frame", len(lights)))

        def begin_tile(self, eyes):
            told.append(("tile", len(eyes)))

    frame = vc.render(room, WHITTED, size=(256, 200), visibility=Told(), threads=2)
    assert told[0] == ("frame", len(vc.connections(room, WHITTED, size=SIZE).groups))
    assert [name for name, _ in told[1:]] == ["tile"] * (len(told) - 1)
    assert sum(n for name, n in told if name == "tile") > 0
    assert frame.sha256 == vc.render(room, WHITTED, size=(256, 200)).sha256


def test_state_of_a_tile_is_each_threads_own(room):
    @dataclass
    class Counting:
        seen: int = 0

        def block(self, eyes, lamps, wanted):
            before = self.seen
            self.seen += 1
            answer = eyes.trace(lamps, wanted)
            assert self.seen == before + 1
            return answer

    given = Counting()
    frame = vc.render(room, WHITTED, size=(300, 200), visibility=given, threads=4)
    assert given.seen == 0
    assert frame.sha256 == vc.render(room, WHITTED, size=(300, 200)).sha256


def broken(answer):
    class Broken:
        def block(self, eyes, lamps, wanted):
            return answer(eyes, lamps, wanted)

    return Broken()


@pytest.mark.parametrize(
    ("answer", "match"),
    [
        (lambda e, k, w: w[:-1], "must return bool of shape"),
        (lambda e, k, w: w.astype(float), "must return bool of shape"),
        (lambda e, k, w: None, "must return bool of shape"),
        (lambda e, k, w: (w, np.full(w.shape, np.nan)), "weights must be finite"),
        (lambda e, k, w: (w, np.ones(3)), "weights must have shape"),
        (lambda e, k, w: (w, None, None), "an array or"),
        (lambda e, k, w: e.trace(k, w[:, :1]), "wanted must have shape"),
        (lambda e, k, w: vc.EyePoints(e.positions, e.normals).trace(k), "handed to an oracle"),
    ],
)
def test_nonsense_is_refused_and_loses_nothing(room, answer, match):
    with pytest.raises(ValueError, match=match):
        vc.render(room, WHITTED, size=SIZE, visibility=broken(answer), threads=3)
    assert vc.render(room, WHITTED, size=SIZE, visibility=Rays()).counters["rays"] > 0


def test_an_exception_ends_the_frame_with_its_traceback(room):
    def answer(eyes, lamps, wanted):
        raise KeyError("my own mistake")

    with pytest.raises(KeyError, match="my own mistake") as caught:
        vc.render(room, WHITTED, size=SIZE, visibility=broken(answer), threads=2)
    assert any("test_written" in str(entry.path) for entry in caught.traceback)


@pytest.mark.parametrize("given", [object(), Rays, 5])
def test_what_is_no_oracle_is_refused(room, given):
    with pytest.raises(ValueError, match="visibility must be"):
        vc.render(room, WHITTED, visibility=given, size=SIZE)


def test_a_cancelled_frame_is_interrupted(room):
    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vc.render(room, vc.Whitted(n_vpls=1024), size=(640, 400), visibility=Rays(), progress=stop)


def test_files_of_its_frames_keep_its_fields(room, tmp_path):
    rendered = vc.render(room, WHITTED, size=SIZE, visibility=Grid(cell=0.3))
    rendered.save(tmp_path / "grid.exr")
    assert vc.Frame.load(tmp_path / "grid.exr").parameters == rendered.parameters
