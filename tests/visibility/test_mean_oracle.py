"""Means of voxels as a control variate: `NeePlusPlus` with use="correct"."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import viscache as vc
from reference.built import built
from render.test_determinism import INTEGRATORS, ROOM
from viscache import _core
from viscache.settings.integrators import eye_settings
from visibility.test_roulette_oracle import COARSE, SIZE, SKY, paired, stack

LIGHTS = vc.Whitted(n_vpls=64)


@pytest.fixture(scope="module")
def room() -> vc.Scene:
    return ROOM.to_viscache()


@pytest.fixture(scope="module")
def scene() -> vc.Scene:
    return built("room?triangles=3000")


def corrected(
    scene: vc.Scene, integrator: Any, seeds: range, *, weighted: bool = True, **options: Any
) -> npt.NDArray[Any]:
    """Frames whose corrections have the weight 1/q, or, as a negative control, 1."""
    frame = _core.FrameSettings()
    frame.width, frame.height, frame.spp, frame.threads = *SIZE, 1, 2
    camera = _core.scene_cameras(scene._core)[0]
    paths = isinstance(integrator, vc.Bdpt)
    render: Any = _core.render_bdpt if paths else _core.render_frame
    settings = integrator.core() if paths else eye_settings(integrator)
    caster = scene.caster()
    images = []
    for frame.seed in seeds:
        source = _core.RouletteSource.correct(
            scene._core,
            caster,
            COARSE.core(),
            certain=COARSE.certain,
            seed=frame.seed,
            lasting_seed=frame.seed,
            weighted=weighted,
            **options,
        )
        got = render(scene._core, caster, camera, settings, frame, source)
        images.append(got["layers"]["color"])
    return np.stack(images)


@pytest.mark.stat
def test_slits_of_light_in_voxels_of_shadow_keep_their_light() -> None:
    share = 0.2
    scene = vc.scenes.stairs(12)
    seeds = range(64)
    exact = stack(scene, vc.Direct(), vc.Exact(), seeds)
    ours = corrected(scene, vc.Direct(), seeds, share=share)
    assert (ours - exact).std() > 0.05 * exact.mean()
    result = paired(ours, exact)
    assert result.same, str(result)
    assert not paired(0.98 * ours, exact).same
    spoilt = paired(corrected(scene, vc.Direct(), seeds, share=share, weighted=False), exact)
    assert spoilt.p < 1e-9, str(spoilt)


@pytest.mark.parametrize("integrator", [*INTEGRATORS, SKY], ids=lambda i: type(i).__name__)
def test_a_share_of_one_is_the_exact_frame_byte_for_byte(integrator: Any, room: vc.Scene) -> None:
    exact = vc.render(room, integrator, size=SIZE)
    frame = vc.render(room, integrator, size=SIZE, visibility=COARSE, use=vc.Correct(share=1))
    assert frame.sha256 == exact.sha256
    assert frame.counters["corrections"] == frame.counters["queries"] == exact.counters["queries"]


def test_weights_are_the_mean_or_the_corrected_mean(scene: vc.Scene) -> None:
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


def test_the_contribution_decides_beside_the_mean(scene: vc.Scene) -> None:
    """Rays go where light is: the same rays, spread evenly, leave several times the error."""
    exact = vc.render(scene, LIGHTS, size=SIZE, spp=4)
    options: dict[str, Any] = {"size": SIZE, "visibility": vc.NeePlusPlus(), "spp": 4}
    by_light = vc.render(scene, LIGHTS, use="correct", **options)
    share = by_light.counters["corrections"] / by_light.counters["queries"]
    evenly = vc.render(scene, LIGHTS, use=vc.Correct(share=share), **options)
    errors = [np.square(f.image - exact.image).mean() for f in (by_light, evenly)]
    assert errors[1] > 3 * errors[0] > 0


def test_a_smaller_certain_share_draws_more(scene: vc.Scene) -> None:
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


# Kept from frame to frame


def kept_frames(
    scene: vc.Scene, n: int, keep: vc.VoxelCounts | None, **options: Any
) -> list[vc.Frame]:
    given: dict[str, Any] = {"visibility": COARSE, "size": SIZE} | options
    return [vc.render(scene, LIGHTS, keep=keep, first_sample=i, **given) for i in range(n)]


def test_later_frames_learn_less_and_add_to_the_counts(scene: vc.Scene) -> None:
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


@pytest.fixture(scope="module")
def exact_frames(scene: vc.Scene) -> list[vc.Frame]:
    return kept_frames(scene, 16, None, visibility=vc.Exact())


@pytest.mark.stat
@pytest.mark.parametrize("use", ["replace", "correct"])
def test_frames_that_pass_on_what_they_learnt_are_right_in_expectation(
    use: str, scene: vc.Scene, exact_frames: list[vc.Frame]
) -> None:
    """One percent of the light would show."""
    ours = kept_frames(scene, len(exact_frames), vc.VoxelCounts(), use=use)
    assert vc.testing.assert_unbiased(ours, exact_frames, energy=0.01).paired


def test_what_does_not_fit_is_refused(room: vc.Scene) -> None:
    counts = vc.VoxelCounts()
    vc.render(room, vc.Direct(), size=SIZE, visibility=COARSE, keep=counts)
    for options, match in (
        ({"visibility": vc.NeePlusPlus(n_voxels=8)}, "n_voxels must be 4 as in the counts' frames"),
        ({"visibility": vc.Aqvc()}, "visibility must be vc.NeePlusPlus"),
        ({"visibility": COARSE, "use": "repair"}, "use must be"),
    ):
        with pytest.raises(ValueError, match=match):
            vc.render(room, vc.Direct(), size=SIZE, keep=counts, **options)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="scene must have the geometry"):
        vc.render(vc.scenes.stairs(12), vc.Direct(), visibility=COARSE, keep=counts)
    with pytest.raises(ValueError, match=r"keep must be vc.AqvcTable"):
        vc.render(room, vc.Direct(), visibility=COARSE, keep={})  # type: ignore[arg-type]
    assert counts.frames == 1
    counts.clear()
    assert counts.frames == counts.pairs == counts.bytes == 0
    vc.render(vc.scenes.stairs(12), vc.Direct(), size=SIZE, visibility=COARSE, keep=counts)


def test_damaged_counts_are_refused(scene: vc.Scene) -> None:
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
