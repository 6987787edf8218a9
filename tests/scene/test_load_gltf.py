"""glTF 2.0 and GLB scenes: nodes, primitives, materials, lights, cameras."""

import base64
import json

import numpy as np
import pytest
import trimesh
from skimage.io import imsave

from viscache import _core as core
from viscache_lab.parity.exporters.formats import gltf

K, C = core.MaterialKind, core.CoatKind


def document(**changes):
    """A square without material: accessor 0 has its points, 1 its indices."""
    return (
        made({"attr": {"TEXCOORD_0": ""}, "prim": {"material": None}, "materials": None}) | changes
    )


def made(change):
    return json.loads(gltf("scene", json.dumps(change))["scene.gltf"])


def load(folder, doc, strict=False):
    path = folder / "scene.gltf"
    path.write_text(json.dumps(doc))
    return core.load_scene_file(str(path), strict)


def png(folder, rgba):
    imsave(folder / "image.png", np.array(rgba, np.uint8), check_contrast=False)
    return "data:image/png;base64," + base64.b64encode((folder / "image.png").read_bytes()).decode()


def with_material(**material):
    return made({}) | {"materials": [material]}


def test_a_mesh_of_several_nodes_becomes_instances(tmp_path):
    nodes = [{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 3]}]
    scene = load(tmp_path, document(nodes=nodes, scenes=[{"nodes": [0, 1]}]), strict=True)
    assert scene.triangle_count == 4 and len(scene.meshes) == 1 and len(scene.instances) == 2
    np.testing.assert_allclose(scene.bounds(), [(-1, -1, 0), (1, 1, 3)])


def test_images_with_coordinates_of_their_own_are_means(tmp_path):
    doc = with_material(
        emissiveFactor=[1, 1, 1],
        emissiveTexture={"index": 0, "texCoord": 1},
        pbrMetallicRoughness={
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
        },
    )
    doc["textures"] = [{"source": 0}]
    doc["images"] = [{"uri": png(tmp_path, [[[255, 0, 0], [0, 255, 0]]])}]
    scene = load(tmp_path, doc)
    material = scene.materials[0]
    assert material["roughness"] == pytest.approx(0.5**2, abs=1e-3) and material["metallic"] == 0
    assert any("its mean is used" in what for _, what in scene.warnings)
    assert scene.meshes[0]["emission_texture"] == -1
    assert scene.meshes[0]["emission"] == pytest.approx([0.5, 0.5, 0])


def test_a_glb_of_trimesh_is_read_as_trimesh_reads_it(tmp_path):
    shape = trimesh.creation.torus(1, 0.3)
    shape.apply_translation([1, 2, 3])
    (tmp_path / "m.glb").write_bytes(trimesh.Scene(shape).export(file_type="glb"))
    mesh = core.load_scene_file(str(tmp_path / "m.glb")).mesh_arrays(0)
    np.testing.assert_allclose(mesh["vertices"][mesh["triangles"]], shape.triangles, atol=1e-6)


def change(doc, path, value):
    *keys, last = [int(k) if k.isdigit() else k for k in path.split(".")]
    target = doc
    for key in keys:
        target = target[key]
    target[last] = value
    return doc


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("accessors.0.count", 5, "do not fit"),
        ("accessors.0.count", 2**62, "do not fit"),
        ("accessors.0.byteOffset", 2**63, "."),
        ("accessors.0.bufferView", 7, "."),
        ("accessors.1.count", 5, "whole triangles"),
        ("accessors.0.type", "VEC2", "3 components"),
        ("bufferViews.0.byteLength", 2**40, "do not fit"),
        ("bufferViews.0.buffer", 3, "."),
        ("nodes.0.mesh", 4, "the file has 1"),
        ("nodes.0.children", [0], "its own ancestor"),
        ("nodes.0.children", [9], "the file has 1 nodes"),
        ("nodes.0.translation", [1e39, 0, 0], "vertex 0 is"),
        ("scenes.0.nodes", [3], "the file has 1 nodes"),
        ("meshes.0.primitives.0.material", 2, "the file has 0 materials"),
        ("meshes.0.primitives.0.attributes.POSITION", 9, "accessor 9"),
        ("asset.version", "1.0", "version"),
        ("extensionsRequired", ["KHR_draco_mesh_compression"], "KHR_draco"),
        ("buffers.0.uri", "gone.bin", "."),
    ],
)
def test_a_broken_reference_is_refused_and_says_what(tmp_path, path, value, message):
    with pytest.raises(core.SceneError, match=message):
        load(tmp_path, change(document(), path, value))


def test_deeply_nested_json_is_refused(tmp_path):
    text = json.dumps(document())[:-1] + ', "extras": ' + "[" * 100000 + "]" * 100000 + "}"
    (tmp_path / "deep.gltf").write_text(text)
    with pytest.raises(core.SceneError, match="nested"):
        core.load_scene_file(str(tmp_path / "deep.gltf"))


def test_a_glb_cut_anywhere_is_refused(tmp_path):
    data = gltf("whole", '{"glb": true}')["whole.glb"]
    (tmp_path / "whole.glb").write_bytes(data)
    assert core.load_scene_file(str(tmp_path / "whole.glb")).triangle_count == 2
    for cut in range(0, len(data) - 1, 37):
        (tmp_path / "cut.glb").write_bytes(data[:cut])
        with pytest.raises(core.SceneError):
            core.load_scene_file(str(tmp_path / "cut.glb"))


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_draco_mesh_compression"])
def test_a_compressed_file_is_named_as_such_before_its_buffers_are_read(tmp_path, name):
    with pytest.raises(core.SceneError, match=f"requires the extension '{name}'.*gltf-transform"):
        load(tmp_path, document(buffers=[{"byteLength": 60}], extensionsRequired=[name]))


@pytest.mark.parametrize(
    ("extension", "specular"),
    [
        ({}, [0.996] * 3),
        ({"specularColorFactor": [0, 0, 0]}, [0, 0, 0]),
        ({"specularFactor": 0.5, "specularColorFactor": [0.1, 2, 1]}, [0.0498, 0.5, 0.498]),
    ],
)
def test_ior_and_specular_belong_together(tmp_path, extension, specular):
    # What converters from specular-glossiness write: an index of 1000 and the colour of F0
    extensions = {"KHR_materials_ior": {"ior": 1000}, "KHR_materials_specular": extension}
    doc = with_material(pbrMetallicRoughness={"metallicFactor": 0}, extensions=extensions)
    doc["extensionsUsed"] = list(extensions)
    scene = load(tmp_path, doc, strict=True)
    material = scene.materials[scene.meshes[0]["material"]]
    assert material["specular"] == pytest.approx(specular, abs=1e-3)
