"""glTF: what is not read is warned of; transmission, extensions of materials."""

import re

import numpy as np
import pytest

import viscache as vc
from scene.test_load_gltf import C, K, change, document, load, png, with_material
from viscache import _core as core


@pytest.mark.parametrize(
    ("path", "value", "where", "said"),
    [
        ("extra", 1, "extra", "the property 'extra' is not read"),
        ("nodes.0.camra", 0, "nodes[0].camra", "the property 'camra' is not read"),
        ("materials.0.ior", 2, "materials[0].ior", "the property 'ior' is not read"),
        (
            "materials.0.extensions",
            {"KHR_materials_ior": {"iro": 2}},
            "materials[0].extensions.KHR_materials_ior.iro",
            "the property 'iro' is not read",
        ),
        (
            "materials.0.extensions",
            {"ACME_paint": {"a": [{"b": "}"}]}},
            "materials[0].extensions.ACME_paint",
            "the extension 'ACME_paint' is not modelled; ignored",
        ),
        (
            "materials.0.extensions",
            {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5}},
            "material 0",
            "the extension 'KHR_materials_clearcoat' is not modelled; ignored",
        ),
        (
            "meshes.0.primitives.0.attributes.COLOUR",
            0,
            "mesh 0 primitive 0 COLOUR",
            "an attribute is not read",
        ),
        (
            "meshes.0.weights",
            [0.5],
            "node 0",
            "morph targets are not modelled; the mesh without them is used",
        ),
    ],
)
def test_what_is_not_read_is_warned_of(tmp_path, path, value, where, said):
    doc = change(with_material(name="a"), path, value)
    scene = load(tmp_path, doc)
    assert scene.warnings == [(f"{tmp_path}/scene.gltf: {where}", said)]
    with pytest.raises(core.SceneError, match=re.escape(said)):
        load(tmp_path, doc, strict=True)


def test_what_leaves_the_picture_right_is_read_in_silence(tmp_path):
    off = {
        "KHR_materials_clearcoat": {"clearcoatFactor": 0, "clearcoatRoughnessFactor": 0.1},
        "KHR_materials_sheen": {"sheenColorFactor": [0, 0, 0]},
    }
    doc = with_material(name='quoted \\" {name', extras={"a": {"b": 1}}, extensions=off)
    doc["extensionsUsed"] = [*off, "ACME_unused"]
    doc["asset"] |= {"generator": "test", "extras": {"x": [1, {"y": 2}]}}
    doc["nodes"][0] |= {"name": "n", "extras": {"weights": 1}}
    doc["meshes"][0]["primitives"][0] |= {"targets": [{"POSITION": 0}], "extras": {}}
    doc["meshes"][0]["primitives"][0]["attributes"] |= {"TEXCOORD_3": 0, "_MINE": 0}
    doc["accessors"][0] |= {"min": [0, 0, 0], "max": [1, 1, 0], "normalized": False}
    doc["bufferViews"][0]["target"] = 34962
    doc["samplers"] = [{"minFilter": 9987, "name": "s"}]
    assert load(tmp_path, doc, strict=True).warnings == []


def test_a_file_of_strange_keys_has_few_warnings(tmp_path):
    doc = document(**{f"key{i}": 1 for i in range(1000)})
    warnings = load(tmp_path, doc).warnings
    assert len(warnings) == 33 and warnings[-1][1].startswith("the property is not read (968 times")


def glass(pbr=None, **extensions):
    extensions = {f"KHR_materials_{name}": value for name, value in extensions.items()}
    return with_material(
        pbrMetallicRoughness={"metallicFactor": 0, "roughnessFactor": 0} | (pbr or {}),
        extensions=extensions,
        doubleSided=True,
    )


PASSES = {"kind": K.DIELECTRIC, "thin": False, "coat": C.NONE, "eta": 1.25}
SHEET = {"kind": K.GLOSSY, "thin": True, "base_color": [0.6, 0.3, 0]}
ABSORBS = {"attenuationDistance": 1, "attenuationColor": [0.25, 1, 0]}


@pytest.mark.parametrize(
    ("share", "volume", "want", "said"),
    [
        (1, {}, PASSES | {"transmission": [1, 0.5, 0]}, ""),
        (1, ABSORBS, PASSES | {"transmission": [0.25, 0.5, 0]}, "attenuation by distance"),
        (0.4, {}, SHEET | {"transmission": [0.4, 0.2, 0]}, "does not bend it"),
    ],
)
def test_what_a_volume_lets_through_is_tinted(tmp_path, share, volume, want, said):
    doc = glass(
        {"baseColorFactor": [1, 0.5, 0, 1]},
        transmission={"transmissionFactor": share},
        volume={"thicknessFactor": 2} | volume,
        ior={"ior": 1.25},
    )
    scene = load(tmp_path, doc)
    m = scene.materials[0]
    for name, value in want.items():
        assert m[name] == (pytest.approx(value) if isinstance(value, list | float) else value)
    assert [said in text for _, text in scene.warnings] == ([True] if said else [])


@pytest.mark.parametrize(
    "integrator", [vc.Whitted(), vc.Bdpt(max_depth=3)], ids=["whitted", "bdpt"]
)
@pytest.mark.parametrize("specular", [{"specularFactor": 0}, {}])
@pytest.mark.parametrize("share", [0.4, 1])
def test_a_sheet_passes_and_reflects_what_the_formula_says(tmp_path, integrator, specular, share):
    """A sheet before a lamp, seen straight on."""
    tint = np.array([0.9, 0.5, 0.1])
    doc = glass(
        {"baseColorFactor": [*tint, 1], "roughnessFactor": 1},
        transmission={"transmissionFactor": share},
        specular=specular,
    )
    doc["materials"].append({"emissiveFactor": [1, 1, 1]})
    black = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1}
    doc["materials"][1]["pbrMetallicRoughness"] = black
    doc["meshes"].append({"primitives": [doc["meshes"][0]["primitives"][0] | {"material": 1}]})
    doc["nodes"] = [{"mesh": 0}, {"mesh": 1, "translation": [0, 0, -0.5]}]
    doc["scenes"] = [{"nodes": [0, 1]}]
    load(tmp_path, doc)
    scene = vc.load_scene(tmp_path / "scene.gltf")
    view = vc.look_at((0.5, 0.5, 4), (0.5, 0.5, 0), up=(0, 1, 0), fov_deg=2)
    seen = vc.render(scene, integrator, camera=view, size=(8, 8), spp=400).image.mean((0, 1))
    f0 = 0.04 if not specular else 0
    np.testing.assert_allclose(seen, (1 - f0) * share * tint, rtol=0.03)


@pytest.mark.parametrize(
    "name", ["KHR_materials_variants", "KHR_materials_sheen", "EXT_texture_webp"]
)
def test_a_file_that_requires_what_changes_looks_alone_loads(tmp_path, name):
    doc = document(extensionsRequired=[name], extensionsUsed=[name])
    assert load(tmp_path, doc).triangle_count == 2


def test_specular_and_glossiness_are_read(tmp_path):
    given = {
        "diffuseFactor": [0.8, 0.4, 0.2, 0.5],
        "specularFactor": [0.25, 0.5, 0.1],
        "glossinessFactor": 0.4,
    }
    doc = with_material(
        alphaMode="BLEND", extensions={"KHR_materials_pbrSpecularGlossiness": given}
    )
    m = load(tmp_path, doc, strict=True).materials[0]
    assert m["base_color"] == pytest.approx([0.4, 0.2, 0.1])
    assert m["specular"] == pytest.approx([0.25, 0.5, 0.1])
    assert m["roughness"] == pytest.approx(0.36) and m["opacity"] == 0.5 and m["metallic"] == 0


def test_images_of_a_material_share_their_transform(tmp_path):
    moved = {"extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}}

    def warnings(second):
        pbr = {
            "baseColorTexture": {"index": 0} | moved,
            "metallicRoughnessTexture": {"index": 0} | second,
        }
        doc = with_material(pbrMetallicRoughness=pbr)
        doc |= {"textures": [{"source": 0}], "images": [{"uri": png(tmp_path, [[[9, 0, 0]]])}]}
        return [what for _, what in load(tmp_path, doc).warnings]

    assert not warnings(moved)
    [text] = warnings({})
    assert "share one transform" in text
