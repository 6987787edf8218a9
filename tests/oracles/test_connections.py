"""The renderer's connections: answers to its queries give its frames."""

import numpy as np
import pytest

import viscache as vc
from oracles.test_written import Grid
from reference.built import built
from viscache.oracles.points import unpack

SIZE = (72, 40)
ROOM = "room?triangles=3000"


def frames(scene, integrator, visibility, **options):
    """The frame from answers, and the renderer's."""
    use = options.pop("use", None)
    conn = vc.connections(scene, integrator, size=SIZE, **options)
    made = conn.frame(conn.answers(visibility, use=use))
    return made, vc.render(scene, integrator, size=SIZE, visibility=visibility, use=use, **options)


FAST, OWN = vc.Aqvc(preset="fast", c_e=8), {"spp": 4, "env": (0.5, 0.6, 0.7)}
AMBIENT = vc.AmbientOcclusion(n_samples=9, max_distance=1.0)
SHOTS = {
    "exact": (ROOM, vc.Whitted(n_vpls=80), vc.Exact(), {"seed": 3}),
    "aqvc": (ROOM, vc.Whitted(n_vpls=80), vc.Aqvc(c_e=8), {"spp": 4}),
    "paper": (ROOM, vc.Whitted(n_vpls=80), vc.Aqvc(c_e=6, preset="paper"), {}),
    "maps": (ROOM, vc.Whitted(n_vpls=80), vc.ShadowMap(resolution=64), {"spp": 4}),
    "fast": (ROOM, vc.Whitted(n_vpls=80), FAST, {"seed": 3}),
    "picks": (ROOM, vc.Whitted(n_vpls=80, pick=3), vc.Aqvc(c_e=8), {"seed": 3}),
    "own": (ROOM, vc.Whitted(n_vpls=40), Grid(cell=0.3), {}),
    "exact groups": (ROOM, vc.Whitted(n_vpls=40), vc.Aqvc(c_e=8, exact_groups=("vpl",)), {}),
    "areas": ("cornell_box", vc.Direct(n_area=5), vc.Exact(), OWN),
    "areas, aqvc": ("cornell_box", vc.Direct(n_area=5), vc.Aqvc(c_e=8), OWN),
    "ambient": ("cornell_box", AMBIENT, vc.Exact(), OWN),
    "ambient, aqvc": ("cornell_box", AMBIENT, vc.Aqvc(c_e=8), OWN),
}


@pytest.mark.parametrize("name", SHOTS)
def test_answers_make_the_renderers_frame_byte_for_byte(name):
    spec, integrator, visibility, options = SHOTS[name]
    made, rendered = frames(built(spec), integrator, visibility, **options)
    assert made.sha256 == rendered.sha256
    for layer, pixels in rendered.layers.items():
        np.testing.assert_array_equal(made.layers[layer], pixels)


@pytest.mark.parametrize(
    ("visibility", "use"),
    [(vc.Aqvc(c_e=12), vc.Correct(share=0.3)), (vc.NeePlusPlus(n_voxels=4), "correct")],
    ids=["aqvc", "means"],
)
def test_corrected_answers_too(visibility, use):
    """Up to rounding: the renderer adds corrections one by one, answers hold one weight each."""
    made, rendered = frames(built(ROOM), vc.Whitted(n_vpls=40), visibility, use=use)
    np.testing.assert_allclose(made.image, rendered.image, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("pick", [0, 3])
def test_contributions_of_what_is_seen_are_the_light(pick):
    scene, whitted = built(ROOM), vc.Whitted(n_vpls=30, pick=pick)
    conn = vc.connections(scene, whitted, size=SIZE, seed=1)
    exact = vc.render(scene, whitted, size=SIZE, seed=1)
    oracle, total = conn.oracle(vc.Exact()), np.zeros(3)
    for group, ends in conn.groups.items():
        seen = oracle.block(conn.eyes, ends).visible
        light = conn.contributions(group)
        assert light.shape == (len(conn.eyes), len(ends), 3)
        np.testing.assert_array_equal(light[10:20], conn.contributions(group, slice(10, 20)))
        wanted = unpack(conn.wanted(group), len(ends))
        np.testing.assert_array_equal(wanted, light.sum(axis=2) > 0)
        assert not pick or (wanted.sum(axis=1) <= pick).all()
        total += (light * seen[..., None]).sum(axis=(0, 1))
    groups = [exact.layers[name] for name in conn.groups]
    np.testing.assert_allclose(total, np.sum(groups, axis=(0, 1, 2)), rtol=1e-4)


def test_plain_arrays_are_answers_too():
    scene = built(ROOM)
    conn = vc.connections(scene, vc.Direct(), size=SIZE)
    rendered = vc.render(scene, vc.Direct(), size=SIZE)
    bits = {
        group: conn.oracle(vc.Exact()).block(conn.eyes, ends).visible
        for group, ends in conn.groups.items()
    }
    assert conn.frame(bits).sha256 == rendered.sha256
    half = {group: (seen, np.full(seen.shape, 0.5)) for group, seen in bits.items()}
    halved = conn.frame(half).layers["point"]
    np.testing.assert_allclose(halved, rendered.layers["point"] / 2, rtol=1e-6)
    assert not conn.frame({}).layers["point"].any()


def test_wrong_answers_are_refused():
    conn = vc.connections(built(ROOM), vc.Direct(), size=SIZE)
    seen = np.ones((len(conn.eyes), len(conn.groups["point"])), dtype=bool)
    for answers, match in (
        ({"points": seen}, "answers must be of point"),
        ({"point": seen[:5]}, "must have shape"),
        ({"point": seen.astype(float)}, "must be bool or bits"),
        ({"point": (seen, np.full(seen.shape, np.inf))}, "finite"),
        ({"point": (seen, np.ones(3))}, "weights must have shape"),
    ):
        with pytest.raises(ValueError, match=match):
            conn.frame(answers)
    for make, match in (
        (lambda: vc.connections(conn._scene, vc.Bdpt()), "integrator must be"),  # type: ignore[arg-type]
        (lambda: vc.connections(conn._scene, vc.Direct(environment="product")), "product"),
        (lambda: conn.contributions("area"), "group must be one of"),
        (lambda: conn.contributions("point", slice(0, 10, 2)), "without a step"),
    ):
        with pytest.raises(ValueError, match=match):
            make()


def test_own_virtual_lights_and_arrays_of_lamps():
    d = vc.SceneDescription()
    d.add_mesh([(-2, 0, -2), (2, 0, -2), (2, 0, 2), (-2, 0, 2)], [(0, 2, 1), (0, 3, 2)])
    d.add_point_lights([(0, 1, 0), (1, 2, 0)], [(1, 1, 1), (2, 1, 0)])
    scene = vc.Scene.from_description(d)
    assert [light["kind"] for light in scene.lights] == ["point", "point"]
    own = vc.Vpls([(0, 2, 0), (1, 2, 1)], [(0, -1, 0), (0, -2, 0)], [1.0, 2.0])
    camera = vc.look_at((0, 3, 3), (0, 0, 0), (0, 1, 0), 60)
    conn = vc.connections(scene, vc.Whitted(vpls=own), size=SIZE, camera=camera)
    assert len(conn.groups["vpl"]) == 2
    frame = vc.render(scene, vc.Whitted(vpls=own), size=SIZE, camera=camera)
    assert frame.counters["vpls"] == 2
    # One patch above the floor: f · flux · cos · cos' / (d² + bound²) at every eye point
    light = conn.contributions("vpl")
    eye = np.asarray(conn.eyes.positions, dtype=np.float64)
    place = np.asarray(conn.groups["vpl"].positions, dtype=np.float64)
    flux = np.array([own.flux[own.positions.tolist().index(p)][0] for p in place.tolist()])
    towards = place[None] - eye[:, None]
    d2 = (towards**2).sum(axis=2)
    bound2 = (0.01 * np.linalg.norm(np.diff(scene.bounds, axis=0))) ** 2
    cosines = towards[..., 1] ** 2 / d2
    expected = 0.5 / np.pi * flux * cosines / (d2 + bound2)  # the default material's base colour
    np.testing.assert_allclose(light[..., 0], expected, rtol=1e-5)
    for make, match in (
        (lambda: vc.Whitted(vpls=[(0, 0, 0)]), "vpls must be"),
        (lambda: d.add_point_lights([(0, 1, 0)], [(1, 1, 1), (2, 1, 0)]), "equal numbers of rows"),
        (lambda: vc.Vpls([(0, 2, 0)], [(0, -1, 0)], [-1.0]), "flux must be >= 0"),
    ):
        with pytest.raises(ValueError, match=match):
            make()


@pytest.mark.parametrize(
    "integrator", [vc.Whitted(n_vpls=64), vc.Direct(n_area=4)], ids=["shared lights", "own samples"]
)
def test_the_unoccluded_frame_is_all_contributions_summed(integrator):
    scene = built(ROOM)
    frame = vc.render(scene, integrator, size=SIZE, visibility=vc.Unoccluded())
    taps = vc.connections(scene, integrator, size=SIZE)
    seen = {name: np.ones_like(answer.visible) for name, answer in taps.answers(vc.Exact()).items()}
    assert frame.sha256 == taps.frame(seen).sha256
    exact = vc.render(scene, integrator, size=SIZE)
    assert frame.counters["queries"] == exact.counters["queries"]
    assert frame.counters["rays"] == frame.counters["occluded"] == 0
    assert np.all(frame.image >= exact.image * (1 - 1e-5))
    assert frame.image.mean() > 1.02 * exact.image.mean()


def test_unoccluded_ambient_is_white_and_bidirectional_paths_take_it():
    scene = built(ROOM)
    ambient = vc.AmbientOcclusion(n_samples=4)
    frame = vc.render(scene, ambient, size=SIZE, visibility=vc.Unoccluded())
    assert frame.image.min() == pytest.approx(1, abs=1e-6)
    bright, exact = (
        vc.render(scene, vc.Bdpt(max_depth=3), size=SIZE, visibility=v).image.mean()
        for v in (vc.Unoccluded(), vc.Exact())
    )
    assert bright > exact
