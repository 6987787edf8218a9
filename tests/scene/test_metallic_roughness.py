"""Metallic-roughness images: of glTF files, of arrays, and images of the roughness of metals."""

import base64
import json

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from scene.test_mitsuba_parity import VIEW
from viscache import _core as core

SIZE = (64, 48)

#: A floor, and a lamp outside of the picture whose light the floor mirrors to the camera.
FLOOR = np.array([(-5, 0, 5), (5, 0, 5), (5, 0, -5), (-5, 0, -5)], "<f4")
LAMP = np.array([(-2, 3.5, -3.5), (2, 3.5, -3.5), (2, 6, -3), (-2, 6, -3)], "<f4")
UV = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], "<f4")
RADIANCE = (6.0, 5.0, 4.0)


def waves(seed, low=20, high=250):
    """A smooth image (32, 32) of bytes."""
    x, y = np.meshgrid(np.arange(32), np.arange(32))
    wave = np.sin(x * 2 * np.pi / 16 + seed) * np.cos(y * 2 * np.pi / 32 - seed)
    return np.uint8(low + (high - low) * (wave + 1) / 2)


def uri(folder, name, pixels):
    imsave(folder / name, pixels, check_contrast=False)
    return {"uri": name}


def document(folder, pbr, images, **more):
    """A glTF file of the floor with a material, and of the lamp."""
    data = b"".join(a.tobytes() for a in (FLOOR, LAMP, UV))
    data += np.array([0, 1, 2, 0, 2, 3], "<u2").tobytes()
    views = [(0, 48), (48, 48), (96, 32), (128, 12)]
    kinds = [(5126, 4, "VEC3"), (5126, 4, "VEC3"), (5126, 4, "VEC2"), (5123, 6, "SCALAR")]
    black = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1, "roughnessFactor": 1}
    doc = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": o, "byteLength": n} for o, n in views],
        "accessors": [
            {"bufferView": i, "componentType": c, "count": n, "type": t}
            for i, (c, n, t) in enumerate(kinds)
        ],
        "materials": [
            {"pbrMetallicRoughness": pbr, "doubleSided": True},
            {
                "pbrMetallicRoughness": black,
                "emissiveFactor": [v / max(RADIANCE) for v in RADIANCE],
                "extensions": {
                    "KHR_materials_emissive_strength": {"emissiveStrength": max(RADIANCE)}
                },
            },
        ],
        "images": [uri(folder, f"{i}.png", image) for i, image in enumerate(images)],
        "textures": [{"source": i} for i in range(len(images))],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": i, "TEXCOORD_0": 2}, "indices": 3, "material": i}
                    for i in (0, 1)
                ]
            }
        ],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    } | more
    path = folder / "scene.gltf"
    path.write_text(json.dumps(doc))
    return path


def camera(folder):
    path = folder / "view.xml"
    path.write_text(f'<scene version="3.0.0">{VIEW}<shape type="cube"/></scene>')
    return vc.load_scene(path).cameras[0]


def packed(roughness, metallic):
    """The channels of glTF. Red means nothing."""
    r, m = np.broadcast_arrays(
        np.asarray(roughness, np.uint8), np.asarray(metallic, np.uint8), np.zeros((32, 32))
    )[:2]
    return np.stack([np.full((32, 32), 77, np.uint8), r, m], -1)


def picture(path, integrator=None, spp=4):
    scene, view = vc.load_scene(path, strict=True, env=0.3), camera(path.parent)
    return vc.render(scene, integrator or vc.Direct(), camera=view, size=SIZE, spp=spp).image


def test_the_image_is_kept_with_its_eight_bits(tmp_path):
    pbr = {
        "baseColorFactor": [0.8, 0.4, 0.2, 1],
        "metallicFactor": 0.75,
        "roughnessFactor": 0.5,
        "metallicRoughnessTexture": {"index": 0},
    }
    scene = core.load_scene_file(str(document(tmp_path, pbr, [packed(waves(0), waves(1))])), True)
    m = scene.materials[0]
    assert m["metallic_roughness_texture"] == 0 and m["metallic"] == 0.75
    assert m["roughness"] == 0.25 and m["base_color"] == pytest.approx([0.8, 0.4, 0.2])
    assert m["specular"] == pytest.approx([0.04] * 3)
    assert scene.images[0]["bits"] == 8 and not scene.images[0]["srgb"]


def test_an_image_with_its_own_coordinates_is_a_mean(tmp_path):
    pbr = {
        "baseColorTexture": {"index": 1},
        "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
    }
    path = document(tmp_path, pbr, [packed(51, 102), packed(9, 9)])
    scene = core.load_scene_file(str(path))
    assert [what for _, what in scene.warnings if "its means are used" in what]
    m = scene.materials[0]
    assert m["metallic_roughness_texture"] == -1
    assert m["roughness"] == pytest.approx(0.2**2) and m["metallic"] == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("integrator", "spp"),
    [(vc.Direct(), 4), (vc.Direct(environment="product"), 1), (vc.Bdpt(max_depth=3), 4)],
    ids=["mis", "product", "bdpt"],
)
def test_an_even_image_is_its_factors(tmp_path, integrator, spp):
    base = {"baseColorFactor": [0.8, 0.4, 0.2, 1]}

    def of(name, pbr, images):
        folder = tmp_path / name
        folder.mkdir()
        return picture(document(folder, base | pbr, images), integrator, spp)

    image = {"metallicRoughnessTexture": {"index": 0}}
    even = of("image", image, [packed(102, 51)])
    factors = of("factors", {"metallicFactor": 0.2, "roughnessFactor": 0.4}, [])
    np.testing.assert_allclose(even, factors, rtol=2e-3, atol=1e-5)
    other = of("other", image, [packed(112, 51)])
    assert np.abs(other / factors - 1).max() > 0.05, "another roughness would pass"
    metal = of("metal", image, [packed(102, 102)])
    assert np.abs(metal / factors - 1).max() > 0.05, "another share of metal would pass"


def test_an_image_changes_the_surface_from_place_to_place(tmp_path):
    """One half of the floor is a metal, the other is not: each is as if the whole floor was."""
    base = {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicRoughnessTexture": {"index": 0}}

    def of(name, roughness, metallic):
        folder = tmp_path / name
        folder.mkdir()
        image = packed(roughness, metallic)
        return picture(document(folder, base, [image]))

    left = np.arange(32) < 16
    half = of("half", np.where(left, 60, 160), np.where(left, 255, 0))
    metal, plain = of("metal", 60, 255), of("plain", 160, 0)
    # The camera looks along the border; the pixels there show both, as do those at the far sides
    np.testing.assert_allclose(half[20:, 4:28], metal[20:, 4:28], rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(half[20:, 36:60], plain[20:, 36:60], rtol=1e-3, atol=1e-5)
    assert np.abs(metal - plain)[20:].max() > 0.1


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


def test_a_metal_with_an_image_of_its_color_shows_it(tmp_path):
    pbr = {"metallicFactor": 1, "roughnessFactor": 0.5, "baseColorTexture": {"index": 0}}
    color = np.zeros((32, 32, 3), np.uint8)
    color[:, :16], color[:, 16:] = (255, 20, 20), (20, 20, 255)
    seen = picture(document(tmp_path, pbr, [color]), None, 16)
    assert seen[24:, 4:28, 0].mean() > 3 * seen[24:, 4:28, 2].mean()
    assert seen[24:, 36:60, 2].mean() > 3 * seen[24:, 36:60, 0].mean()
