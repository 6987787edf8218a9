"""render/relighting.h and viscache.Relighting: an image under any light, without rays."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core
from viscache._core import sampling
from viscache.vismap.relighting import reduced, rotation
from vismap.scenes import SIZE, made, view

SKY = np.random.default_rng(3).gamma(0.5, size=(32, 64, 3)).astype(np.float32)


@pytest.fixture(scope="module")
def image():
    cache, _ = made()
    return vc.Relighting(cache, camera=view(), size=SIZE)


def eye_points(scene, threads=1):
    frame = _core.FrameSettings()
    frame.width, frame.height = SIZE
    frame.threads = threads
    integrator = vc.Direct(centred=True).core()  # no mirrors in the scene
    found = _core.trace_eye_points(scene._core, scene.caster(), view(), integrator, frame)
    return {name: np.asarray(value) for name, value in found.items()}


def middles(edge):
    """(edge², 2): middles of the cells of the square, in Z order."""
    at = (np.stack(np.meshgrid(*[np.arange(edge)] * 2), -1).reshape(-1, 2) + 0.5) / edge
    ordered = np.empty_like(at)
    ordered[_core.vismap.morton2(*(at * edge).astype(np.uint32).T)] = at
    return ordered.astype(np.float32)


def test_what_light_is_multiplied_with_is_reflection_times_the_blended_maps(image):
    """B̃·Ṽ by NumPy from a look-up at the eye points."""
    eyes, cache = eye_points(image.cache.scene), image.cache
    reach = cache._pixels(view(), *SIZE, (0.5, 0.5), 1)[0].d_max
    m = cache.settings.m
    quarters = sampling.equal_area_to_direction(middles(2 << m)).reshape(-1, 4, 3)
    cells = sampling.equal_area_to_direction(middles(1 << m))
    checked = 0
    for i in range(0, len(eyes["pixel"]), 97):
        # Numbers of eye points follow a curve, pixels the rows
        pixel, normal = int(eyes["pixel"][i]), eyes["normal"][i]
        found = cache.lookup(eyes["position"][i][None], normal[None], reach[pixel])
        visible = cache.visibility(found, cells)[0]
        cosine = np.maximum(quarters @ normal, 0).mean(axis=1)
        expected = 0.5 / np.pi * cosine * visible
        transfer = image._core.transfer(pixel)
        np.testing.assert_allclose(transfer, expected[:, None].repeat(3, axis=1), atol=2e-6)
        checked += bool(visible.any())
    assert checked > 5


def test_a_turned_light_gives_the_sum_over_its_cells_and_no_ray(image):
    camera_rays = image._core.camera_rays
    for degrees in (0.0, 37.0, 180.0):
        light = image.light(SKY, rotation_deg=degrees)
        found = image._core.image(light)
        for pixel in (0, 700, 901, SIZE[0] * SIZE[1] - 1):
            expected = np.einsum("kc,ck->c", image._core.transfer(pixel), light)
            np.testing.assert_allclose(
                found.reshape(-1, 3)[pixel], expected, rtol=1e-12, atol=1e-15
            )
        assert image.under(SKY, rotation_deg=degrees).counters["rays"] == 0
    assert image._core.rays == 0 and image._core.camera_rays == camera_rays > 0


def test_the_image_is_the_same_for_any_number_of_threads(image):
    light = image.light(SKY)
    pictures = {image._core.image(light, n).tobytes() for n in (1, 2, 3, 8)}
    traced = {
        vc.Relighting(image.cache, camera=view(), size=SIZE, update=False, threads=n)
        ._core.image(light)
        .tobytes()
        for n in (1, 2, 3)
    }
    assert len(pictures) == 1 and traced == pictures


def test_a_light_keeps_its_power_and_turns_with_its_image(image):
    edges = np.cos(np.arange(33) / 32 * np.pi)
    power = (SKY.astype(float).sum(axis=1) * (edges[:-1] - edges[1:])[:, None]).sum(axis=0)
    light = image.light(SKY)
    assert light.sum(axis=1) @ [0.2126, 0.7152, 0.0722] == pytest.approx(
        float(power @ [0.2126, 0.7152, 0.0722]) * 2 * np.pi / 64, rel=1e-5
    )
    # A quarter turn is a roll of the image by a quarter
    rolls = [np.roll(SKY, shift, axis=1) for shift in (16, -16)]
    turned = image.light(SKY, rotation_deg=90)
    assert min(float(abs(image.light(r) - turned).max()) for r in rolls) < 1e-3 * turned.max()
    np.testing.assert_allclose(image.light(SKY, rotation_deg=360), light, rtol=1e-5, atol=1e-7)
    assert image.light(0.5).sum(axis=1) == pytest.approx([2 * np.pi] * 3)


def test_the_preview_comes_near_the_exact_image():
    """Biased by the maps' resolution; a light from the wrong side is farther off."""
    cache, _ = made(size=(96, 64))
    evening = np.full_like(SKY, 0.1)
    evening[10:16, 8:16] = 5
    many = vc.Direct(n_environment=64, n_brdf=64)
    exact = vc.render(cache.scene, many, env=evening, camera=view(), size=(96, 64), spp=4)
    image = vc.Relighting(cache, camera=view(), size=(96, 64))
    # What the camera sees of the light itself is not part of J
    truth = exact.layers["environment"]
    error = {
        degrees: float(
            abs(image.under(evening, rotation_deg=degrees).image - truth).sum() / truth.sum()
        )
        for degrees in (0.0, 180.0)
    }
    assert error[0.0] < 0.2 and error[180.0] > 0.5, error


def test_a_large_image_is_reduced_without_losing_light():
    tall = np.random.default_rng(5).random((1024, 2048, 3)).astype(np.float32)
    small = reduced(tall)
    assert small.shape == (256, 512, 3)

    def power(pixels):
        edges = np.cos(np.arange(len(pixels) + 1) / len(pixels) * np.pi)
        rows = pixels.astype(float).mean(axis=1) * (edges[:-1] - edges[1:])[:, None]
        return np.asarray(rows.sum(axis=0))

    np.testing.assert_allclose(power(small), power(tall), rtol=1e-6)
    assert reduced(SKY) is not None and reduced(SKY).shape == SKY.shape
    np.testing.assert_allclose(rotation(30) @ rotation(30).T, np.eye(3), atol=1e-15)


def test_what_cannot_be_used_is_refused(image):
    with pytest.raises(ValueError, match="rotation_deg must be a finite number"):
        image.under(SKY, rotation_deg=float("nan"))
    with pytest.raises(ValueError, match="env must be"):
        image.under(np.ones((4, 4)))
    for shape in ((0, 4, 3), (4, 0, 3), (0, 0, 3)):
        with pytest.raises(ValueError, match=r"env must have at least one pixel, of shape, got"):
            image.under(np.zeros(shape, np.float32))
    with pytest.raises(ValueError, match="light must have shape"):
        image._core.image(np.ones((3, 5)))
    with pytest.raises(ValueError, match="cache must be a VisibilityMapCache"):
        vc.Relighting(image.cache.scene)  # type: ignore[arg-type]
    ambient = vc.VisibilityMapCache(image.cache.scene, vc.MapSettings(criterion="ambient"))
    with pytest.raises(ValueError, match='criterion must be "visibility"'):
        vc.Relighting(ambient, camera=view(), size=SIZE)
