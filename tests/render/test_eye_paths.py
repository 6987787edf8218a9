"""Eye points and their density D_e, cameras, and scenes at the edge of what there is to see."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, ball, box, quad
from viscache import _core
from viscache.settings.integrators import eye_settings
from viscache.shot.shot import frame_settings

FLOOR = quad((-3, 0, -3), (0, 0, 6), (6, 0, 0))
VIEW = {"origin": (0, 2, 2), "target": (0, 0, 0), "fov_deg": 40}


def eye_points(scene, integrator, size, spp=1):
    core, settings = eye_settings(integrator), frame_settings(size, spp, 3, 1)
    return _core.trace_eye_points(scene._core, scene.caster(), scene.cameras[0], core, settings)


def rendered(model, integrator=None, edge=8):
    return vc.render(model.to_viscache(), integrator or vc.Direct(), size=(edge, edge))


@pytest.mark.parametrize("spp", [1, 4, 9])
def test_one_over_the_density_adds_up_to_the_area_in_view(spp):
    """Each eye point stands for 1/D_e of surface: on a floor in full view, the view's trapezoid."""
    scene = Model((FLOOR,), **VIEW).to_viscache()
    found = eye_points(scene, vc.Direct(), (60, 40), spp)
    half, camera = np.tan(np.radians(20)), scene.cameras[0]
    origin, forward, right, up = (
        np.array(getattr(camera, name)) for name in ("origin", "forward", "right", "up")
    )
    corners = [
        forward + sx * 1.5 * half * right + sy * half * up
        for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    x, _, z = np.array([origin - d * origin[1] / d[1] for d in corners]).T
    area = 0.5 * abs(np.dot(x, np.roll(z, 1)) - np.dot(z, np.roll(x, 1)))
    assert len(found["density"]) == 60 * 40 * spp
    assert np.sum(1 / found["density"]) == pytest.approx(area, rel=0.01)


def density_from(camera, eye, axis, found, size):
    """NumPy: one sample per pixel of a pinhole at `eye`, spread over the surface around a point."""
    width, height = size
    way = found["position"] - eye
    distance = np.linalg.norm(way, axis=1)
    half = np.tan(camera.fov_rad / 2)
    pixel = 4 * half * half * (width / height) / (width * height)
    at_camera = (way @ axis) / distance
    at_point = np.abs((way * found["normal"]).sum(axis=1)) / distance
    return np.maximum(at_point, 0.05) / (pixel * at_camera**3 * distance**2)


def test_the_density_is_that_of_the_camera_and_in_a_plane_mirror_of_its_image():
    mirror = quad((-1.5, 0, -1), (3, 0, 0.3), (0, 2, 0), look=Look(kind="mirror"))
    scene, size = Model((FLOOR, mirror), **VIEW).to_viscache(), (90, 60)
    camera = scene.cameras[0]
    eye, axis = np.array(camera.origin), np.array(camera.forward)
    normal = np.cross((3, 0, 0.3), (0, 2, 0))
    normal = normal / np.linalg.norm(normal)
    image = eye - 2 * normal * ((eye - (-1.5, 0, -1)) @ normal)
    found = eye_points(scene, vc.Whitted(), size)
    seen = density_from(camera, eye, axis, found, size)
    mirrored = density_from(camera, image, axis - 2 * normal * (axis @ normal), found, size)
    by_camera = np.isclose(found["density"], seen, rtol=1e-3)
    by_image = np.isclose(found["density"], mirrored, rtol=1e-3)
    assert (by_camera | by_image).all()
    direct = len(eye_points(scene, vc.Direct(), size)["density"])
    assert by_camera.sum() == pytest.approx(direct, abs=3)  # some points may have both
    assert by_image.sum() > 100, "the mirror shows the floor"


def test_grazing_views_clamp_the_cosine():
    floor = quad((-300, 0, -300), (0, 0, 600), (600, 0, 0))
    low = Model((floor,), origin=(0, 0.1, 5), target=(0, 0, -100)).to_viscache()
    found, camera = eye_points(low, vc.Direct(), (30, 20)), low.cameras[0]
    want = density_from(camera, np.array(camera.origin), np.array(camera.forward), found, (30, 20))
    np.testing.assert_allclose(found["density"], want, rtol=1e-3)
    distance = np.linalg.norm(found["position"] - camera.origin, axis=1)
    flat = np.abs(camera.origin[1]) < 0.05 * distance
    assert 0.1 < flat.mean() < 0.9, "some views are clamped, others not"


def test_normals_lie_on_the_side_of_the_eye_and_origins_off_the_surface():
    scene = Model((FLOOR, box((-0.5, 0, -0.5), (0.5, 1, 0.5)).reversed()), **VIEW).to_viscache()
    found = eye_points(scene, vc.Direct(), (60, 40))
    to_eye = np.array(scene.cameras[0].origin) - found["position"]
    assert (np.einsum("ij,ij->i", to_eye, found["normal"]) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(found["normal"], axis=1), 1, rtol=1e-5)
    off = found["origin"].astype(float) - found["position"]
    lifted = np.einsum("ij,ij->i", off, found["normal"])
    assert (lifted > 0).all() and lifted.max() < 1e-4


def test_depth_normal_and_albedo_are_those_of_the_first_hit():
    look = Look(base_color=(0.1, 0.2, 0.3))
    wall = quad((-9, -9, -2), (18, 0, 0), (0, 18, 0), look=look)
    layers = rendered(Model((wall,), origin=(0, 0, 1), target=(0, 0, 0)), edge=9).layers
    np.testing.assert_allclose(layers["depth"][4, 4], 3, rtol=1e-2)
    np.testing.assert_allclose(layers["normal"] - [0, 0, 1], 0, atol=1e-6)
    np.testing.assert_allclose(layers["albedo"] / look.base_color, 1, rtol=1e-6)
    assert (layers["depth"][0, 0] > layers["depth"][4, 4]).all()


@pytest.mark.parametrize("spec", ["room?triangles=2000", "courtyard?triangles=5000"])
def test_packets_of_primary_rays_find_what_single_rays_find(spec):
    """Also through instances, where Embree's wide coherent packets are unsound."""
    scene = vc.scenes.build(spec)
    width, height = 61, 43  # no multiple of a packet
    camera = scene.cameras[0]
    assert not camera.fov_is_horizontal
    up = np.tan(0.5 * camera.fov_rad)
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    forward, right, top = (np.asarray(v) for v in (camera.forward, camera.right, camera.up))
    across = (2 * x - 1)[..., None] * right * (up * width / height)
    ways = (forward + across + (1 - 2 * y)[..., None] * top * up).reshape(-1, 3)
    ways = (ways / np.linalg.norm(ways, axis=-1, keepdims=True)).astype(np.float32)
    origins = np.broadcast_to(np.float32(camera.origin), ways.shape).copy()
    single = scene.caster().bare_intersect(origins, ways).reshape(height, width)
    frame = vc.render(scene, vc.Direct(centred=True), size=(width, height))
    hit = np.isfinite(single)
    assert hit.mean() > 0.5
    # Rays through an edge may go either way by one rounding of the direction
    close = np.isclose(frame.layers["depth"][..., 0], np.where(hit, single, 0), rtol=1e-4)
    assert close.mean() > 0.998


def test_first_hits_are_means_over_the_samples_that_hit_and_zero_where_none_did():
    """A wall that ends within a column of pixels: its edge is as far and as red as its middle."""
    look = Look(base_color=(0.8, 0.2, 0.1))
    wall = quad((-9, -9, -2), (9.02, 0, 0), (0, 18, 0), look=look)
    model = Model((wall,), origin=(0, 0, 1), target=(0, 0, 0))
    frame = vc.render(model.to_viscache(), vc.Direct(), size=(33, 21), spp=16)
    layers = frame.layers
    coverage = layers["coverage"][..., 0]
    hit, edge = coverage > 0, (coverage > 0) & (coverage < 1)
    np.testing.assert_array_equal(coverage * 16, np.round(coverage * 16))
    assert edge.any(axis=1).all() and (coverage[:, 0] == 1).all() and (coverage[:, -1] == 0).all()
    # Distances to the wall through a pixel's corners bound those of its samples
    y, x = np.abs(np.mgrid[:21, :33] - np.array([10, 16])[:, None, None])
    step = np.tan(np.radians(20)) / 10.5
    low, high = (
        3 * np.sqrt(1 + (step * np.maximum(x + s, 0)) ** 2 + (step * np.maximum(y + s, 0)) ** 2)
        for s in (-0.5, 0.5)
    )
    depth = layers["depth"][..., 0]
    assert (depth >= low * (1 - 1e-6))[hit].all() and (depth <= high * (1 + 1e-6))[hit].all()
    np.testing.assert_allclose(layers["normal"][hit] - [0, 0, 1], 0, atol=1e-6)
    np.testing.assert_allclose(layers["albedo"][hit] - look.base_color, 0, atol=1e-6)
    for name in ("depth", "normal", "albedo"):
        assert not layers[name][~hit].any(), name


def test_right_is_right_and_up_is_up():
    """A red square to the upper right, a green one to the lower left, and nothing else."""
    parts = (
        quad((0.5, 0.5, 0), (1, 0, 0), (0, 1, 0), emission=(1, 0, 0)),
        quad((-1.5, -1.5, 0), (1, 0, 0), (0, 1, 0), emission=(0, 1, 0)),
    )
    model = Model(parts, origin=(0, 0, 4), target=(0, 0, 0), fov_deg=45)
    red, green, _ = np.moveaxis(rendered(model, edge=32).layers["emitted"], 2, 0)
    assert red[:16, 16:].sum() == red.sum() > 10
    assert green[16:, :16].sum() == green.sum() > 10


@pytest.mark.parametrize(
    ("origin", "target", "fov"),
    [
        ((0, 0, 0), (0, 0, 0), 45.0),
        *(((0, 0, bad), (0, 0, 1), 45.0) for bad in (np.nan, np.inf, 2e16)),
        ((0, 0, 0), (np.nan, 0, 1), 45.0),
        *(((0, 0, 0), (0, 0, 1), fov) for fov in (0.0, 180.0, np.nan, -30.0)),
    ],
)
def test_cameras_that_cannot_look_are_refused(origin, target, fov):
    with pytest.raises(ValueError, match=r"camera 'camera': |fov_deg must be in"):
        vc.look_at(origin, target, (0, 1, 0), fov)


def test_a_camera_that_was_broken_later_is_refused():
    scene = Model((FLOOR,), **VIEW).to_viscache()
    broken = scene.cameras[0]
    broken.fov_rad = float("nan")
    with pytest.raises(vc.SceneError, match="field of view"):
        vc.render(scene, vc.Direct(), size=(4, 4), camera=broken)


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -1), (0, 0, 0), (0, 0, 1e-30)])
def test_an_up_along_the_view_is_replaced(up):
    camera = vc.look_at((0, 0, 5), (0, 0, 0), up, 30)
    axes = np.array([camera.right, camera.up, camera.forward])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-6)


@pytest.mark.parametrize(
    "integrator",
    [vc.Direct(), vc.Whitted(n_vpls=16), vc.AmbientOcclusion(n_samples=4)],
    ids=lambda i: type(i).__name__,
)
def test_scenes_with_little_in_them_render(integrator):
    empty = vc.SceneDescription()
    sky = vc.SceneDescription()
    sky.set_environment((1, 2, 3))
    only_lights = vc.SceneDescription()
    only_lights.add_point_light((0, 1, 0), (1, 1, 1))
    only_lights.add_sphere_light((0, 0, 0), 0.5, (1, 1, 1))
    point = vc.SceneDescription()
    point.add_mesh([[1, 1, 1]] * 3, [[0, 1, 2]])
    no_triangles = vc.SceneDescription()
    no_triangles.add_mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    for description in (empty, sky, only_lights, point, no_triangles):
        frame = vc.render(vc.Scene.from_description(description), integrator, size=(6, 4))
        assert np.isfinite(frame.image).all()
    seen = vc.render(vc.Scene.from_description(sky), integrator, size=(6, 4)).image
    expected = [0, 0, 0] if isinstance(integrator, vc.AmbientOcclusion) else [1, 2, 3]
    np.testing.assert_array_equal(seen, np.broadcast_to(np.float32(expected), seen.shape))


def test_a_scene_without_light_is_black_and_says_so():
    frame = rendered(Model((FLOOR,), **VIEW), vc.Whitted(n_vpls=16))
    assert not frame.image.any() and any("no light" in w for w in frame.warnings)
    assert frame.counters["rays"] == 0


def test_a_camera_inside_a_body_sees_its_inner_side():
    view = {"origin": (0, 0, 0.1), "target": (0, 0, -1)}
    inside = Model((ball((0, 0, 0), 1),), points=(((0, 0.2, 0), (1, 1, 1)),), **view)
    assert (rendered(inside).image > 0).all()
    part = replace(inside.parts[0], look=Look(two_sided=False))
    assert not rendered(replace(inside, parts=(part,))).image.any()


def test_direct_shows_light_after_one_bounce_only():
    """Two mirrors face to face with the sky above, which is many bounces away, or one."""
    mirror = Look(kind="mirror", specular=(0.5, 0.5, 0.5))
    walls = tuple(quad((x, -50, -50), (0, 0, 100), (0, 100, 0), look=mirror) for x in (0.0, 1.0))
    model = Model(walls, env=(1, 1, 1), origin=(0.5, 0, 0), target=(1, 0.2, 0), fov_deg=5)
    assert not rendered(model, edge=4).image.any()
    steep = replace(model, target=(1, 40, 0), fov_deg=0.05)
    np.testing.assert_allclose(rendered(steep, edge=4).image, 0.5, rtol=1e-5)


def lit_by(power):
    d = vc.SceneDescription()
    d.add_material()
    d.add_mesh([[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]], [[0, 1, 2], [0, 2, 3]])
    d.add_point_light((0, 0.1, 0), (power,) * 3)
    d.add_camera((0, 0.4, 0.4), (0, 0, 0))
    return vc.render(vc.Scene.from_description(d), vc.Direct(), size=(16, 10))


@pytest.mark.extreme
def test_pixels_that_are_not_finite_are_counted_and_warned_of():
    for power, finite in ((1e38, False), (1.0, True)):
        made = lit_by(power)
        count = int((~np.isfinite(made.image).all(axis=2)).sum())
        assert (count == 0) == finite and made.counters["non_finite_pixels"] == count
        assert made.counters["non_finite"] == 0 if finite else made.counters["non_finite"] >= count
        warned = [w for w in made.warnings if "not finite" in w]
        assert not warned if finite else f"{count} pixels are not finite" in warned[0]
