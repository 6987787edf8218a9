"""Next Event Estimation++: by roulette, and with its means as a control variate."""

import numpy as np
import pytest

import viscache as vc
from reference.built import built
from render.mitsuba_scene import Model, quad
from render.test_determinism import INTEGRATORS, ROOM
from render.ztest import compare
from viscache import _core
from viscache.settings.integrators import eye_settings
from viscache.shot.shot import frame_settings

SIZE = (64, 48)
#: Coarse, so that voxels see each other in part, and quick to learn.
COARSE = vc.NeePlusPlus(n_voxels=4, n_directions=4, learn_pixels=768, min_probability=0.1)
SKY = vc.Direct(environment="shared", n_environment=32, n_area=2)


@pytest.fixture(scope="module")
def room():
    return ROOM.to_viscache()


def stack(scene, integrator, visibility, seeds):
    given = {"size": SIZE, "visibility": visibility}
    return np.stack([vc.render(scene, integrator, seed=s, **given).image for s in seeds])


def paired(frames, exact):
    """Against the exact frames of the same seeds, by 8 × 8 blocks: they differ by roulette alone.

    A pixel's answers are too rare to be normal.
    """
    blocks = [
        np.asarray(i, np.float64).reshape(len(i), -1, 8, i.shape[2] // 8, 8, 3).mean(axis=(2, 4))
        for i in (frames, exact)
    ]
    mean = blocks[1].mean(axis=0)
    return compare(blocks[0] - blocks[1] + mean, np.repeat(mean[None], 4, axis=0), edge=2)


@pytest.mark.stat
@pytest.mark.parametrize("way", ["roulette", "means"])
def test_slits_of_light_in_voxels_of_shadow_keep_their_light(way):
    """They are traced one time in ten, or one in five."""
    scene, seeds = vc.scenes.stairs(12), range(96 if way == "roulette" else 64)
    exact = stack(scene, vc.Direct(), vc.Exact(), seeds)
    if way == "roulette":
        ours = stack(scene, vc.Direct(), COARSE, seeds)
    else:
        ours = corrected(scene, vc.Direct(), seeds, share=0.2)
        spoilt = corrected(scene, vc.Direct(), seeds, share=0.2, weighted=False)
        assert paired(spoilt, exact).p < 1e-9
    assert (ours - exact).std() > 0.05 * exact.mean()
    result = paired(ours, exact)
    assert result.same, str(result)
    assert not paired(0.98 * ours, exact).same


@pytest.mark.parametrize("integrator", [*INTEGRATORS, SKY], ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("never", [{"min_probability": 1.0}, {"exponent": 0.0}])
def test_where_nothing_is_left_out_the_frame_is_the_exact_one(integrator, never, room):
    exact = vc.render(room, integrator, size=SIZE)
    frame = vc.render(room, integrator, size=SIZE, visibility=vc.NeePlusPlus(**never))
    assert frame.sha256 == exact.sha256
    assert frame.counters["discarded"] == 0
    assert frame.counters["rays"] - frame.counters["learning_rays"] == exact.counters["rays"]
    groups = exact.counters["groups"]
    assert [g["queries"] for g in frame.counters["groups"].values()] == [
        g["queries"] for g in groups.values()
    ]


def walled():
    """A floor, and a lamp behind a wall that hides it from half of the floor."""
    parts = (quad((-4, 0, -4), (0, 0, 8), (8, 0, 0)), quad((0, 0, -4), (0, 0, 8), (0, 4, 0)))
    return Model(parts, points=(((2.0, 2.0, 0.1), (9, 9, 9)),)).to_viscache()


def test_connections_between_voxels_that_never_see_each_other_are_hardly_traced():
    scene = walled()
    camera = vc.look_at((0.0, 12.0, 0.01), (0, 0, 0), fov_deg=40)
    view = {"size": (160, 100), "camera": camera}
    exact = vc.render(scene, vc.Direct(), **view)
    frame = vc.render(scene, vc.Direct(), visibility=vc.NeePlusPlus(), **view)
    queries, occluded = exact.counters["queries"], exact.counters["occluded"]
    assert 0.3 * queries < occluded
    assert frame.counters["discarded"] > 0.5 * occluded
    # What is seen is seen from voxels that see: its noise is confined to those the shadow cuts
    assert vc.metrics.rel_l1(frame.image, exact.image) < 0.05


def test_more_voxels_leave_less_noise_and_smaller_exponents_too(room):
    exact = vc.render(room, vc.Direct(n_area=0), size=(64, 48))

    def error(**given):
        settings = vc.NeePlusPlus(learn_pixels=1 << 12, **given)
        frame = vc.render(room, vc.Direct(n_area=0), size=(64, 48), visibility=settings)
        return vc.metrics.rel_l1(frame.image, exact.image)

    errors = [error(n_voxels=n) for n in (2, 6, 16)]
    assert errors[0] > 1.2 * errors[1] > 1.2 * 1.2 * errors[2] > 0
    assert error(n_voxels=2, exponent=0.25) < 0.7 * errors[0]


LIGHTS = vc.Whitted(n_vpls=64)


@pytest.fixture(scope="module")
def scene():
    return built("room?triangles=3000")


def corrected(scene, integrator, seeds, *, weighted=True, **options):
    """Frames whose corrections have the weight 1/q, or, as a negative control, 1."""
    caster, images = scene.caster(), []
    for seed in seeds:
        source = _core.RouletteSource.correct(
            scene._core,
            caster,
            COARSE.core(),
            certain=COARSE.certain,
            seed=seed,
            lasting_seed=seed,
            weighted=weighted,
            **options,
        )
        frame = frame_settings(SIZE, 1, seed, 2)
        settings, camera = eye_settings(integrator), scene.cameras[0]
        got = _core.render_frame(scene._core, caster, camera, settings, frame, source)
        images.append(got["layers"]["color"])
    return np.stack(images)


@pytest.mark.parametrize("integrator", [*INTEGRATORS, SKY], ids=lambda i: type(i).__name__)
def test_a_share_of_one_is_the_exact_frame_byte_for_byte(integrator, room):
    exact = vc.render(room, integrator, size=SIZE)
    frame = vc.render(room, integrator, size=SIZE, visibility=COARSE, use=vc.Correct(share=1))
    assert frame.sha256 == exact.sha256
    assert frame.counters["corrections"] == frame.counters["queries"] == exact.counters["queries"]


def test_weights_are_the_mean_or_the_corrected_mean(scene):
    """μ where nothing was traced; of a traced query, q follows from its weight and the truth."""
    conn = vc.connections(scene, LIGHTS, size=SIZE)
    settings, exact = vc.NeePlusPlus(n_voxels=6), conn.answers(vc.Exact())["vpl"]
    answer = conn.answers(settings, use="correct")["vpl"]
    even = conn.answers(settings, use=vc.Correct(share=2.0**-20))["vpl"]  # hardly any is traced
    wanted = np.unpackbits(conn.wanted("vpl").view(np.uint8), axis=1, bitorder="little")
    wanted = wanted[:, : exact.n_ends].astype(bool)  # type: ignore[union-attr]
    truth, weight, mean = (
        a[wanted]
        for a in (exact.visible, answer.weights, even.weights)  # type: ignore[union-attr]
    )
    known = (mean > 0) & (mean < 1)
    assert known.mean() > 0.999
    truth, weight, mean = truth[known], weight[known], mean[known]
    traced = weight != mean
    q = (truth - mean)[traced] / (weight - mean)[traced]
    halvings = -np.log2(q)
    np.testing.assert_allclose(halvings, np.round(halvings), atol=2e-3)
    assert (np.round(halvings).min(), np.round(halvings).max()) == (0, 5)
    # Uncertain pairs of voxels are traced more
    certain = mean * (1 - mean) < 0.01
    assert traced[~certain].mean() > 1.5 * traced[certain].mean()
    # The mean is that of the truth where it says so
    for low, high in ((0.1, 0.4), (0.4, 0.6), (0.6, 0.9)):
        there = (mean > low) & (mean < high)
        assert abs(truth[there].mean() - mean[there].mean()) < 0.1


def test_the_contribution_decides_beside_the_mean(scene):
    """Rays go where light is: the same rays, spread evenly, leave several times the error."""
    exact = vc.render(scene, LIGHTS, size=SIZE, spp=4)
    options = {"size": SIZE, "visibility": vc.NeePlusPlus(), "spp": 4}
    by_light = vc.render(scene, LIGHTS, use="correct", **options)
    share = by_light.counters["corrections"] / by_light.counters["queries"]
    evenly = vc.render(scene, LIGHTS, use=vc.Correct(share=share), **options)
    errors = [np.square(f.image - exact.image).mean() for f in (by_light, evenly)]
    assert errors[1] > 3 * errors[0] > 0


def test_a_smaller_certain_share_draws_more(scene):
    drawn = [
        vc.render(scene, LIGHTS, size=SIZE, visibility=vc.NeePlusPlus(certain=c), use=use)
        for c, use in (
            (1 / 4, "correct"),
            (1 / 32, "correct"),
            (1 / 32, vc.Correct(certain=1 / 4)),
        )
    ]
    rays = [frame.counters["corrections"] for frame in drawn]
    assert rays[1] > 1.5 * rays[0]
    assert rays[2] == rays[0]


def kept_frames(scene, n, keep, **options):
    given = {"visibility": COARSE, "size": SIZE} | options
    return [vc.render(scene, LIGHTS, keep=keep, first_sample=i, **given) for i in range(n)]


def test_later_frames_learn_less_and_add_to_the_counts(scene):
    counts = vc.VoxelCounts()
    tests = []
    for i in range(3):
        vc.render(scene, LIGHTS, size=SIZE, visibility=COARSE, keep=counts, first_sample=i)
        tests.append(int(counts._state()["tested"].sum()))
    assert tests[0] < tests[1] < tests[2] < 2 * tests[0]
    assert counts.frames == 3
    fixed = vc.NeePlusPlus(relearn_pixels=0, n_voxels=4)
    frames = kept_frames(scene, 2, vc.VoxelCounts(), visibility=fixed)
    assert frames[1].counters["learning_rays"] == 0 < frames[0].counters["learning_rays"]


def test_what_does_not_fit_is_refused(room):
    counts = vc.VoxelCounts()
    given = {"size": SIZE, "visibility": COARSE, "keep": counts}
    vc.render(room, vc.Direct(), **given)
    for scene, options, match in (
        (room, {"visibility": vc.NeePlusPlus(n_voxels=8)}, "n_voxels must be 4 as in the counts'"),
        (room, {"use": "repair"}, "use must be"),
        (room, {"keep": {}}, r"keep must be vc.AqvcTable"),
        (vc.scenes.stairs(12), {}, "scene must have the geometry"),
    ):
        with pytest.raises(ValueError, match=match):
            vc.render(scene, vc.Direct(), **given | options)
    assert counts.frames == 1
    counts.clear()
    assert counts.frames == counts.pairs == counts.bytes == 0
    vc.render(vc.scenes.stairs(12), vc.Direct(), **given)


def test_damaged_counts_are_refused(scene):
    counts = vc.VoxelCounts()
    kept_frames(scene, 1, counts)
    state = counts._state()
    other = vc.VoxelCounts()
    other._restore(scene, COARSE, state)
    assert (other.pairs, other.frames) == (counts.pairs, 1)
    for name, values in (
        ("seen", state["tested"] + 1),
        ("place", state["place"] + 10**9),
        ("place", np.zeros_like(state["place"])),
        ("tested", state["tested"][:-1]),
    ):
        with pytest.raises(ValueError, match="must"):
            vc.VoxelCounts()._restore(scene, COARSE, state | {name: values})
