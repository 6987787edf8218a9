"""What images show beyond their borders; transforms of texture coordinates of glTF files."""

import base64

import numpy as np
import pytest
from skimage.io import imsave

import viscache as vc
from scene.test_load_gltf import document, load, png, with_material
from scene.test_texture_mapping import albedo, pbrt_wall

PIXELS = np.random.default_rng(1).integers(30, 255, (5, 7, 3)).astype(np.uint8)
WRAPS = {"repeat": 10497, "mirror": 33648, "clamp": 33071}


def texel(u, n, wrap):
    """Indices of the nearest of n pixels."""
    i = np.floor(u * n).astype(int)
    if wrap == "clamp":
        return np.clip(i, 0, n - 1)
    i %= 2 * n if wrap == "mirror" else n
    return np.minimum(i, 2 * n - 1 - i) if wrap == "mirror" else i


def gltf_albedo(folder, wraps, transform):
    """The albedo of a square from (0, 0) to (1, 1), whose glTF coordinates are (x, 1 - y)."""
    texture = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    doc = document(
        materials=[{"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": texture}}],
        textures=[{"source": 0, "sampler": 0}],
        samplers=[{"magFilter": 9728, "wrapS": WRAPS[wraps[0]], "wrapT": WRAPS[wraps[1]]}],
        images=[{"uri": png(folder, PIXELS)}],
        extensionsUsed=["KHR_texture_transform"],
    )
    uv = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], "<f4")
    data = base64.b64decode(doc["buffers"][0]["uri"].partition(",")[2]) + uv.tobytes()
    encoded = base64.b64encode(data).decode()
    doc["buffers"] = [
        {"byteLength": len(data), "uri": "data:application/octet-stream;base64," + encoded}
    ]
    doc["bufferViews"].append({"buffer": 0, "byteOffset": 60, "byteLength": 32})
    doc["accessors"].append({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})
    attributes = {"POSITION": 0, "TEXCOORD_0": 2}
    primitive = {"attributes": attributes, "indices": 1, "material": 0}
    doc["meshes"] = [{"primitives": [primitive]}]
    scene = vc.Scene.from_description(load(folder, doc, strict=True))
    view = vc.orthographic((0.5, 0.5, 3), (0.5, 0.5, 0), height=1)
    return vc.render(
        scene, vc.AmbientOcclusion(n_samples=1), camera=view, size=(64, 64), spp=1
    ).layers["albedo"]


def expected(wraps, turn):
    """Coordinates scaled, turned counter-clockwise where v grows downwards, then moved."""
    place = (np.arange(64) + 0.5) / 64
    u, v = np.meshgrid(place, place)  # row 0 is at the top: v = 0
    x, y = 3 * u, 2 * v
    c, s = np.cos(turn), np.sin(turn)
    a, b = c * x + s * y - 0.4, -s * x + c * y + 0.3
    bytes_ = PIXELS[texel(b, 5, wraps[1]), texel(a, 7, wraps[0])] / 255
    return np.where(bytes_ <= 0.04045, bytes_ / 12.92, ((bytes_ + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("wraps", [("repeat", "repeat"), ("mirror", "clamp"), ("clamp", "mirror")])
def test_a_gltf_image_is_placed_by_its_transform(tmp_path, wraps):
    given = {"offset": [-0.4, 0.3], "rotation": 0.4, "scale": [3, 2]}
    ours = gltf_albedo(tmp_path, wraps, given)
    # Samples lie anywhere in a pixel: at the borders of texels they see either side
    same = np.isclose(ours, expected(wraps, 0.4), atol=1e-4).all(-1)
    assert same.mean() > 0.6
    for wrong in (
        expected(wraps, -0.4),
        expected(wraps, 0),
        expected((wraps[1], wraps[0]) if wraps[0] != wraps[1] else ("clamp", "clamp"), 0.4),
    ):
        assert np.isclose(ours, wrong, atol=1e-4).all(-1).mean() < 0.6 * same.mean()


def test_images_of_a_gltf_material_share_their_transform(tmp_path):
    moved = {"extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}}

    def warnings(second):
        pbr = {
            "baseColorTexture": {"index": 0} | moved,
            "metallicRoughnessTexture": {"index": 0} | second,
        }
        doc = with_material(pbrMetallicRoughness=pbr)
        doc |= {"textures": [{"source": 0}], "images": [{"uri": png(tmp_path, PIXELS)}]}
        return [what for _, what in load(tmp_path, doc).warnings]

    assert not warnings(moved)
    [text] = warnings({})
    assert "share one transform" in text


def test_pbrt_images_clamp(tmp_path):
    imsave(tmp_path / "map.png", PIXELS, check_contrast=False)
    head = '"imagemap" "string filename" "map.png" "string filter" "point" "float uscale" 4 '
    picture = albedo(pbrt_wall(tmp_path, head + '"string wrap" "clamp"'), (64, 64), spp=1)
    rows = np.delete(np.arange(64), [12, 25, 38, 51])  # those between two texels
    assert (picture[rows, :47] == picture[rows, :1]).all(), "x runs to the left in this view"
    repeated = albedo(pbrt_wall(tmp_path, head), (64, 64), spp=1)
    assert (repeated[rows, :47] != repeated[rows, :1]).any()
