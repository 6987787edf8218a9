"""Calls that measure: correlation, metrics, frames as files, sweeps."""

import math
from pathlib import Path

import numpy as np

import viscache as vc
from fuzz import scenes, settings
from fuzz.outcome import WrongError
from fuzz.values import Dice

THREADS = 1


def measured(dice: Dice) -> None:
    """`correlation.measure` and what is derived from it."""
    edges = dice.pick(1, 2, 8, [0, 1], [0, 0.5, 1])
    if dice.is_wild():
        edges = dice.pick(0, [0, math.nan], [1, 1], [], dice.array((5,)))
    given = {"d_edges": edges, "theta_edges_deg": dice.pick(1, 9, [0, 180])}
    choices = {
        "pairs": lambda: dice.pick("all", 100, dice.whole(1, 1000)),
        "d_max": dice.number,
        "t_max": dice.number,
        "slice_d": dice.number,
        "slice_theta_deg": lambda: dice.real(0.1, 90),
        "min_bits": lambda: dice.whole(1, 100),
        "directions": lambda: dice.pick("centres", "jittered", "lloyd", "x"),
        "domain": lambda: dice.pick("sphere", "joint", "union"),
        "engine": lambda: dice.pick("embree", "batch", "auto"),
        "points": lambda: dice.pick("camera", "area"),
    }
    for name in dice.random.sample(list(choices), 2):
        given[name] = choices[name]()
    found = vc.correlation.measure(
        scenes.scene(dice),
        n_points=dice.whole(16, 100),
        map_size=dice.whole(1, 16),
        threads=THREADS,
        **given,
    )
    mean = np.nan_to_num(found["mean"].values)
    if (np.abs(mean) > 1.0001).any():
        raise WrongError("a correlation lies outside [-1, 1]")
    vc.correlation.correlation_lengths(found)
    vc.correlation.predicted_variance_ratio(found, np.abs(dice.numpy().random(3)))


def rows(dice: Dice) -> None:
    """`correlate` and `phi` of any bits."""
    n, words = dice.pick(2, 16, 50), dice.pick(1, 2, 5)
    bits = dice.numpy().integers(0, 2**63, (n, words)).astype(np.uint64)
    given = dice.array((n, words)) if dice.is_wild() else bits
    count = dice.pick(None, 1, 64 * words, 64 * words - 3, dice.whole(1, 64))
    phi = np.nan_to_num(vc.correlation.phi(given, bits, count))
    if (np.abs(phi) > 1.0001).any():
        raise WrongError("a correlation lies outside [-1, 1]")
    vc.correlation.correlate(
        given,
        dice.array((n, 3)),
        dice.array((n, 3), unit=True),
        n_directions=count,
        d_edges=4,
        theta_edges_deg=4,
    )


def picture(dice: Dice):
    """An image of any values."""
    height, width = dice.pick((1, 1), (4, 5), (16, 16), (12, 30))
    image = dice.numpy().random((height, width, 3), dtype=np.float32)
    if dice.chance(0.3):
        image *= np.float32(dice.pick(0, 1e-45, 1e-38, 1e-30, 1e-7, 1e6, 1e30))
    if dice.is_wild():
        image[dice.numpy().random(image.shape) < 0.1] = dice.pick(np.nan, np.inf, -1, -1e30)
    return dice.pick(image[..., 0], image[..., :2], None, "x") if dice.is_wild() else image


def metrics(dice: Dice) -> None:
    """`metrics.compare` of two pictures."""
    a = picture(dice)
    b = picture(dice) if dice.chance(0.3) else np.roll(a, 1) if isinstance(a, np.ndarray) else a
    names = dice.pick(["rel_l1", "rmse", "energy", "rel_mse", "max_abs"], ["flip"], ["ssim"], None)
    found = vc.metrics.compare(a, b, metrics=["nothing"] if dice.is_wild() else names)
    for name, value in found.items():
        if value is not None and not np.isfinite(value):
            raise WrongError(f"{name} is {value}")
    repr(found)


def frames(dice: Dice) -> None:
    """A frame comes back from its file as it was."""
    layers = {"color": picture(dice), dice.pick("depth", "a.b", "normal", "é", "R"): picture(dice)}
    frame = vc.Frame(
        layers=layers, counters={"a": dice.number()}, timings={}, parameters={}, provenance={}
    )
    frame.save("frame.exr")
    again = vc.Frame.load("frame.exr")
    for name, layer in frame.layers.items():
        if name not in again.layers or not np.array_equal(
            layer, again.layers[name], equal_nan=True
        ):
            raise WrongError(f"layer {name!r} did not come back")
    frame.summary(), frame.sha256
    Path("frame.exr").unlink()


def sweeps(dice: Dice) -> None:
    """`sweep` over any parameter, and its front."""
    name = dice.pick("c_e", "c_e", "visibility.c_n", "integrator.n_area", "rays.robust", "nothing")
    values = dice.pick([4], [4, 8], {"log": [2, 32], "n": 3})
    if dice.is_wild():
        values = dice.pick([], [0], ["x"], [math.nan], [None], {"log": [0, 32], "n": 3}, 4, {})
    where = (
        dice.pick("nothing", "cube_on_plane?size=nan", "") if dice.is_wild() else "cube_on_plane"
    )
    found = vc.sweep(
        where,
        vc.Direct(n_area=1, n_environment=1, n_brdf=1),
        over={name: values},
        repeats=dice.pick(1, 2) if not dice.is_wild() else dice.number(),
        size=(8, 8),
        metrics=["rel_l1"],
        seed=dice.whole(0, 9),
        threads=THREADS,
    )
    vc.pareto(found)


def drawn(dice: Dice) -> None:
    """Designs of any ranges."""
    ends = [dice.number(), dice.number()]
    over = {"c_e": dice.pick({"log": ends}, {"linear": ends, "whole": True}, [1, 2], {"log": [1]})}
    kind = dice.pick("random", "latin_hypercube", "x")
    for point in vc.designs.draw({"kind": kind, "n": dice.whole(1, 50), "seed": 3}, over):
        if not all(np.isfinite(v) for v in point.values() if isinstance(v, float)):
            raise WrongError(f"a value of {over} is not finite")


def skies(dice: Dice) -> None:
    """Clear skies of any sun and air."""
    sky = settings.made(dice, vc.Sky)
    if not np.isfinite(sky.radiance(np.eye(3, dtype=np.float32))).all():
        raise WrongError("the sky is not finite")


def pictures_over_time(dice: Dice) -> None:
    """Variance, flicker and the tests of frames."""
    shape = dice.pick((4, 5, 3), (16, 16, 3))
    images = [dice.numpy().random(shape, dtype=np.float32) for _ in range(dice.pick(2, 5))]
    if dice.is_wild():
        images[0] = picture(dice)
    vc.variance.variance_ratio(images, images[::-1])
    vc.testing.assert_close(images, images, rel_l1=dice.real(0.01, 1))


CALLS = {
    "correlation": ((measured, 3), (rows, 1)),
    "pictures": (
        *((metrics, 3), (frames, 2), (skies, 1), (pictures_over_time, 1)),
        *((sweeps, 1), (drawn, 1)),
    ),
}
