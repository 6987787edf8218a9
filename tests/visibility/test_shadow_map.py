"""Shadow maps: depths, the depth test and its bias, and frames that use them."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from render.test_determinism import ROOM

CENTER, RADIUS = (0.0, 0.0, 0.0), 2.0


def quads(*corners):
    """Two triangles for each (origin, edge, edge)."""
    vertices = [(o, np.add(o, a), np.add(np.add(o, a), b), np.add(o, b)) for o, a, b in corners]
    n = 4 * np.arange(len(corners))[:, None, None]
    triangles = np.array([[0, 1, 2], [0, 2, 3]]) + n
    return vc.Scene.from_arrays(np.reshape(vertices, (-1, 3)), triangles.reshape(-1, 3))


def room():
    """The cube [-1, 1]³ seen from inside."""
    sides = []
    for axis in range(3):
        a, b = 2 * np.eye(3)[(axis + 1) % 3], 2 * np.eye(3)[(axis + 2) % 3]
        sides += [((-1, -1, -1), a, b), (tuple(2 * np.eye(3)[axis] - 1), a, b)]
    return quads(*sides)


def look_up(scene, far, points, normals, direction=False, **given):
    """Whether each point is lit, and the depths."""
    core = vc.ShadowMap(**given).core()
    options = {"direction": direction, "center": CENTER, "radius": RADIUS}
    options |= {"positions": np.float32(points), "normals": np.float32(normals)}
    return testing.lit_by_light(scene.caster(), core, far, threads=1, **options)


def unit(v):
    return np.asarray(v, float) / np.linalg.norm(v, axis=-1, keepdims=True)


def test_depths_of_a_room_are_the_distances_of_its_walls():
    light = np.array([0.3, -0.2, 0.5])
    _, depths = look_up(room(), light, np.zeros((1, 3)), np.zeros((1, 3)), resolution=8)
    assert depths.shape == (6, 8, 8)
    centres = (2 * np.arange(8) + 1) / 8 - 1
    for face in range(6):
        axis, sign = face // 2, -1 if face % 2 else 1
        d = np.zeros((8, 8, 3))
        d[..., axis] = sign
        d[..., (axis + 1) % 3] = centres[None, :]
        d[..., (axis + 2) % 3] = centres[:, None]
        with np.errstate(divide="ignore"):
            walls = np.where(d > 0, (1 - light) / d, np.where(d < 0, (-1 - light) / d, np.inf))
        np.testing.assert_allclose(depths[face], walls.min(axis=-1), rtol=1e-5)


def test_a_directional_map_holds_depths_along_the_light_over_the_bounding_sphere():
    towards = unit([0.3, 0.9, -0.2])
    floor = quads(((-9, -1, -9), (0, 0, 18), (18, 0, 0)))
    point = np.array([[0.4, -1.0, 0.7]])
    up = [[0.0, 1.0, 0.0]]
    _, depths = look_up(floor, towards, point, up, direction=True, resolution=64)
    assert depths.shape == (1, 64, 64)
    # A plane: depths are linear in the texel, and have the plane's mean at the centre
    steps = np.diff(depths[0], axis=0), np.diff(depths[0], axis=1)
    for step in steps:
        np.testing.assert_allclose(step, step.mean(), atol=2e-5)
    centre_depth = 2 * RADIUS * 1.0001 + 1 / towards[1]
    assert depths.mean() == pytest.approx(centre_depth, abs=1e-4)


def random_scene(seed):
    """Plates in front of a floor; points on the floor with their normals; a light above all."""
    rng = np.random.default_rng(seed)
    plates = [
        (c, *(0.5 * rng.normal(size=(2, 3))))
        for c in rng.uniform([-0.8, -0.2, -0.8], [0.8, 0.4, 0.8], (6, 3))
    ]
    scene = quads(((-1, -1, -1), (0, 0, 2), (2, 0, 0)), *plates)
    points = np.c_[
        rng.uniform(-0.99, 0.99, 20_000), np.full(20_000, -1.0), rng.uniform(-0.99, 0.99, 20_000)
    ]
    return scene, points, np.tile([0.0, 1.0, 0.0], (20_000, 1)), np.array([0.1, 1.4, -0.2])


@pytest.mark.parametrize("direction", [False, True])
def test_wrong_bits_fall_with_the_resolution(direction):
    """Wrong are points within a texel of a shadow's edge: as many as the texel is wide."""
    resolutions = (32, 64, 128, 256, 512)
    wrong = np.zeros(len(resolutions))
    for seed in range(3):
        scene, points, normals, light = random_scene(seed)
        far = unit(light) if direction else light
        to_light = np.broadcast_to(far, points.shape) if direction else far - points
        t_max = np.inf if direction else 1.0
        seen = ~scene.occluded(points + 1e-5 * normals, to_light, t_max=t_max)
        assert 0.1 < seen.mean() < 0.95
        for k, resolution in enumerate(resolutions):
            lit, _ = look_up(
                scene, far, points, normals, direction=direction, resolution=resolution
            )
            wrong[k] += (lit != seen).mean() / 3
    assert (np.diff(wrong) < 0).all()
    slope = np.polyfit(np.log(resolutions), np.log(wrong), 1)[0]
    assert -1.25 < slope < -0.75
    assert 0 < wrong[-1] < 0.006


def tilted_plane(degrees):
    """A large plane, and points on it, by the angle between its normal and +y."""
    rng = np.random.default_rng(5)
    angle = np.radians(degrees)
    a, b = np.array([np.cos(angle), np.sin(angle), 0]), np.array([0.0, 0.0, 1.0])
    scene = quads((-60 * a - 60 * b, 120 * b, 120 * a))
    s = rng.uniform(-1, 1, (5000, 2))
    return scene, s[:, :1] * a + s[:, 1:] * b, np.tile(np.cross(b, a), (5000, 1))


@pytest.mark.parametrize("degrees", [0, 30, 60, 80, 87])
@pytest.mark.parametrize("direction", [False, True])
def test_a_plane_never_shadows_itself_with_the_slope_bias(degrees, direction):
    scene, points, normals = tilted_plane(degrees)
    far = (0.0, 1.0, 0.0) if direction else (0.0, 1.9, 0.0)
    options = {"direction": direction, "resolution": 64}
    lit, _ = look_up(scene, far, points, normals, **options)
    assert lit.all()
    # Without it there is acne, on a tilted plane or off the axis of the face
    bare, _ = look_up(scene, far, points, normals, bias=0.0, slope_bias=0.0, **options)
    if degrees > 0:
        assert 0.3 < bare.mean() < 0.7


@pytest.mark.parametrize("bias", [0.01, 0.05])
def test_light_leaks_under_a_wall_as_far_as_the_bias(bias):
    """Sun at 45°: the wall is √2·x before a floor point at distance x behind it."""
    scene = quads(((-1.5, 0, -1.5), (0, 0, 3), (3, 0, 0)), ((0, 0, -1), (0, 0, 2), (0, 0.9, 0)))
    x = np.linspace(1e-3, 0.6, 4000)
    points = np.stack([x, 0 * x, 0 * x], axis=1)
    up = np.tile([0.0, 1.0, 0.0], (len(x), 1))
    sun = unit([-1.0, 1.0, 0.0])
    assert scene.occluded(points + 1e-6 * up, np.broadcast_to(sun, points.shape)).all()
    lit, _ = look_up(scene, sun, points, up, direction=True, resolution=2048, bias=bias)
    leak = x[lit].max()
    assert leak == pytest.approx(bias * 2 * RADIUS / np.sqrt(2), rel=0.1)
    assert lit[x < 0.8 * leak].all()


def test_outside_and_degenerate_points_are_lit_or_finite():
    scene = quads(((-1, 0, -1), (0, 0, 2), (2, 0, 0)))
    points = np.array([[9, -1, 9], [0, 1, 0], [0, -1, 0], [0, -1, 0], [np.nan, 0, 0]])
    normals = np.array([[0, 1, 0], [0, 1, 0], [0, 1, 0], [0, 0, 0], [0, 1, 0]])
    sun, _ = look_up(scene, (0, 1, 0), points, normals, direction=True, resolution=16)
    assert sun.tolist() == [True, True, False, False, True]
    lamp, _ = look_up(scene, (0, 1, 0), points, normals, resolution=16)
    assert lamp.tolist()[1:4] == [True, False, False]


def test_frames_ask_maps_for_points_and_directions_and_rays_for_the_rest():
    scene = ROOM.to_viscache()
    whitted = vc.Whitted(n_vpls=24, n_area=4, n_environment=2, n_brdf=2)
    maps = vc.ShadowMap(resolution=200)
    exact = vc.render(scene, whitted, size=(64, 48), seed=2)
    frame = vc.render(scene, whitted, size=(64, 48), seed=2, visibility=maps)
    groups = frame.counters["groups"]
    for name in ("area", "environment", "vpl"):
        np.testing.assert_array_equal(frame.layers[name], exact.layers[name])
        assert groups[name] == exact.counters["groups"][name]
    bypassed = sum(groups[n]["queries"] for n in ("area", "environment", "vpl"))
    assert frame.counters["bypassed"] == bypassed
    assert frame.counters["shadow_maps"] == 2
    assert groups["point"]["rays"] == 6 * 200**2 and groups["directional"]["rays"] == 200**2
    assert frame.counters["shadow_map_bytes"] == 4 * 7 * 200**2
    assert frame.timings["shadow_maps_s"] > 0
    point = {k: f.layers["point"].astype(float) for k, f in (("map", frame), ("ray", exact))}
    assert 0 < np.abs(point["map"] - point["ray"]).sum() < 0.05 * point["ray"].sum()
    assert groups["point"]["queries"] == exact.counters["groups"]["point"]["queries"]


def test_shared_directions_of_the_sky_are_samples_without_maps():
    scene = ROOM.to_viscache()
    direct = vc.Direct(n_area=0, n_environment=9, environment="shared")
    exact = vc.render(scene, direct, size=(32, 24))
    frame = vc.render(scene, direct, size=(32, 24), visibility=vc.ShadowMap(resolution=50))
    np.testing.assert_array_equal(frame.layers["environment"], exact.layers["environment"])
    sky = frame.counters["groups"]["environment"]
    assert sky["queries"] == sky["rays"] == frame.counters["bypassed"] > 0
    assert frame.counters["shadow_maps"] == 2


def test_virtual_point_lights_have_maps_where_asked_for():
    scene = vc.scenes.cornell_box()
    whitted = vc.Whitted(n_vpls=8, n_area=1)
    exact = vc.render(scene, whitted, size=(40, 40))
    errors = []
    for resolution in (32, 256):
        maps = vc.ShadowMap(resolution=resolution, vpls=True)
        frame = vc.render(scene, whitted, size=(40, 40), visibility=maps)
        vpl = frame.counters["groups"]["vpl"]
        assert frame.counters["shadow_maps"] == frame.counters["vpls"]
        assert vpl["rays"] == frame.counters["shadow_map_rays"] == 6 * resolution**2 * 8
        assert frame.counters["bypassed"] == frame.counters["groups"]["area"]["queries"]
        difference = frame.layers["vpl"] - exact.layers["vpl"]
        errors.append(float(np.abs(difference).sum() / exact.layers["vpl"].sum()))
    assert errors[1] < 0.5 * errors[0] and errors[1] < 0.02


def test_maps_that_do_not_fit_are_refused_with_the_bytes_they_need():
    scene = vc.scenes.cube_on_plane()
    maps = vc.ShadowMap(resolution=1000, max_bytes=10**6)
    with pytest.raises(ValueError, match=r"max_bytes must be >= 24000000 .* got 1000000"):
        vc.render(scene, vc.Direct(), size=(8, 8), visibility=maps)
    with pytest.raises(ValueError, match="use must be"):
        vc.render(scene, vc.Direct(), size=(8, 8), visibility=vc.ShadowMap(), use="repair")
