"""The environment by product sampling and with visibility maps: the same light, with less noise."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from core import testing
from render.mitsuba_scene import Look, Model, ball
from render.ztest import compare
from viscache import _core
from viscache.settings.integrators import eye_settings
from viscache.shot.shot import frame_settings
from vismap.worlds import dilations

SIZE = (20, 12)


@pytest.fixture(scope="module")
def scene():
    return vc.scenes.cube_on_plane().with_environment(sky())


def sky():
    """A sun of a few texels in a dim sky, as a lat-long image."""
    image = np.full((32, 64, 3), [0.2, 0.3, 0.5], np.float32)
    image[16:] = 0.05
    image[7:9, 20:22] = [60, 50, 40]
    return image


def direct(**given):
    return vc.Direct(**{"n_environment": 8, "environment": "product", "n_area": 2} | given)


def shown(scene, integrator=None, maps=None, **more):
    given = {"size": SIZE} | more
    return vc.render(scene, integrator or direct(), visibility=maps, **given)


def images(n, scene, integrator=None, maps=None, *, seed=0):
    frames = (shown(scene, integrator, maps, seed=seed + i) for i in range(n))
    return np.stack([f.layers["environment"] for f in frames]).astype(np.float64)


@pytest.fixture(scope="module")
def usual(scene):
    """By product sampling without maps."""
    return images(40, scene, seed=500)


MAPS = [
    pytest.param({"alpha": "one", "sampling": "product"}, marks=pytest.mark.release),
    {"alpha": 0.4, "sampling": "guided"},
    pytest.param({"alpha": "previous_pass", "sampling": "product"}, marks=pytest.mark.release),
    pytest.param({"alpha": "previous_pass", "sampling": "guided"}, marks=pytest.mark.release),
    {"alpha": "previous_pass", "sampling": "auto"},
]


@pytest.mark.stat
def test_product_sampling_brings_the_light_of_multiple_importance_sampling(scene):
    usual = images(48, scene, vc.Direct(n_environment=16, n_brdf=16), seed=500)
    for points in ("even", "independent"):
        ours = images(48, scene, direct(points=points))
        result = compare(ours, usual)
        assert result.same, str(result)
        assert not compare(ours * 1.03, usual).same, "three hundredths more light must show"


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.parametrize("maps", MAPS, ids=lambda m: f"{m['alpha']}-{m['sampling']}")
def test_maps_do_not_change_the_mean(scene, usual, maps):
    ours = images(40, scene, direct(passes=2), vc.VisMaps(n_startup=60, **maps))
    result = compare(ours, usual)
    assert result.same, str(result)
    assert not compare(ours * 1.03, usual).same


@pytest.mark.stat
@pytest.mark.parametrize("kind", ["random", "full", "empty"])
def test_whatever_the_maps_hold_the_mean_stays(scene, usual, kind):
    maps = {
        "random": np.random.default_rng(3).random((3, 32, 32)) < 0.3,
        "full": np.ones((3, 32, 32), bool),
        "empty": np.zeros((3, 32, 32), bool),
    }[kind]
    ours = np.stack([given_maps(scene, maps, seed) for seed in range(40)]).astype(np.float64)
    result = compare(ours, usual)
    assert result.same, str(result)


def given_maps(scene, maps, seed):
    caster, estimate = scene.caster(), vc.VisMaps(sampling="guided").estimate()
    given = testing.given_maps(estimate, maps, np.full(3, 1 / 3, np.float32), dilations(maps))
    settings = eye_settings(direct(passes=2)), frame_settings(SIZE, 1, seed, 1)
    exact = _core.ExactSource(scene._core, caster)
    made = _core.render_frame(scene._core, caster, scene.cameras[0], *settings, exact, maps=given)
    return made["layers"]["environment"]


def test_an_empty_cache_reports_its_own_settings(scene):
    cache = vc.VisibilityMapCache(scene, vc.MapSettings(m=4, n_best=2))
    said = vc.VisMaps(cache=cache, m=6).parameters()
    assert len(cache) == 0 and (said["cache"], said["m"], said["n_best"]) == (True, 4, 2)


def test_without_records_or_with_alpha_zero_it_is_product_sampling(scene):
    plain, empty = shown(scene).image, vc.VisibilityMapCache(scene)
    zero = vc.VisMaps(n_startup=60, alpha="zero", sampling="product")
    for maps in (vc.VisMaps(cache=empty, update=False), zero):
        np.testing.assert_array_equal(shown(scene, maps=maps).image, plain)
    assert len(empty) == 0
    one = vc.VisMaps(n_startup=60, alpha="one", sampling="product")
    floor = replace(one, sampling="guided", eta=1.0)
    a, b = (shown(scene, maps=v).image for v in (one, floor))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, plain)


@pytest.mark.parametrize("first", ["pilot", "one"])
def test_the_first_pass_takes_the_trials_alpha_or_the_papers(scene, first):
    given = {"n_startup": 60, "sampling": "product"}
    frame = shown(scene, maps=vc.VisMaps(first_alpha=first, **given))
    pilot = frame.counters["pilot_alpha"] if first == "pilot" else None
    for alpha, same in ((pilot or "one", True), (0.3, False)):
        other = shown(scene, maps=vc.VisMaps(alpha=alpha, **given))
        assert np.array_equal(frame.image, other.image) == same


def test_other_lights_are_traced_as_ever(scene):
    plain = shown(scene, vc.Direct())
    for use in ("correct", "replace"):
        frame = shown(scene, direct(n_area=16), vc.VisMaps(n_startup=60), use=use)
        np.testing.assert_array_equal(frame.layers["point"], plain.layers["point"])
        assert frame.counters["groups"]["point"] == plain.counters["groups"]["point"]


def test_a_frame_leaves_a_cache_as_it_is_unless_it_is_asked_to_change_it(scene):
    cache = vc.VisibilityMapCache(scene, vc.MapSettings(n_startup=60))
    cache.update(size=(16, 12))

    def state():
        return [np.asarray(v).tobytes() for v in dataclasses.asdict(cache.records()).values()]

    before, rays, records = state(), cache.rays, len(cache)
    kept = shown(scene, maps=vc.VisMaps(cache=cache))
    assert state() == before and cache.rays == rays and kept.counters["records_inserted"] == 0
    assert kept.parameters["visibility"]["update"] is False
    grown = shown(scene, maps=vc.VisMaps(cache=cache, update=True))
    assert len(cache) == records + grown.counters["records_inserted"] > records
    shown(scene, maps=vc.VisMaps(cache=cache, count_misses=True))
    assert cache.records().rays.any()
    fresh = shown(scene, maps=vc.VisMaps(n_startup=60))
    assert fresh.counters["records_inserted"] > 0 and fresh.parameters["visibility"]["update"]


def test_replacing_traces_no_ray_and_comes_near(scene):
    cache, size = vc.VisibilityMapCache(scene, vc.MapSettings(preset="high", m=6)), (48, 32)
    given = {"maps": vc.VisMaps(cache=cache, update=True), "size": size}
    frame = shown(scene, use="replace", **given)
    assert frame.counters["groups"]["environment"]["rays"] == 0
    assert frame.counters["records"] == len(cache) > 100
    before = cache.rays
    again = shown(scene, use="replace", seed=9, **given)
    assert again.counters["records_inserted"] == 0
    # Another light, no ray: the records know nothing of it
    turned = {"env": np.roll(sky(), 16, axis=1)}
    other = shown(scene, use="replace", **given, **turned)
    assert cache.rays == before
    light = []
    for made, env in ((frame, {}), (other, turned)):
        truth = shown(scene, direct(n_environment=512), size=size, spp=4, **env)
        a, b = (f.layers["environment"] for f in (made, truth))
        assert abs(a - b).sum() / b.sum() < 0.15
        light.append(a)
    assert abs(light[1] - light[0]).sum() / light[0].sum() > 0.03


def test_the_counters_tell_what_was_done(scene):
    frame = shown(scene, direct(passes=3), vc.VisMaps(n_startup=60, sampling="guided"))
    c, t = frame.counters, frame.timings
    parts = ("product_guided", "product_without_record", "product_dark")
    assert c["product_points"] == sum(c[name] for name in parts)
    queries = c["groups"]["environment"]["queries"]
    assert 0 < queries - c["pilot_rays"] <= 3 * 8 * c["product_points"]
    assert c["records"] == c["records_inserted"] > 0 and c["records_rays"] > 0
    assert 0 <= c["pilot_alpha"] <= 1.5 and c["greatest_ratio"] >= 1
    for name in ("trees_cpu_s", "maps_cpu_s", "samples_cpu_s", "records_s", "pilot_s"):
        assert t[name] > 0
    assert "environment_last_pass" in frame.layers
    parts = ("trees_cpu_s", "maps_cpu_s", "samples_cpu_s")
    assert sum(t[p] for p in parts) <= t["contributions_cpu_s"] * (1 + 1e-6)


def test_the_records_learn_how_often_they_were_wrong(scene):
    """One record a point: one comparison a ray, for any number of threads."""
    counted, at = [], {"size": (40, 24)}
    for threads in (1, 3):
        cache = vc.VisibilityMapCache(scene, vc.MapSettings(n_best=1))
        cache.update(**at)
        maps = vc.VisMaps(cache=cache, update=False, count_misses=True, sampling="product")
        given = direct(passes=2, centred=True)
        c = shown(scene, given, maps, threads=threads, **at).counters
        records = cache.records()
        rays = c["groups"]["environment"]["rays"] - c["pilot_rays"]
        assert c["product_without_record"] == 0 and records.rays.sum() == rays > 0
        assert 0 < records.misses.sum() < 0.2 * rays
        counted.append((records.rays, records.misses))
    np.testing.assert_array_equal(counted[0], counted[1])
    shown(scene, maps=vc.VisMaps(cache=cache, update=False), **at)
    assert cache.records().rays.sum() == counted[1][0].sum()


def test_guided_rays_count_as_those_of_product_sampling_would():
    """Counted one for one, the window's border would make records wrong twenty times as often."""
    room = vc.scenes.window_room()
    given, at = direct(n_environment=64, centred=True), {"size": (32, 24)}
    cache = vc.VisibilityMapCache(room, vc.MapSettings(n_best=1))
    cache.update(**at)
    shares, counted = {}, []
    for sampling, threads in (("product", 1), ("guided", 1), ("guided", 3)):
        maps = vc.VisMaps(cache=cache, update=False, count_misses=True, sampling=sampling)
        cache.reset_errors()
        c = shown(room, given, maps, threads=threads, **at).counters
        records = cache.records()
        rays = c["groups"]["environment"]["rays"] - c["pilot_rays"]
        rel = 1e-12 if sampling == "product" else 0.03
        assert records.rays.sum() == pytest.approx(rays, rel=rel)
        assert (records.misses <= records.rays).all()
        shares[sampling] = records.misses.sum() / records.rays.sum()
        counted.append((records.rays, records.misses))
    np.testing.assert_array_equal(counted[1], counted[2])
    assert 0 < shares["product"] < 0.006
    assert shares["guided"] == pytest.approx(shares["product"], rel=0.25)


@pytest.mark.stat
@pytest.mark.parametrize("sampling", ["product", "guided"])
def test_in_a_furnace_a_convex_body_of_albedo_one_is_as_bright_as_the_sky(sampling):
    globe = ball((0, 0, 0), 1, look=Look(base_color=(1, 1, 1)))
    furnace = Model((globe,), env=(1, 1, 1), target=(0, 0, 0)).to_viscache()
    cache = vc.VisibilityMapCache(furnace, vc.MapSettings(n_startup=200))
    cache.update(size=SIZE)
    maps = vc.VisMaps(cache=cache, update=False, sampling=sampling)
    given = direct(passes=2, centred=True)
    inside = shown(furnace, given).layers["coverage"][..., 0] == 1
    assert inside.sum() > 20
    means = images(40, furnace, given, maps).mean(axis=-1)[:, inside]
    error = means.std(axis=0, ddof=1) / np.sqrt(len(means)) + 1e-6
    assert np.abs((means.mean(axis=0) - 1) / error).max() < 5
    image = means.mean(axis=1)
    sigma = image.std(ddof=1) / np.sqrt(len(image))
    assert abs(image.mean() - 1) < 3.5 * sigma + 1e-6
    assert 5 * sigma < 0.01, "a hundredth less light would show"


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.parametrize("guided", [True, False], ids=["room", "garden"])
def test_the_switch_guides_the_room_and_not_the_garden_and_leaves_the_mean(guided):
    scene = vc.scenes.window_room() if guided else vc.scenes.garden(triangles=60_000)
    cache = vc.VisibilityMapCache(scene)
    cache.update(size=(48, 36))
    maps = vc.VisMaps(cache=cache, update=False)
    for seed in range(4):
        tried = shown(scene, direct(n_environment=1), maps, size=(64, 48), seed=seed)
        assert tried.counters["pilot_guided"] == guided
    many, few = (direct(n_environment=n, centred=True) for n in (1024, 32))
    usual = images(20, scene, many, seed=500).mean(axis=(1, 2, 3))
    ours = images(60, scene, few, maps).mean(axis=(1, 2, 3))
    sigma = np.hypot(*(m.std(ddof=1) / np.sqrt(len(m)) for m in (ours, usual)))
    assert abs(ours.mean() - usual.mean()) < 3.5 * sigma
    assert 0.05 * usual.mean() > 5 * sigma, "a twentieth more light would show"


BARE = vc.scenes.cube_on_plane()
ANOTHER = vc.VisibilityMapCache(BARE, vc.MapSettings(n_startup=10))
BAD = [
    ({"scene": BARE, "integrator": vc.Direct()}, "scene must have an environment light"),
    (
        {"scene": vc.scenes.room(triangles=5000), "env": 1.0, "maps": vc.VisMaps(cache=ANOTHER)},
        "cache must be of the scene",
    ),
]


@pytest.mark.parametrize(("given", "message"), BAD)
def test_what_cannot_be_is_refused(scene, given, message):
    with pytest.raises(ValueError, match=message):
        shown(**{"scene": scene, "maps": vc.VisMaps(), **given})
