"""Audits: estimates of the error of a cached frame, whose intervals hold as often as they say."""

import functools
import json

import numpy as np
import pytest

import viscache as vc
from oracles.test_written import Half
from reference.built import built
from reference.vismap_records import z_order
from viscache import _core, cli
from viscache.metrics import compare
from viscache.oracles.points import unpack
from viscache.settings import audit as audits
from viscache.shot.audited import pixel_estimates

CACHE = vc.Aqvc(c_e=16, exact_groups=())
LIGHTS = vc.Whitted(n_vpls=24, n_area=4)
#: All pixels, all queries.
WHOLE = vc.AuditPixels(n=1 << 20)
ALL = vc.AuditQueries(share=1)


class Own:
    """An oracle that takes every second light as visible."""

    def block(self, eyes, lamps, wanted):
        seen = eyes.trace(lamps, wanted)
        return seen | (unpack(wanted, len(lamps)) & (np.arange(len(lamps)) % 2 == 0))


@pytest.fixture(scope="module")
def room():
    return vc.scenes.room(triangles=2000)


def picture(width, height):
    """Some light, a bright spot, and pixels without."""
    light = np.random.default_rng(3).random((height, width)).astype(np.float32)
    light[5:8, 9:13] = 40
    light[-4:] = 0
    light[0, 0] = -1
    return light


@pytest.mark.parametrize("n", [1024, 1025, 3999, 4000, 1 << 20])
def test_the_pixels_are_stratified_along_the_morton_curve(n):
    width, height = 80, 50
    light = picture(width, height)
    drawn = _core.draw_audit_pixels(light, n, 7)
    x, y, weight = drawn.T
    assert x.max() < width and y.max() < height
    assert len(drawn) == min(n + n % 2, width * height)
    codes = np.array([z_order(int(a), int(b)) for a, b in zip(x, y, strict=True)])
    if n >= width * height:
        assert (weight == 1).all() and (np.diff(codes) > 0).all()
        return
    # Strata follow each other
    pairs = np.sort(codes.reshape(-1, 2), axis=1)
    assert (pairs[1:, 0] >= pairs[:-1, 1]).all()
    near = np.pad(np.maximum(light, 0).astype(np.float64), 2)
    size = np.lib.stride_tricks.sliding_window_view(near, (5, 5)).max(axis=(2, 3))
    size += size.mean()
    expected = size.sum() / len(drawn) / size[y.astype(int), x.astype(int)]
    np.testing.assert_allclose(weight, expected, rtol=1e-6)
    other = _core.draw_audit_pixels(light, n, 8)
    assert (other != drawn).any()


def test_weighted_pixels_estimate_sums_without_bias():
    light, n, seeds = picture(33, 65), 1024, 400
    values = np.random.default_rng(4).random(light.shape)
    sums, counts = [], np.zeros(light.shape)
    for seed in range(seeds):
        x, y, weight = _core.draw_audit_pixels(light, n, seed).T
        rows, columns = y.astype(int), x.astype(int)
        sums.append((weight * values[rows, columns]).sum())
        np.add.at(counts, (rows, columns), weight)
    z = (np.mean(sums) - values.sum()) / (np.std(sums, ddof=1) / seeds**0.5)
    assert abs(z) < 4
    assert abs(0.99 * np.mean(sums) - values.sum()) / (np.std(sums) / seeds**0.5) > 4
    assert counts.min() > 0 and counts.mean() / seeds == pytest.approx(1, abs=0.01)


AUDITED = {
    "aqvc": (CACHE, LIGHTS),
    "picks": (CACHE, vc.Whitted(n_vpls=24, pick=5)),
    "paper": (vc.Aqvc(preset="paper", c_e=16), LIGHTS),
    "nee": (vc.NeePlusPlus(), LIGHTS),
    "shadow maps": (vc.ShadowMap(resolution=64), vc.Direct()),
    "unoccluded": (vc.Unoccluded(), LIGHTS),
    "own": (Own(), vc.Whitted(n_vpls=24)),
    "ambient": (CACHE, vc.AmbientOcclusion(n_samples=16)),
}


@pytest.mark.parametrize("name", AUDITED)
def test_an_audit_of_all_pixels_is_the_comparison_with_the_exact_frame(room, name):
    visibility, integrator = AUDITED[name]
    given = {"size": (40, 30), "spp": 2}
    exact = vc.render(room, integrator, **given)
    given["visibility"] = visibility
    frame = vc.render(room, integrator, audit=WHOLE, **given)
    assert frame.sha256 == vc.render(room, integrator, **given).sha256
    audit = frame.audit
    assert audit is not None and audit.pixels == 1200
    truth = compare(frame, exact, metrics=["rel_l1", "rel_l1_reflected"])
    assert truth.rel_l1 > 0
    for metric in ("rel_l1", "rel_l1_reflected"):
        found = getattr(audit, metric)
        assert found.value == pytest.approx(truth[metric], rel=1e-4)
        assert found.low == found.value == found.high and found.se == 0
    squares = np.square(frame.image.astype(np.float64) - exact.image).mean()
    assert audit.nrmse.value == pytest.approx(squares**0.5 / exact.image.mean(), rel=1e-4)
    for group, one in audit.groups.items():
        a, b = (f.layers[group].astype(np.float64) for f in (frame, exact))
        if b.sum() > 0:
            assert one.rel_l1.value == pytest.approx(np.abs(a - b).sum() / b.sum(), abs=1e-6)


@pytest.mark.parametrize("integrator", [LIGHTS, vc.AmbientOcclusion(n_samples=16)])
def test_an_audit_of_all_queries_is_the_bias_and_the_share_of_wrong_answers(room, integrator):
    size = (40, 30)
    exact = vc.render(room, integrator, size=size)
    frame = vc.render(room, integrator, visibility=CACHE, size=size, audit=ALL)
    audit, energy = frame.audit, compare(frame, exact, metrics=["energy"]).energy
    assert audit is not None and not hasattr(audit, "rel_l1")
    assert audit.bias.value == pytest.approx(energy, rel=1e-3, abs=1e-6)
    assert audit.audited == audit.queries == frame.counters["queries"]
    assert audit.bias.se == 0 and 0.001 < audit.wrong.value < 0.5
    # Wrong answers from the queries themselves
    asked, wrong = vc.connections(room, integrator, size=size), 0
    cached, truth = (asked.answers(v) for v in (CACHE, vc.Exact()))
    for group in cached:
        different = cached[group].visible ^ truth[group].visible
        if group in asked.groups:
            different &= unpack(asked.wanted(group), len(asked.groups[group]))
        wrong += int(different.sum())
    assert round(audit.wrong.value * audit.queries) == wrong


def test_queries_that_exact_rays_answer_count_as_right(room):
    every = vc.Aqvc(c_e=16, exact_groups=("point", "vpl", "area"))
    some = vc.Aqvc(c_e=16, exact_groups=("vpl",))
    frames = [
        vc.render(room, LIGHTS, visibility=v, size=(40, 30), audit=ALL) for v in (every, some)
    ]
    assert frames[0].audit.audited == 0 and frames[0].audit.wrong.value == 0
    found = frames[1].audit
    assert 0 < found.audited < found.queries
    assert found.groups["vpl"].audited == 0 and found.groups["point"].wrong.value > 0
    share = found.groups["point"].queries / found.queries
    assert found.wrong.value == pytest.approx(share * found.groups["point"].wrong.value)


def test_parts_of_a_frame_audit_their_own_pixels_and_all_queries(room):
    for audit in ("pixels", vc.AuditQueries(share=0.1)):
        options = {"visibility": CACHE, "size": (150, 140), "audit": audit}
        whole = vc.render(room, LIGHTS, **options)
        parts = vc.tiles.render(room, LIGHTS, parts=3, **options)
        assert "audit_found" not in parts.counters and parts.sha256 == whole.sha256
        if audit == "pixels":
            assert 1024 <= parts.audit.pixels <= 1030
            assert parts.audit.rel_l1.low < whole.audit.rel_l1.high
            assert whole.audit.rel_l1.low < parts.audit.rel_l1.high
        else:
            assert parts.counters["audit"] == whole.counters["audit"]


class Errs:
    """Hides the lowest lamp near it, and turns a random share of the other answers."""

    def __init__(self, reach, share):
        self.reach, self.share = reach, share

    def block(self, eyes, lamps, wanted):
        seen = np.array(eyes.trace(lamps, wanted))
        place, lowest = eyes.positions.astype(float), int(np.argmin(lamps.positions[:, 1]))
        noise = np.abs(np.sin(place @ [12.98, 78.2, 37.7] * 4375))[:, None] * 1e3
        turned = (noise + np.arange(len(lamps)) * 0.618) % 1 < self.share
        turned[:, lowest] = False
        near = np.linalg.norm(place - lamps.positions[lowest], axis=1) < self.reach
        seen ^= turned
        seen[near, lowest] = False
        return seen


@functools.cache
def low_lamp():
    """Twelve lamps, and a weak one that lights a few pixels brightly."""
    d, rng = vc.SceneDescription(), np.random.default_rng(4)
    grey = d.add_material(base_color=(0.6, 0.6, 0.6))
    floor = [[-6, 0, -6], [6, 0, -6], [6, 0, 6], [-6, 0, 6]]
    d.add_mesh(np.float32(floor), np.uint32([[0, 2, 1], [0, 3, 2]]), material=grey)
    for _ in range(14):
        corners = rng.uniform([-2.5, 0.1, -2.5], [2.5, 0.9, 2.5]) + rng.normal(0, 0.3, (3, 3))
        d.add_mesh(np.float32(corners), np.uint32([[0, 1, 2]]), material=grey)
    places = rng.uniform([-3, 1.5, -3], [3, 4, 3], (12, 3))
    d.add_point_lights(places, np.full((12, 3), 3, np.float32))
    d.add_point_light((0.9, 0.05, 1.9), (0.05, 0.05, 0.05))
    d.add_camera((0, 5, 4.5), (0, 0.2, 0))
    return vc.Scene.from_description(d)


#: Caches whose errors are spread, hide a lamp, and are rare and bright: scene, lights, cache, size.
CACHES = {
    "spread": (lambda: built("room?triangles=5000"), vc.Whitted(n_vpls=64), CACHE, (160, 100)),
    "hides a lamp": (low_lamp, vc.Direct(), Errs(9.0, 0.01), (128, 64)),
    "rare and bright": (low_lamp, vc.Direct(), Errs(0.3, 0.01), (128, 64)),
}


@pytest.mark.parametrize("name", CACHES)
def test_intervals_of_whole_pixels_hold_as_often_as_they_say(name):
    make, lights, cache, size = CACHES[name]
    scene, seeds = make(), 200
    exact, frame, unoccluded = (
        vc.render(scene, lights, visibility=v, size=size)
        for v in (vc.Exact(), cache, vc.Unoccluded())
    )
    error = frame.image.astype(np.float64) - exact.image
    truth = compare(frame, exact, metrics=["rel_l1"]).rel_l1
    light = float(frame.image.astype(np.float64).sum())

    def drawn(by, seed):
        seen = (by.image - by.layers["emitted"]).sum(axis=2)
        pixels = _core.draw_audit_pixels(seen, 1024, seed)
        x, y = pixels[:, :2].astype(int).T
        return pixel_estimates(pixels[:, 2], error[y, x], seen.size, light)["rel_l1"]

    def holds(found):
        return bool(found["low"] <= truth <= found["high"])

    every = [drawn(unoccluded, seed) for seed in range(seeds)]
    # An interval of half the width would be told
    narrow = sum(
        abs(np.log(f["value"] / truth)) <= np.log(f["high"] / f["value"]) / 2 for f in every
    )
    assert 0.92 <= sum(map(holds, every)) / seeds <= 0.98
    assert narrow / seeds < 0.85
    assert np.mean([f["value"] for f in every]) == pytest.approx(truth, rel=0.03)
    if name != "spread":
        # By the light of the cache, pixels that it leaves dark are rarely drawn
        assert sum(holds(drawn(frame, seed)) for seed in range(seeds)) / seeds < 0.88
        # Frames draw by light without shadows
        own = vc.render(scene, lights, visibility=cache, size=size, audit="pixels").audit.rel_l1
        assert own.value == pytest.approx(every[0]["value"], rel=1e-3)


def test_intervals_of_queries_hold(room):
    size, seeds = (64, 48), 120
    places = np.random.default_rng(2).uniform(*room.bounds, (24, 3))
    down = np.broadcast_to([0.0, -1, 0], places.shape)
    lights = vc.Whitted(vpls=vc.Vpls(places, down, np.full(24, 0.1)), n_area=4)
    held = {"bias": 0, "wrong": 0}
    for seed in range(seeds):
        found = [
            vc.render(room, lights, visibility=CACHE, size=size, seed=seed, audit=audit).audit
            for audit in (vc.AuditQueries(share=0.05), ALL)
        ]
        for name in held:
            one, truth = (getattr(f, name) for f in found)
            held[name] += one.low <= truth.value <= one.high
    assert all(0.92 <= n / seeds <= 0.99 for n in held.values()), held


def test_no_interval_where_none_was_shown_to_hold(room):
    def audit(size, cache=CACHE, audit=None):
        return vc.render(room, LIGHTS, visibility=cache, size=size, audit=audit).audit

    watched = audit((160, 128))
    assert watched.pixels == 80 and watched.rel_l1.value > 0 and watched.rel_l1.low is None
    small = audit((64, 48), audit="pixels")  # a third of the pixels
    assert small.pixels == 1024 and small.rel_l1.high is None
    assert "more than an eighth of 3072 pixels were drawn" in small.rel_l1.why
    assert "at least 1024 drawn pixels, got 80" in watched.rel_l1.why
    fits = audit((128, 128), audit="pixels")
    assert fits.rel_l1.low < fits.rel_l1.value < fits.rel_l1.high and fits.nrmse.low is None
    assert all(g.rel_l1.low is not None for n, g in fits.groups.items() if n != "area")
    # Hardly a wrong answer
    fine = audit((128, 128), vc.Aqvc(c_e=0.05, exact_groups=()), audit="pixels")
    assert fine.rel_l1.low is None and "at least 50 wrong pixels" in fine.rel_l1.why
    few = audit((64, 48), vc.Aqvc(c_e=0.2, exact_groups=()), audit="queries")
    assert few.bias.low is None and few.wrong.low is not None
    assert "at least 50 wrong answers drawn" in few.bias.why and few.wrong.why is None
    assert "rarely drawn" in fits.nrmse.why and fits.rel_l1.why is None


def test_frames_files_pages_and_the_command_line_show_it(room, tmp_path, capsys):
    given = {"visibility": CACHE, "size": (128, 128)}
    frame = vc.render(room, LIGHTS, audit="pixels", **given)
    frame.save(tmp_path / "frame.exr")
    assert vc.Frame.load(tmp_path / "frame.exr").audit == frame.audit is not None
    assert frame.parameters["audit"] == {"name": "AuditPixels", "n": 1024}
    page = frame._repr_html_()
    assert "95 % intervals" in page and str(frame.audit.rel_l1) in page and "nrmse" not in page
    plain = vc.render(room, LIGHTS, **given)
    assert "95 %" not in plain._repr_html_() + "".join(plain.warnings)
    assert "audit" not in plain.parameters

    command = ["render", "room?triangles=2000", "-o", str(tmp_path / "a.exr"), "--size", "128x128"]
    command += ["--visibility", "aqvc", "--set", "c_e=16", "--set", "n_vpls=24"]
    assert cli.main([*command, "--audit", "pixels"]) == 0
    assert "rel_l1 " in capsys.readouterr().out
    assert cli.main([*command, "--audit", "queries:0.1", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["counters"]["audit"]["wrong"]["low"] > 0
    assert shown["parameters"]["audit"]["share"] == 0.1
    for wrong in ("pixels:3", "pixel", "queries:2", "queries:x"):
        assert cli.main([*command, "--audit", wrong]) == 2
        assert "must be" in capsys.readouterr().err or wrong == "queries:x"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: vc.AuditPixels(n=1023), r"n must be in \[1024, 2\^24\], got 1023"),
        (lambda: vc.AuditPixels(n=2.5), "n must be a whole number"),
        (lambda: vc.AuditQueries(share=0), r"share must be in \(0, 1\], got 0"),
        (lambda: vc.AuditQueries(share=float("nan")), "share must be a finite number"),
        (lambda: vc.AuditQueries(above=-1), "above must be in"),
        (lambda: audits.checked("pixel"), "audit must be .* did you mean 'pixels'"),
        (lambda: audits.checked(1024), "audit must be .*, got 1024"),
    ],
)
def test_bad_settings_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_weights_have_no_audit_of_queries(room):
    with pytest.raises(ValueError, match="without weights"):
        vc.render(room, LIGHTS, size=(8, 8), audit="queries", visibility=Half())


def test_passes_drop_the_audit_of_one_pass(room):
    picture = vc.Progressive(room, LIGHTS, visibility=CACHE, use="replace", size=(64, 48))
    assert picture.passes(1).audit is not None
    assert picture.passes(1).audit is None
