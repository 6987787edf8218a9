"""render/light_pick.h: eye points pick some of the shared lights, and the mean stays the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import viscache as vc
from core import testing
from render.mitsuba_scene import Look, Model, ball, box
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot

OFFSETS = (np.arange(4096) + 0.5) / 4096


def weights(contributions, most, u=OFFSETS):
    """Weights (offsets, lights)."""
    c = np.asarray(contributions, np.float32)
    return np.asarray(testing.pick_columns(c, most, np.atleast_1d(u)), np.float64)


MANY = st.lists(st.floats(0, 1e4, width=32, allow_subnormal=False), min_size=1, max_size=150)


@given(contributions=MANY, most=st.integers(1, 40))
def test_the_mean_over_all_offsets_is_every_light_once(contributions, most):
    c = np.asarray(contributions, np.float64)
    w = weights(c, most)
    assert ((w > 0).sum(axis=1) <= most).all() or (w == 1).all()
    # A light covers an interval of offsets: their number is off by 2 at most
    inverse = np.where(c > 0, w.max(axis=0), 1)
    error = np.abs(w.mean(axis=0) - 1)[(c > 0) & (w.max(axis=0) > 0)]
    assert (error <= 2.01 / len(OFFSETS) * inverse[(c > 0) & (w.max(axis=0) > 0)]).all()
    # Only what is almost never picked is not picked at all
    never = (c > 0) & (w.max(axis=0) == 0)
    assert (c[never] * most <= 1.01 / len(OFFSETS) * c.sum()).all()


@given(contributions=MANY, most=st.integers(1, 40), u=st.floats(0, 1, exclude_max=True))
def test_the_weights_are_inverse_probabilities(contributions, most, u):
    c = np.asarray(contributions, np.float64)
    (w,) = weights(c, most, u)
    if (c > 0).sum() <= most:
        assert (w == 1).all()
        return
    distance = c.sum() / most
    assert (w[c > distance * (1 + 1e-9)] == 1).all()
    assert (w[c == 0] == 0).all()
    chosen = w > 0
    ratios = np.clip(distance / c[chosen], 1, np.finfo(np.float32).max)
    np.testing.assert_allclose(w[chosen], ratios, rtol=1e-6)
    if (c < distance * (1 - 1e-9)).all() and 1e-9 < u < 1 - 1e-9:
        assert chosen.sum() == most
        np.testing.assert_allclose((w * c).sum(), c.sum(), rtol=1e-5)


def test_weights_without_the_certain_ones_are_wrong():
    """The sum over one light that is longer than the distance, and ten short ones."""
    c = np.array([5.0] + [0.1] * 10)
    w = weights(c, 4)
    assert (w @ c).mean() == pytest.approx(c.sum(), rel=1e-3)
    alike = np.where(w > 0, c.sum() / 4 / c, 0)
    assert (alike @ c).mean() < 0.5 * c.sum()


def test_sums_that_are_not_finite_pick_nothing():
    for bad in (np.inf, np.nan):
        assert (weights([bad, 1, 1, 1], 2) == 1).all()
    assert (weights([3e38] * 8, 2).sum(axis=1) == 8).all()  # the sum is above the range of float


GREY = Look(base_color=(0.6, 0.5, 0.4))
SHINY = Look(kind="glossy", base_color=(0.2, 0.3, 0.2), specular=(0.4, 0.4, 0.4), roughness=0.3)
MIRROR = Look(kind="mirror", specular=(0.9, 0.9, 0.9))


def lamps(count):
    """Point lights, spots and suns of many powers over a floor, a block and a mirror."""
    random = np.random.default_rng(count)
    places = random.uniform((-2, 0.4, -2), (2, 2.6, 2), (2 * count, 3))
    power = 0.3 * 30 ** random.random((3 * count, 1)) * random.uniform(0.2, 1, (3 * count, 3))
    suns = random.normal((0, 2, 0), 1, (count, 3))
    suns /= np.linalg.norm(suns, axis=1, keepdims=True)

    def rows(*columns):
        return [tuple(tuple(map(float, a)) for a in row) for row in zip(*columns, strict=False)]

    spots = rows(places[count:], 5 * power[count:])
    return Model(
        (
            box((-2.5, 0, -2.5), (2.5, 3, 2.5), look=GREY).reversed(),
            box((-0.9, 0, -0.5), (-0.3, 0.9, 0.2), look=SHINY),
            ball((0.6, 0.5, 0.2), 0.5, look=MIRROR),
            box((0.3, 0, -1.6), (1.4, 1.2, -1.2), look=SHINY),
        ),
        points=rows(places[:count], power),
        spots=tuple((*spot, (0.1, -1.0, 0.1), (20.0, 60.0)) for spot in spots),
        directions=rows(suns, 0.02 * power),
        env=(0.2, 0.3, 0.4),
        origin=(0, 1.4, 2.2),
    )


@pytest.fixture(scope="module")
def scene():
    return lamps(14).to_viscache()


DIRECT = {"n_area": 0, "environment": "shared", "n_environment": 24}


def direct(pick):
    return vc.Direct(pick=pick, **DIRECT)


def whitted(pick):
    return vc.Whitted(pick=pick, n_vpls=64, **DIRECT)


@pytest.mark.parametrize("make", [direct, whitted])
def test_as_many_picks_as_lights_give_the_same_bytes(make, scene):
    frames = [vc.render(scene, make(n), size=(48, 32), spp=2) for n in (0, 64, 1000)]
    assert len({f.sha256 for f in frames}) == 1
    assert frames[1].counters["groups"] == frames[0].counters["groups"]
    fewer = vc.render(scene, make(5), size=(48, 32), spp=2)
    assert fewer.sha256 != frames[0].sha256
    # Mirrors have several eye points per sample
    points = len(vc.connections(scene, make(5), size=(48, 32), spp=2).eyes)
    for name, group in fewer.counters["groups"].items():
        assert 0 < group["queries"] <= 5 * points, name
        assert group["queries"] < frames[0].counters["groups"][name]["queries"]


def test_any_number_of_parts_gives_the_same_bytes(scene):
    options = {"size": (70, 66), "spp": 4, "seed": 3}
    whole = vc.render(scene, whitted(4), **options).image
    parts = [render_part(BareShot(scene, whitted(4), **options), (i, 3)).image for i in range(3)]
    np.testing.assert_array_equal(np.sum(parts, axis=0), whole)
