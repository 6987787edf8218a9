"""Samples of lobes beside shared directions of the sky, by the balance heuristic."""

from functools import cache

import numpy as np
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, box, quad
from render.skies import gradient, light
from viscache._core import CoatKind
from viscache.frame.audit_result import QueryErrors

SETS = 8
SIZE = (24, 18)
PLASTIC = Look(kind="glossy", base_color=(0.4, 0.3, 0.2), specular=(0.2, 0.2, 0.2), roughness=0.1)
LOOKS = {
    "plastic": PLASTIC,
    "metal": Look(kind="glossy", base_color=(0, 0, 0), roughness=0.08),
    "rough metal": Look(kind="glossy", base_color=(0, 0, 0), roughness=0.6),
    "rough coat": Look(kind="glossy", roughness=0.05, coat=CoatKind.ROUGH),
    "smooth coat": Look(kind="glossy", roughness=0.02, coat=CoatKind.SMOOTH),
}


@cache
def scene(look):
    """Two boxes on a floor, all of one material."""
    parts = (
        quad((-4, 0, 4), (8, 0, 0), (0, 0, -8), look=look),
        box((-1.2, 0, -0.4), (-0.3, 1.1, 0.5), look=look),
        box((0.3, 0, -0.9), (1.1, 0.6, 0.2), look=look),
    )
    model = Model(parts, origin=(0, 2, 4), target=(0, 0.3, 0), fov_deg=40)
    return model.to_viscache().with_environment(gradient())


def shared(lobes, sets=SETS, n=64, **more):
    """Directions and samples of lobes in sets; as many samples of each eye point's as given."""
    given = {"environment": "shared", "n_environment": n, "n_area": 0} | more
    return vc.Direct(**{"interleave": sets, "n_brdf": lobes * sets} | given)


def frame_of(integrator, visibility=None, look=PLASTIC, **more):
    given = {"size": SIZE, "spp": SETS} | more
    return vc.render(scene(look), integrator, visibility=visibility, **given)


@cache
def truth(look):
    """Own samples, many of them."""
    return light(frame_of(vc.Direct(n_environment=64, n_brdf=64, n_area=0), look=look, spp=64))


def blocks(image):
    """Means of blocks of 6×6 pixels: a wrong weight may move light from one place to another."""
    return image.mean(-1).reshape(3, 6, 4, 6).mean((1, 3)).ravel()


#: Integrators, numbers of seeds, and looks with lobes that they have samples of.
EXPECTED = {
    "sets": (shared(1), 40, LOOKS),
    "all": (shared(3, sets=1, n=16), 48, ["metal", "smooth coat"]),
    "unequal sets": (shared(0, sets=7, n=50, n_brdf=10), 48, ["rough metal", "rough coat"]),
    "picks": (shared(1, n=256, pick=6), 24, ["metal", "rough coat"]),
    "sets without lobes": (shared(0, n_brdf=3), 256, ["plastic", "smooth coat"]),
}


@pytest.mark.parametrize(
    ("name", "look"), [(name, look) for name, (_, _, looks) in EXPECTED.items() for look in looks]
)
def test_means_over_seeds_are_those_of_own_samples(name, look):
    """z-test of the picture and of its parts; the control is 10 % brighter."""
    integrator, seeds, _ = EXPECTED[name]
    frames = [light(frame_of(integrator, look=LOOKS[look], seed=s)) for s in range(seeds)]
    means = np.array([image.mean() for image in frames])
    error = means.std(ddof=1) / np.sqrt(seeds)
    expected = truth(LOOKS[look])
    assert abs(means.mean() - expected.mean()) < 3.5 * error + 0.002 * expected.mean()
    assert abs(1.1 * means.mean() - expected.mean()) > 3.5 * error + 0.002 * expected.mean()
    parts = np.array([blocks(image) for image in frames])
    spread = parts.std(0, ddof=1) / np.sqrt(seeds)
    z = (parts.mean(0) - blocks(expected)) / (spread + 0.01 * blocks(expected))
    assert np.abs(z).max() < 4


def squared_error(n_brdf, look, n=64):
    frames = [light(frame_of(shared(n_brdf, n=n), look=look, seed=s)) for s in range(1, 7)]
    return float(np.mean([np.square(f - truth(look)).mean() for f in frames]))


@pytest.mark.parametrize("look", [LOOKS["metal"], LOOKS["smooth coat"]], ids=["metal", "coat"])
def test_lobes_find_what_shared_directions_miss(look):
    none, one = squared_error(0, look), squared_error(1, look)
    assert one < none / 4
    # It is the lobe that helps, not one ray more: 72 instead of 64 directions
    assert squared_error(0, look, n=72) > none / 4


@pytest.mark.parametrize(
    "look", [Look(base_color=(0.4, 0.3, 0.2)), LOOKS["rough metal"]], ids=["diffuse", "broad lobe"]
)
def test_a_frame_without_sharp_lobes_does_not_change(look):
    without, with_lobes = (frame_of(shared(n), look=look) for n in (0, 4))
    assert with_lobes.sha256 == without.sha256 and with_lobes.counters == without.counters
    assert frame_of(shared(4)).sha256 != frame_of(shared(0)).sha256


def test_each_eye_point_with_a_lobe_asks_for_its_samples():
    asked = [frame_of(shared(n)).counters["groups"]["environment"]["queries"] for n in (0, 1, 4)]
    hits = float(frame_of(shared(0)).layers["coverage"].sum()) * SETS
    assert 0 < asked[1] - asked[0] <= hits
    assert asked[2] - asked[0] == pytest.approx(4 * (asked[1] - asked[0]), rel=0.05)


def test_every_way_to_the_exact_answer_gives_the_same_bytes():
    base = light(frame_of(shared(2), threads=1, size=(90, 70)))
    for visibility in (*(vc.Exact(order=o) for o in ("by_light", "by_pixel")), vc.Aqvc(c_e=1e-3)):
        other = frame_of(shared(2), visibility=visibility, threads=3, size=(90, 70))
        np.testing.assert_array_equal(light(other), base)


def test_the_cache_answers_lobes_and_corrections_undo_its_errors():
    """Means over seeds of corrected frames are those of exact ones, where the cache's are not."""
    common = {"size": (48, 36), "spp": 2}
    coarse = vc.Aqvc(c_e=20, c_finest=20, refinement="off", exact_groups=())

    def means(**given):
        return np.array(
            [light(frame_of(shared(2), **given, seed=s, **common)).mean() for s in range(60)]
        )

    exact, plain = means(), means(visibility=coarse)
    corrected = means(visibility=coarse, use="correct")
    for found, biased in ((plain, True), (corrected, False)):
        difference = found - exact
        z = difference.mean() / (difference.std(ddof=1) / np.sqrt(len(difference)))
        assert (abs(z) > 4) == biased


def test_connections_have_lobes_of_their_own_name():
    conn = vc.connections(scene(PLASTIC), shared(2), size=SIZE, spp=SETS)
    assert set(conn.groups) == {"environment"} and set(conn.samples) == {"lobes"}
    answers = conn.answers(vc.Aqvc(c_e=8))
    made, cached = conn.frame(answers), frame_of(shared(2), vc.Aqvc(c_e=8))
    assert made.sha256 == cached.sha256 and made.counters["rays"] == cached.counters["rays"]
    dark = light(conn.frame({"environment": answers["environment"]}))
    assert (dark <= light(made)).all() and dark.mean() < 0.98 * light(made).mean()


def test_audits_count_lobes():
    """The audited bias of all queries is the difference of the frames."""
    coarse = vc.Aqvc(c_e=30, exact_groups=())
    cached = frame_of(shared(4), coarse, size=(48, 36), audit=vc.AuditQueries(share=1.0))
    exact = frame_of(shared(4), size=(48, 36))
    assert isinstance(cached.audit, QueryErrors)
    found = cached.audit.groups["environment"].bias
    difference = light(cached).mean() / light(exact).mean() - 1
    assert found is not None and found.value == pytest.approx(difference, rel=1e-3)
    assert abs(difference) > 1e-4
