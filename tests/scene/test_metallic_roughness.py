"""Metallic-roughness images, and images of the roughness of metals."""

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from viscache import _core as core


def waves(seed, low=20, high=250):
    """A smooth image (32, 32) of bytes."""
    x, y = np.meshgrid(np.arange(32), np.arange(32))
    wave = np.sin(x * 2 * np.pi / 16 + seed) * np.cos(y * 2 * np.pi / 32 - seed)
    return np.uint8(low + (high - low) * (wave + 1) / 2)


def test_images_of_roughness_in_pbrt_files(tmp_path):
    imsave(tmp_path / "rough.png", waves(0), check_contrast=False)

    def load(remap, kind):
        path = tmp_path / "scene.pbrt"
        path.write_text(f"""WorldBegin
        Texture "r" "float" "imagemap" "string filename" "rough.png" "float scale" 0.5
        Material "{kind}" "texture roughness" "r" "bool remaproughness" {remap}
        Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]
        WorldEnd
        """)
        return core.load_scene_file(str(path))

    for kind in ("metal", "conductor"):
        plain = load("false", kind)
        assert not plain.warnings
        assert plain.materials[0]["roughness_texture"] == 0
        assert plain.materials[0]["roughness"] == 0.5
        remapped = load("true", kind)
        assert remapped.materials[0]["roughness_texture"] == -1
        assert any("image for 'roughness'" in what for _, what in remapped.warnings)
    assert any("image for 'roughness'" in what for _, what in load("false", "plastic").warnings)


def lit_floor(integrator, spp, image=None, **look):
    """A floor that mirrors the light of a lamp outside of the picture to the camera."""
    d = vc.SceneDescription()
    pixels = {} if image is None else {"metallic_roughness_texture": d.add_image(image)}
    look |= {"base_color": (0.8, 0.4, 0.2), "specular": (0.04,) * 3} | pixels
    floor = d.add_material(core.MaterialKind.GLOSSY, coat=core.CoatKind.FRESNEL_MIX, **look)
    black = d.add_material(base_color=(0, 0, 0))
    quad = [(0, 1, 2), (0, 2, 3)]
    corners = [(-5, 0, 5), (5, 0, 5), (5, 0, -5), (-5, 0, -5)]
    d.add_mesh(corners, quad, uvs=[(0, 0), (1, 0), (1, 1), (0, 1)], material=floor)
    lamp = [(-2, 3.5, -3.5), (2, 3.5, -3.5), (2, 6, -3), (-2, 6, -3)]
    d.add_mesh(lamp, quad, material=black, emission=(6, 5, 4))
    d.set_environment((0.3, 0.3, 0.3))
    view = vc.look_at((0, 3, 6), (0, 0.5, 0), fov_deg=38)
    scene = vc.Scene.from_description(d)
    return vc.render(scene, integrator, camera=view, size=(64, 48), spp=spp).image


@pytest.mark.parametrize(
    ("integrator", "spp"),
    [(vc.Direct(), 4), (vc.Direct(environment="product"), 1), (vc.Bdpt(max_depth=3), 4)],
    ids=["mis", "product", "bdpt"],
)
def test_an_even_image_is_its_factors(integrator, spp):
    def of_image(roughness, metallic):
        pixels = np.full((32, 32, 3), [77, roughness, metallic], np.float32) / 255
        return lit_floor(integrator, spp, pixels, roughness=1, metallic=1)

    factors = lit_floor(integrator, spp, roughness=0.4**2, metallic=0.2)
    np.testing.assert_allclose(of_image(102, 51), factors, rtol=2e-3, atol=1e-5)
    # Power: another roughness, or another share of metal
    for other in (of_image(112, 51), of_image(102, 102)):
        assert np.abs(other / factors - 1).max() > 0.05
