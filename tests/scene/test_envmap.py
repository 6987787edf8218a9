"""scene/envmap.h: environment light on the equal-area octahedral map."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from core import testing
from sampling.chi_square import p_value, sphere_p_value, uniforms
from viscache import _core
from viscache._core.sampling import EnvironmentMap

N = 200_000
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
ROOT = Path(__file__).resolve().parents[2]
SCENES = Path(os.environ.get("VISCACHE_SCENES", ROOT.parent / "shared" / "scenes"))
Array = npt.NDArray[np.float32]


def latlong_directions(height, width):
    """Directions of the pixels' centres: u = atan2(x, −z)/2π mod 1, v = acos(y)/π."""
    theta = (np.arange(height) + 0.5) / height * np.pi
    phi = (np.arange(width) + 0.5) / width * 2 * np.pi
    sin, cos = np.sin(theta)[:, None], np.cos(theta)[:, None]
    return np.stack(np.broadcast_arrays(sin * np.sin(phi), cos, -sin * np.cos(phi)), -1)


def latlong_power(image):
    edges = np.cos(np.arange(image.shape[0] + 1) / image.shape[0] * np.pi)
    rows = (image.astype(float) @ LUMINANCE).sum(1) * 2 * np.pi / image.shape[1]
    return float((rows * (edges[:-1] - edges[1:])).sum())


def sky(height=64):
    """A smooth sky with a soft sun, coloured ground and no symmetry."""
    d = latlong_directions(height, 2 * height)
    sun = np.exp(20 * (d @ np.array([0.48, 0.6, 0.64]) - 1))
    up = 0.5 + 0.5 * d[..., 1]
    return np.stack([up + 8 * sun, up + 6 * sun, 0.2 + up + 3 * sun], -1).astype(np.float32)


def rotation():
    q, _ = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def test_a_bright_pixel_is_seen_where_the_convention_puts_it():
    for row, column in [(5, 3), (16, 40), (31, 63), (17, 0)]:
        image = np.zeros((32, 64, 3), dtype=np.float32)
        image[row, column] = 1
        map_ = EnvironmentMap.from_latlong(image, resolution=256)
        wi, _, _ = map_.sample(uniforms(2000, 2))
        center = latlong_directions(32, 64)[row, column]
        assert (wi @ center).min() > np.cos(1.6 * np.pi / 32)
        assert np.linalg.norm(wi.mean(0) - center) < 0.02


@pytest.mark.slow
def test_rotation_takes_the_map_into_the_world():
    image, to_world = sky(), rotation()
    still = EnvironmentMap.from_latlong(image, resolution=256)
    turned = EnvironmentMap.from_latlong(image, to_world=to_world, resolution=256)
    w = testing.square_to_uniform_sphere(uniforms(2000, 2))
    difference = np.abs(turned.eval(w @ to_world.T) - still.eval(w))
    assert difference.mean() < 0.01 * image.mean()
    assert np.abs(turned.eval(w) - still.eval(w)).mean() > 0.2 * image.mean()
    scaled = EnvironmentMap.from_latlong(image, to_world=3 * to_world, resolution=256)
    assert scaled.pixels == pytest.approx(turned.pixels, rel=1e-3)


@pytest.mark.mitsuba
def test_directions_are_those_of_mitsuba():
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    image, to_world = sky(128), np.eye(4)
    to_world[:3, :3] = rotation()
    emitter = mi.load_dict(
        {"type": "envmap", "bitmap": mi.Bitmap(image), "to_world": mi.ScalarTransform4f(to_world)}
    )
    map_ = EnvironmentMap.from_latlong(image, to_world=to_world[:3, :3])
    w = testing.square_to_uniform_sphere(uniforms(300, 2))
    theirs = []
    for d in w:
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(*[-float(c) for c in d])
        theirs.append(np.array(emitter.eval(si)).ravel())
    # Half a pixel apart at most: Mitsuba puts the first row's centre on the pole
    assert np.abs(map_.eval(w) - theirs).mean() < 0.01 * image.mean()


def test_a_constant_image_stays_constant():
    image = np.full((16, 32, 3), [0.5, 1, 2], dtype=np.float32)
    map_ = EnvironmentMap.from_latlong(image, scale=(2, 1, 0.5))
    assert map_.pixels == pytest.approx(np.ones(map_.pixels.shape), rel=1e-5)
    assert map_.power_ratio == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (2, 4), (4, 8), (33, 17), (64, 128)])
@pytest.mark.parametrize("resolution", [0, 16])
def test_the_power_is_that_of_the_image(shape, resolution):
    image = np.random.default_rng(9).random((*shape, 3)).astype(np.float32)
    map_ = EnvironmentMap.from_latlong(image, scale=(2, 2, 2), resolution=resolution)
    assert map_.total_power == pytest.approx(2 * latlong_power(image), rel=1e-5)
    assert abs(map_.power_ratio - 1) <= 0.02
    texels = map_.pixels.reshape(-1, 3).astype(float) @ LUMINANCE
    assert texels.mean() * 4 * np.pi == pytest.approx(map_.total_power, rel=1e-6)


SIZES = [(1, 1), (2, 4), (4, 8), (33, 17), (64, 128), (128, 256), (7, 1000), (900, 9)]


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("resolution", [0, 4, 64])
@pytest.mark.parametrize("to_world", [np.eye(3), rotation()], ids=["still", "turned"])
def test_light_in_one_pixel_keeps_its_power_wherever_it_is(shape, resolution, to_world):
    """Pixels at a pole are narrower than any look-up."""
    for row in {0, min(1, shape[0] - 1), shape[0] // 2, shape[0] - 1}:
        image = np.zeros((*shape, 3), np.float32)
        image[row, shape[1] * 2 // 3] = 1, 2, 3
        map_ = EnvironmentMap.from_latlong(image, to_world=to_world, resolution=resolution)
        assert map_.total_power == pytest.approx(latlong_power(image), rel=1e-5)
        # Look-ups that missed the light, or met it too often, would be scaled by more
        assert abs(map_.power_ratio - 1) <= 0.02


@pytest.mark.parametrize(("row", "column"), [(0, 5), (1, 90), (2, 17), (127, 200)])
@pytest.mark.parametrize("to_world", [np.eye(3), rotation()], ids=["still", "turned"])
def test_a_sun_at_a_pole_gives_the_irradiance_of_its_pixel_beside_an_even_sky(
    row, column, to_world
):
    image = np.full((128, 256, 3), 0.02, np.float32)
    image[row, column] = 3000
    map_ = EnvironmentMap.from_latlong(image, to_world=to_world)
    edges = np.cos(np.arange(129) / 128 * np.pi)
    solid_angle = (edges[:-1] - edges[1:])[:, None, None] * 2 * np.pi / 256
    d = latlong_directions(128, 256) @ to_world.T
    n = map_.resolution
    centers = (np.stack(np.meshgrid(*2 * [np.arange(n)]), -1).reshape(-1, 2) + 0.5) / n
    texels = _core.sampling.equal_area_to_direction(centers)
    for normal in (*np.eye(3), *-np.eye(3), d[row, column]):
        cos = np.maximum(d @ normal, 0)[..., None]
        want = (image * solid_angle * cos).sum((0, 1))
        got = map_.pixels.reshape(-1, 3) * np.maximum(texels @ normal, 0)[:, None]
        # The sun moves by up to a texel
        allowed = 0.005 * want + 2 * np.pi / n * latlong_power(image)
        assert (np.abs(got.sum(0) * 4 * np.pi / n**2 - want) <= allowed).all()
    away = map_.eval(-d[row, column][None])
    assert away == pytest.approx(0.02, rel=0.05)
    dark = map_.pixels[map_.pixels.max(-1) < 1]
    assert dark.mean() == pytest.approx(0.02, rel=0.005)


def test_texels_are_chosen_to_match_the_source():
    for shape, resolution in [((512, 1024), 1024), ((64, 128), 128), ((1, 1), 2)]:
        image = np.ones((*shape, 1), dtype=np.float32)
        assert EnvironmentMap.from_latlong(image).resolution == resolution


def test_one_channel_is_grey_and_a_fourth_is_ignored():
    grey = np.random.default_rng(1).random((8, 16, 1)).astype(np.float32)
    rgba = np.concatenate([np.repeat(grey, 3, 2), np.full((8, 16, 1), -1, dtype=np.float32)], 2)
    a, b = EnvironmentMap.from_latlong(grey), EnvironmentMap.from_latlong(rgba)
    assert np.array_equal(a.pixels, b.pixels)


@pytest.mark.stat
@pytest.mark.parametrize("to_world", [np.eye(3), rotation()], ids=["still", "turned"])
def test_directions_follow_their_density(to_world):
    map_ = EnvironmentMap.from_latlong(sky(), to_world=to_world)
    wi, _, _ = map_.sample(uniforms(N, 2))
    assert sphere_p_value(wi, map_.pdf, (24, 48), sub=24) >= 1e-3
    # Negative control: the density of a map whose sun stands elsewhere
    other = EnvironmentMap.from_latlong(sky()[:, ::-1].copy(), to_world=to_world)
    assert sphere_p_value(wi, other.pdf, (24, 48), sub=24) < 1e-6


@pytest.mark.stat
def test_texels_are_chosen_by_luminance_and_filled_evenly():
    map_ = EnvironmentMap.from_latlong(sky(), resolution=16)
    wi, _, _ = map_.sample(uniforms(N, 2))
    p = _core.sampling.direction_to_equal_area(wi) * 16
    column, row = np.minimum(p.astype(int), 15).T
    weights = map_.pixels.astype(float) @ LUMINANCE
    counts = np.histogram2d(row, column, 16, [(0, 16), (0, 16)])[0]
    assert p_value(counts, N * weights / weights.sum()) >= 1e-3
    assert (
        p_value(np.histogram2d(*(p % 1).T, 20, [(0, 1), (0, 1)])[0], np.full((20, 20), N / 400))
        >= 1e-3
    )


@pytest.mark.parametrize("resolution", [2, 16, 1024])
def test_a_sample_agrees_with_evaluation_in_its_direction(resolution):
    """Also where neighbours are black: a sample of density zero would poison an estimate."""
    rng = np.random.default_rng(3)
    image = (rng.random((512, 1024, 3)) < 0.02).astype(np.float32) * rng.random(
        (512, 1024, 3)
    ).astype(np.float32)
    map_ = EnvironmentMap.from_latlong(image, resolution=resolution)
    u = uniforms(100_000, 2)
    u[:4] = [[0, 0], [1 - 2**-24, 1 - 2**-24], [0, 1 - 2**-24], [1 - 2**-24, 0]]
    wi, radiance, pdf = map_.sample(u)
    assert pdf.min() > 0 and radiance.max(1).min() > 0
    assert np.array_equal(radiance, map_.eval(wi))
    np.testing.assert_allclose(pdf, map_.pdf(wi), rtol=1e-6)


def speckled(height, share):
    """Pixels of random colour, the others black, and black rows."""
    rng = np.random.default_rng(3)
    image = rng.random((height, 2 * height, 3)) * (rng.random((height, 2 * height, 1)) < share)
    image[height // 2 : height // 2 + height // 8] = 0
    return image.astype(np.float32)


@pytest.mark.parametrize("resolution, share", [(2, 1), (8, 0.5), (16, 0.1), (32, 1), (256, 0.005)])
def test_samples_are_those_of_tables_of_all_texels(resolution, share):
    """Bit for bit: the map keeps sums of blocks and adds up the block of a sample anew."""
    map_ = EnvironmentMap.from_latlong(speckled(128, share), resolution=resolution)
    weights = map_.pixels.astype(float) @ np.zeros(3)
    for c in range(3):
        weights += LUMINANCE[c] * map_.pixels[..., c].astype(float)
    u = uniforms(3000, 2).astype(np.float32)
    u[:4] = [[0, 0], [1 - 2**-24, 1 - 2**-24], [0, 1 - 2**-24], [1 - 2**-24, 0]]
    totals = np.array([np.cumsum(row)[-1] for row in weights])
    row, _, u_row = testing.Distribution1D(totals).sample(u[:, 0].astype(float))
    column, u_column = np.empty_like(row), np.empty_like(u_row)
    for y in np.unique(row):
        of_row = row == y
        found = testing.Distribution1D(weights[y]).sample(u[of_row, 1].astype(float))
        column[of_row], u_column[of_row] = found[0], found[2]
    margin = np.float32(resolution * 2**-21)
    inside = np.stack([u_column, u_row], 1).astype(np.float32).clip(margin, 1 - margin)
    place = (np.stack([column, row], 1).astype(np.float32) + inside) / np.float32(resolution)
    wi, radiance, _ = map_.sample(u)
    np.testing.assert_array_equal(wi, _core.sampling.equal_area_to_direction(place))
    np.testing.assert_array_equal(radiance, map_.pixels[row, column])


def test_the_density_is_the_share_of_luminance():
    map_ = EnvironmentMap.from_latlong(sky())
    w = testing.square_to_uniform_sphere(uniforms(5000, 2))
    assert map_.pdf(w) == pytest.approx(map_.eval(w) @ LUMINANCE / map_.total_power, rel=1e-4)
    n = map_.resolution
    centers = (np.stack(np.meshgrid(*2 * [np.arange(n)]), -1).reshape(-1, 2) + 0.5) / n
    pdf = map_.pdf(_core.sampling.equal_area_to_direction(centers))
    assert pdf.mean(dtype=float) * 4 * np.pi == pytest.approx(1, rel=1e-5)


def test_a_constant_environment_is_uniform():
    map_ = EnvironmentMap.constant((1, 2, 3))
    assert map_.is_constant and map_.resolution == 1
    wi, radiance, pdf = map_.sample(uniforms(N, 2))
    assert sphere_p_value(wi, lambda w: np.full(len(w), 1 / (4 * np.pi))) >= 1e-3
    assert (radiance == [1, 2, 3]).all() and (map_.eval(wi) == [1, 2, 3]).all()
    assert pdf == pytest.approx(1 / (4 * np.pi)) and map_.pdf(wi) == pytest.approx(1 / (4 * np.pi))
    assert map_.total_power == pytest.approx(4 * np.pi * np.array([1, 2, 3]) @ LUMINANCE)


def test_a_black_environment_can_be_sampled():
    for map_ in (
        EnvironmentMap.constant((0, 0, 0)),
        EnvironmentMap.from_latlong(np.zeros((8, 16, 3))),
    ):
        wi, radiance, pdf = map_.sample(uniforms(100, 2))
        assert map_.total_power == 0 and not radiance.any()
        assert pdf == pytest.approx(1 / (4 * np.pi)) and np.isfinite(wi).all()


def test_a_color_without_green_keeps_its_chance():
    image = np.zeros((8, 16, 3), dtype=np.float32)
    image[:, :8, 2], image[:, 8:, 1] = 1, 1
    map_ = EnvironmentMap.from_latlong(image)
    w = testing.square_to_uniform_sphere(uniforms(1000, 2))
    assert (map_.pdf(w) > 0).all()


@pytest.mark.parametrize("bad", [-1e-3, np.nan, np.inf])
def test_negative_and_non_finite_pixels_are_refused_with_their_place(bad):
    image = sky(16)
    image[3, 7, 1] = bad
    with pytest.raises(
        _core.SceneError, match=r"must be finite and >= 0, got .* in row 3, column 7"
    ):
        EnvironmentMap.from_latlong(image)
    with pytest.raises(_core.SceneError, match="must be finite and >= 0"):
        EnvironmentMap.constant((1, bad, 1))


def test_images_without_pixels_are_refused():
    with pytest.raises(_core.SceneError, match="must have pixels, got 5 x 0 x 3"):
        EnvironmentMap.from_latlong(np.zeros((0, 5, 3)))


@pytest.mark.parametrize(
    "to_world", [np.zeros((3, 3)), np.diag([1, 1, 2.0]), np.full((3, 3), np.nan)]
)
def test_transforms_that_are_no_rotation_are_refused(to_world):
    with pytest.raises(_core.SceneError, match="to_world must be a rotation"):
        EnvironmentMap.from_latlong(sky(8), to_world=to_world)


@pytest.mark.parametrize("resolution", [-2, 1, 3, 8192])
def test_resolutions_that_are_no_power_of_two_are_refused(resolution):
    with pytest.raises(_core.SceneError, match=r"power of two in \[2, 4096\], got"):
        EnvironmentMap.from_latlong(sky(8), resolution=resolution)


@pytest.mark.parametrize(
    "name",
    [
        "christmas_photo_studio_07_1k",
        "kloppenheim_05_1k",
        "potsdamer_platz_1k",
        "st_fagans_interior_1k",
        "st_peters_square_night_1k",
        "venice_sunset_1k",
    ],
)
def test_captured_environments_keep_their_power(name):
    path = SCENES / "hdr" / f"{name}.hdr"
    if not path.is_file():
        pytest.skip(f"{path.name} is not in the scenes folder (VISCACHE_SCENES)")
    image = _core.read_image(str(path))
    map_ = EnvironmentMap.from_latlong(image)
    assert map_.resolution == 1024
    assert map_.total_power == pytest.approx(latlong_power(image), rel=1e-5)
    assert abs(map_.power_ratio - 1) < 5e-3
    wi, radiance, pdf = map_.sample(uniforms(20_000, 2))
    assert np.array_equal(radiance, map_.eval(wi)) and pdf.min() > 0
    # Choosing by luminance leaves no variance in the luminance
    assert radiance @ LUMINANCE / pdf == pytest.approx(map_.total_power, rel=1e-4)


def test_the_map_is_the_same_for_any_number_of_threads():
    maps = [EnvironmentMap.from_latlong(sky(), threads=n).pixels.tobytes() for n in (1, 2, 3, 8)]
    assert len(set(maps)) == 1


GROWTH = """
import re, sys
from pathlib import Path
import numpy as np
from viscache._core.sampling import EnvironmentMap
def resident():
    return int(re.search(r"VmRSS:\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) / 1024
image = np.ones((512, 1024, 3), np.float32)
image[int(512 * float(sys.argv[1])):] = 0
for _ in range(3):  # the allocator keeps what a copy of the image took
    EnvironmentMap.from_latlong(image, resolution=16)
before = resident()
map_ = EnvironmentMap.from_latlong(image)
print(resident() - before)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="reads Linux' /proc")
def test_the_memory_of_a_sky_is_that_of_its_bright_texels():
    """The tables that samples need take a quarter of them."""

    def growth(bright):
        return float(subprocess.check_output([sys.executable, "-c", GROWTH, str(bright)]))

    texels = 1024 * 1024 * 12 / 2**20
    assert 0.95 * texels < growth(1) < 1.3 * texels
    assert growth(0.5) < 0.85 * texels
