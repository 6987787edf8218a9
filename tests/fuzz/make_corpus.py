# ruff: noqa: E501  (scene texts stay on their lines)
"""Writes `tests/fuzz/corpus`: small whole files of every format, which fuzzers start from.

Run it from the root of the repository: `PYTHONPATH=tests python tests/fuzz/make_corpus.py`. The same
files come out every time, up to the versions of zlib and Pillow.
"""

from __future__ import annotations

import io
import json
import struct
import zlib
from pathlib import Path

import numpy as np
from PIL import Image

from scene.test_malformed import PLY, PLY_BINARY, POINTS, TRIANGLE, seeds, xml

CORPUS = Path(__file__).parent / "corpus"


def picture(kind: str, mode: str = "RGB", **options: object) -> bytes:
    """8 × 6 pixels of noise by Pillow."""
    channels = len(mode)
    values = np.random.default_rng(0).integers(0, 255, (6, 8, channels), dtype=np.uint8)
    file = io.BytesIO()
    image = Image.fromarray(values[..., 0] if channels == 1 else values)
    image.save(file, kind, **options)
    return file.getvalue()


def radiance(size: str, pixels: bytes) -> bytes:
    """A Radiance picture."""
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size.encode() + b"\n" + pixels


def runs() -> bytes:
    """Two lines of 16 pixels, in runs and in single values."""
    line = b"\2\2\0\x10" + b"".join(bytes([128 + 12, 130 - c, 4, 1, 2, 3, 129]) for c in range(4))
    return radiance("-Y 2 +X 16", line + line)


def pictures() -> dict[str, bytes]:
    """By path."""
    flat = bytes(range(1, 49))
    return {
        "png/rgb.png": picture("PNG"),
        "png/rgba.png": picture("PNG", "RGBA"),
        "png/grey.png": picture("PNG", "L"),
        "png/interlaced.png": picture("PNG", bits=8, optimize=True),
        "jpg/baseline.jpg": picture("JPEG", quality=60),
        "jpg/progressive.jpg": picture("JPEG", quality=40, progressive=True),
        "jpg/grey.jpg": picture("JPEG", "L"),
        "bmp/rgb.bmp": picture("BMP"),
        "bmp/grey.bmp": picture("BMP", "L"),
        "tga/rgb.tga": picture("TGA"),
        "tga/rle.tga": picture("TGA", "RGBA", compression="tga_rle"),
        "tga/grey.tga": picture("TGA", "L"),
        "hdr/runs.hdr": runs(),
        "hdr/flat.hdr": radiance("-Y 3 +X 4", flat),
        "hdr/turned.hdr": radiance("+X 4 +Y 3", flat),
        "hdr/old_runs.hdr": radiance("-Y 3 +X 4", b"abcd\1\1\1\3" * 3),
    }


MTL = b"""newmtl a
Kd 0.5 0.4 0.3
Ks 0.1 0.1 0.1
Ns 20
d 1
map_Kd rgb.png
map_d rgba.png
Ke 1 1 1
newmtl b
illum 5
Ni 1.5
Tr 0.5
Tf 1 1 1
Pr 0.3
Pm 1
map_Kd -s 2 2 2 -clamp on baseline.jpg
"""

PBRT = b"""LookAt 0 0 5 0 0 0 0 1 0
Camera "perspective" "float fov" [40] "float screenwindow" [-1 1 -1 1]
Film "image" "integer xresolution" [64] "integer yresolution" [48]
WorldBegin
Texture "t" "spectrum" "imagemap" "string filename" "rgb.png"
Texture "c" "spectrum" "checkerboard" "rgb tex1" [1 1 1] "rgb tex2" [0 0 0]
MakeNamedMaterial "m" "string type" "matte" "texture Kd" "t"
NamedMaterial "m"
AttributeBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Translate 0 2 0
Shape "sphere" "float radius" [0.5] "float zmin" -0.2
AttributeEnd
LightSource "infinite" "rgb L" [1 1 1]
LightSource "point" "blackbody I" [3000 1] "point from" [0 1 0]
LightSource "spot" "point from" [0 1 0] "point to" [0 0 0]
LightSource "distant" "spectrum L" [400 1 700 2]
ObjectBegin "o"
Material "glass" "float index" 1.5
Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 0 0 1 0 0 0 1 0] "float uv" [0 0 1 0 0 1]
Shape "disk" "float height" 1
Shape "cylinder"
Shape "cone"
Shape "paraboloid"
ObjectEnd
Rotate 30 0 1 0
ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]
ObjectInstance "o"
WorldEnd
"""

XML = (
    '<default name="a" value="0.5"/><integrator type="path"/>'
    '<bsdf type="dielectric" id="g"><float name="int_ior" value="1.5"/></bsdf>'
    '<bsdf type="roughconductor" id="c"><string name="material" value="Au"/><float name="alpha" value="0.1"/></bsdf>'
    '<bsdf type="mask" id="k"><float name="opacity" value="0.5"/><bsdf type="plastic"/></bsdf>'
    '<bsdf type="diffuse" id="t"><texture type="checkerboard" name="reflectance"><transform name="to_uv">'
    '<scale x="2" y="2"/></transform></texture></bsdf>'
    '<shape type="cube"><ref id="t"/><transform name="to_world"><translate x="$a"/><rotate y="1" angle="9"/></transform></shape>'
    '<shape type="rectangle"><ref id="c"/><emitter type="area"><rgb name="radiance" value="1 2 3"/></emitter></shape>'
    '<shape type="disk"><ref id="k"/></shape><shape type="cylinder"><ref id="g"/><point name="p0" x="1"/></shape>'
    '<shape type="shapegroup" id="s"><shape type="sphere"/></shape><shape type="instance"><ref id="s"/></shape>'
    '<emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/><blackbody name="irradiance" temperature="4000"/></emitter>'
    '<emitter type="spot"/><emitter type="constant"><spectrum name="radiance" value="0.5"/></emitter>'
    '<sensor type="thinlens"><film type="hdrfilm"><integer name="width" value="32"/><integer name="crop_width" value="8"/></film></sensor>'
)


def gltf_of(text: bytes) -> bytes:
    """The same scene with textures, a mask and a light."""
    scene = json.loads(text)
    scene["materials"][0]["pbrMetallicRoughness"] |= {"baseColorTexture": {"index": 0}}
    scene["textures"], scene["images"] = [{"source": 0}], [{"uri": "rgb.png"}]
    light = {"type": "spot", "intensity": 3, "spot": {"outerConeAngle": 0.5}}
    scene["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    scene["nodes"][1]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    return json.dumps(scene).encode()


def glb_of(text: bytes) -> bytes:
    """A GLB file of a scene whose bytes lie in its second chunk."""
    scene = json.loads(text)
    blob = POINTS + struct.pack("<3H", 0, 1, 2) + b"\0\0"
    scene["buffers"] = [{"byteLength": len(blob)}]
    head = json.dumps(scene).encode()
    head += b" " * (-len(head) % 4)
    chunks = struct.pack("<I", len(head)) + b"JSON" + head
    chunks += struct.pack("<I", len(blob)) + b"BIN\0" + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def serialized() -> bytes:
    """Two shapes in double precision with normals, texture coordinates and colours."""
    shapes, starts = b"", []
    for flags, kind in ((0x2000 | 1 | 2 | 8, "d"), (0x1000 | 1, "f")):
        count = 3 + 3 * (flags & 1) + (2 if flags & 2 else 0) + (3 if flags & 8 else 0)
        body = struct.pack("<I", flags) + b"name\0" + struct.pack("<QQ", 3, 1)
        body += struct.pack(f"<{3 * count}{kind}", *np.linspace(0, 1, 3 * count) ** 2)
        starts.append(len(shapes))
        shapes += b"\x1c\x04\x04\x00" + zlib.compress(body + struct.pack("<3I", 0, 1, 2))
    return shapes + struct.pack(f"<{len(starts)}Q", *starts) + struct.pack("<I", len(starts))


def scenes() -> dict[str, bytes]:
    """By path."""
    known = {
        name.partition(".")[2] + "/small." + name.partition(".")[2]: content
        for name, content in seeds().items()
    }
    polygon = PLY.replace("vertex 3", "vertex 4").replace("face 1", "face 2")
    return known | {
        "ply/polygons.ply": (polygon + "0 0 0 1 0 0 0 1 0 1 1 0\n4 0 1 3 2\n3 0 1 2\n").encode(),
        "ply/ascii.ply": (PLY + "0 0 0 1 0 0 0 1 0\n3 0 1 2\n").encode(),
        "ply/normals.ply": PLY_BINARY.replace(
            b"property float z\n",
            b"property float z\n"
            + b"".join(b"property float %s\n" % n for n in (b"nx", b"ny", b"nz", b"u", b"v")),
        )
        + struct.pack("<24f", *np.linspace(0, 1, 24) ** 2)
        + struct.pack("<B3i", 3, 0, 1, 2),
        "obj/groups.obj": (
            TRIANGLE + "g a\no b\ns 1\nusemtl x\nvt 0 0\nf 1/1 2/1 3/1\nf -3 -2 -1\nl 1 2\np 1\n"
        ).encode(),
        "mtl/materials.mtl": MTL,
        "pbrt/many.pbrt": PBRT,
        "xml/many.xml": xml(XML).encode(),
        "gltf/textured.gltf": gltf_of(seeds()["f.gltf"]),
        "glb/chunks.glb": glb_of(seeds()["f.gltf"]),
        "serialized/shapes.serialized": serialized(),
    }


if __name__ == "__main__":
    for path, content in (pictures() | scenes()).items():
        (CORPUS / path).parent.mkdir(parents=True, exist_ok=True)
        (CORPUS / path).write_bytes(content)
