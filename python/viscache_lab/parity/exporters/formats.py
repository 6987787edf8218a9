"""The template of each format: a quad over [-1, 1]² that faces +z, and what changes it."""

from __future__ import annotations

import base64
import io
import json
import re
import struct
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

#: sRGB bytes of the corners of `quad.png`: top left, top right, bottom left, bottom right.
CORNERS = {"A": (230, 150, 120), "B": (120, 230, 150), "C": (150, 120, 230), "D": (210, 210, 120)}
#: Its sides in pixels, so many that the seams between corners count for little.
SIDE_PX = 256

Files = dict[str, bytes]


def pictures() -> Files:
    """Pictures that the files name: colours, holes on the right, two masks, metal and roughness."""
    opaque = {name: (*color, 255) for name, color in CORNERS.items()}
    holes = {name: (*color[:3], 255 * (name in "AC")) for name, color in opaque.items()}
    half = {name: (*color[:3], 102) for name, color in opaque.items()}
    kinds: dict[str, Mapping[str, Any]] = {
        "quad.png": CORNERS,
        "holes.png": holes,
        "half.png": half,
        "mask.png": {"A": 255, "B": 0, "C": 255, "D": 0},
        "grey.png": {"A": 128, "B": 128, "C": 128, "D": 128},
        # Green is roughness, blue is metal
        "metal.png": {"A": (0, 255, 255), "B": (0, 255, 0), "C": (0, 0, 255), "D": (0, 255, 255)},
        "flat.png": {name: (128, 128, 255) for name in "ABCD"},
    }
    found = {name: _png(cells) for name, cells in kinds.items()}
    aliases = ("tex/quad.png", "my quad.png", "quad (1).png")
    found |= {alias: found["quad.png"] for alias in aliases}
    found |= ply("quad", "le; vertex 4 float x, float y, float z, float u, float v; $F")
    return found | {"quad.pbrt": _filled("$QUAD\n", PBRT).encode()}


def _png(cells: Mapping[str, Any]) -> bytes:
    from PIL import Image

    four = np.array([[cells["A"], cells["B"]], [cells["C"], cells["D"]]], np.uint8)
    buffer = io.BytesIO()
    large = four.repeat(SIDE_PX // 2, axis=0).repeat(SIDE_PX // 2, axis=1)
    Image.fromarray(large).save(buffer, "PNG")
    return buffer.getvalue()


#: What the text of a file may begin with, in braces, and what it does to the text.
EDITS: dict[str, Callable[[str], str]] = {
    "crlf": lambda text: text.replace("\n", "\r\n"),
    "cr": lambda text: text.replace("\n", "\r"),
    "bom": lambda text: "\ufeff" + text,
    "cut": lambda text: text.rstrip("\n"),
}


def _edited(change: str) -> tuple[str, Callable[[str], bytes]]:
    """The change without its edits, and what makes bytes of a text."""
    edits = re.match(r"(\{\w+\})*", change)[0]  # type: ignore[index]

    def made(text: str) -> bytes:
        for name in re.findall(r"\w+", edits):
            text = EDITS[name](text)
        return text.encode()

    return change[len(edits) :], made


def _filled(text: str, macros: Mapping[str, str]) -> str:
    """A text with its macros, of which later ones may stand in earlier ones, and escapes."""
    for name, value in macros.items():
        text = text.replace(name, value)
    return re.sub(r"\\(.)", lambda found: {"t": "\t", "n": "\n"}.get(found[1], found[1]), text)


#: Lines of the quad.
OBJ = {
    "$V": "v -1 -1 0;v 1 -1 0;v 1 1 0;v -1 1 0",
    "$T": "vt 0 0;vt 1 0;vt 1 1;vt 0 1",
    "$N": "vn 0 0 1",
    "$F": "f 1/1/1 2/2/1 3/3/1 4/4/1",
}


def obj(stem: str, change: str) -> Files:
    """Lines of the MTL file, `;` between them; after `@` the lines of the OBJ file, if others."""
    change, made = _edited(change)
    mtl, _, body = change.partition("@")
    if mtl and "newmtl" not in mtl:
        mtl = f"newmtl a;{mtl}"
    macros = {"$M": f"mtllib {stem}.mtl"} | OBJ
    texts = {"obj": body or "$M;$V;$T;$N;usemtl a;$F"} | ({"mtl": mtl} if mtl else {})
    return {
        f"{stem}.{suffix}": made(_filled(text.replace(";", "\n"), macros).replace(";", "\n") + "\n")
        for suffix, text in texts.items()
    }


#: Names of PLY's types that NumPy has for others, or not.
PLY_TYPES = {"char": "int8", "uchar": "uint8", "int": "int32", "uint": "uint32", "float": "float32"}
#: Values of the quad's vertices by property.
PLY_VALUES = {"x": "-1/1/1/-1", "y": "-1/-1/1/1"} | {
    name: "0/1/1/0" if name[-1] in "us" else "0/0/1/1"
    for name in ("u", "v", "s", "t", "texture_u", "texture_v")
}
PLY = {
    "$P": "vertex 4 float x, float y, float z",
    "$F": "face 2 $I",
    "$I": "list uchar int vertex_indices 0 1 2/0 2 3",
}


def ply(stem: str, change: str) -> Files:
    """`ascii`, `le` or `be`; then after each `;` a comment, an element or `s/old/new`.

    An element has a name, a count and properties; a property may end with its values, `/` between
    rows.
    """
    change, made = _edited(change)
    kind, *parts = [part.lstrip(" ") for part in _filled(change, PLY).split(";")]
    form = {"le": "binary_little_endian", "be": "binary_big_endian"}.get(kind, kind)
    head, data = ["ply", f"format {form} 1.0"], b""
    edits: list[tuple[str, ...]] = []
    for part in parts:
        if part.startswith("s/"):
            edits.append(tuple(part.split("/")[1:3]))
        elif part.startswith(("comment", "obj_info")):
            head.append(part)
        else:
            data += _ply_element(part, {"le": "<", "be": ">"}.get(kind, ""), head)
    text = "\n".join([*head, "end_header", ""]) + (data.decode() if kind == "ascii" else "")
    for old, new in edits:
        text = text.replace(old, new, 1)
    return {f"{stem}.ply": made(text) + (b"" if kind == "ascii" else data)}


def _ply_element(part: str, order: str, head: list[str]) -> bytes:
    name, count, properties = part.split(maxsplit=2)
    head.append(f"element {name} {count}")
    columns = []
    for words in (given.split() for given in properties.split(",")):
        size = 4 if words[0] == "list" else 2
        head.append(" ".join(["property", *words[:size]]))
        values = " ".join(words[size:]) or PLY_VALUES.get(words[size - 1], "0")
        columns.append((words[: size - 1], [row.split() for row in values.split("/")]))
    data = b""
    for i in range(int(count)):
        row: list[tuple[str, str]] = []
        for types, rows in columns:
            here = rows[i % len(rows)]
            row += [(types[1], str(len(here)))] if types[0] == "list" else []
            row += [(types[-1], value) for value in here]
        if order:
            for name, value in row:
                code = np.dtype(PLY_TYPES.get(name, name)).str[1:]
                data += np.array([float(value)]).astype(order + code).tobytes()
        else:
            data += (" ".join(value for _, value in row) + "\n").encode()
    return data


#: `$P` is the quad without texture coordinates, `$DOWN` a lamp's quad at z = 2.
PBRT = {
    "$QUAD": 'Shape "trianglemesh" $P "point2 uv" [0 0 1 0 1 1 0 1]',
    "$P": '"point3 P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] $I',
    "$DOWN": 'Shape "trianglemesh" "point3 P" [-1 1 2 1 1 2 1 -1 2 -1 -1 2] $I',
    "$IMG": '"spectrum" "imagemap" "string filename" "quad.png"',
    "$I": '"integer indices" [0 1 2 0 2 3]',
    "$VIEW": "LookAt 0 0 2 0 0 0 0 1 0",
    "$CAMERA": 'Camera "perspective" "float fov" 53.130102',
}


def pbrt(stem: str, change: str, version: str) -> Files:
    """What stands in the world; before `@`, what stands before it. `$M` is a grey material."""
    change, made = _edited(change)
    head, _, world = change.rpartition("@")
    film, kind, colour = (
        ("rgb", "diffuse", "reflectance") if version == "4" else ("image", "matte", "Kd")
    )
    macros = {
        "$FILM": f'Film "{film}" "integer xresolution" 16 "integer yresolution" 16',
        "$TEX2": '$TEX3 Shape "trianglemesh" $P',
        "$TEX3": f'Material "{kind}" "texture {colour}" "t"',
        "$TEX": f'Material "{kind}" "texture {colour}" "t" $QUAD',
        "$M": f'Material "{kind}" "rgb {colour}"',
        "$G": f'Material "{kind}" "rgb {colour}" [.5 .5 .5]\n$QUAD\n',
    }
    text = f"{head or '$VIEW $CAMERA $FILM'}\nWorldBegin\n{world}\n"
    return {f"{stem}.pbrt": made(_filled(text + "WorldEnd\n" * (version == "3"), macros | PBRT))}


#: glTF's component types, by those of NumPy.
COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
ATTRIBUTES = {"POSITION": "f4x3 -1 -1 0 1 -1 0 1 1 0 -1 1 0", "TEXCOORD_0": "f4x2 0 1 1 1 1 0 0 0"}
#: Diffuse alone: by glTF's formula, no light is reflected by a surface of specular factor 0.
MATERIAL: dict[str, Any] = {
    "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0},
    "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
    "doubleSided": True,
}


class _Data:
    """The bytes of a glTF file, with their views and accessors."""

    def __init__(self) -> None:
        self.bytes = b""
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, block: bytes, more: dict[str, Any]) -> int:
        place = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(block)}
        self.views.append(place | more)
        self.bytes += block + bytes(-len(block) % 4)
        return len(self.views) - 1

    def accessor(self, text: str, stride: int = 0) -> int:
        """Type, `n` if normalized, `x` and components of a vector; the values, or those of one."""
        kind, *numbers = text.split()
        code, size = kind[:2], int(kind.partition("x")[2] or 1)
        rows = np.array([float(x) for x in numbers]).reshape(-1, size)
        rows = rows.repeat(4, axis=0) if size > 1 and len(rows) == 1 else rows
        packed = [row.astype(f"<{code}").tobytes() for row in rows]
        # Vertices are aligned to four bytes
        pitch = stride or len(packed[0]) + (-len(packed[0]) % 4 if size > 1 else 0)
        block = b"".join(row.ljust(pitch, b"\x7f") for row in packed)
        found = {
            "bufferView": self.view(block, {"byteStride": pitch} if size > 1 else {}),
            "componentType": COMPONENTS[code],
            "count": len(rows),
            "type": f"VEC{size}" if size > 1 else "SCALAR",
        }
        self.accessors.append(found | ({"normalized": True} if kind[2:3] == "n" else {}))
        return len(self.accessors) - 1


def gltf(stem: str, change: str) -> Files:
    """JSON that is merged into the file; null takes a value away.

    Short names: `pbr`, `mat`, `ext` of the material, `white` its base colour; `attr`, `idx`, `prim`
    of the primitive, `more` accessors, `stride` of the positions; `node`; an image `tex` at `as`
    with `info` and `sampler`, `embed` in the buffer; `camera` or `light` of a node `eye`; `glb`.
    """
    change, made = _edited(change)
    given: dict[str, Any] = json.loads(change or "{}")
    stride, indices = given.pop("stride", 0), given.pop("idx", "u2 0 1 2 0 2 3")
    binary, base = given.pop("glb", False), given.pop("pbr", {})
    extensions, used = given.pop("ext", {}), given.pop("used", [])
    data = _Data()
    attributes = {
        name: data.accessor(text, stride if name == "POSITION" else 0)
        for name, text in (ATTRIBUTES | given.pop("attr", {})).items()
        if text
    }
    primitive = {"attributes": attributes, "material": 0}
    if indices:
        primitive["indices"] = data.accessor(indices)
    for text in given.pop("more", {}):
        data.accessor(text)
    if given.pop("white", False):
        base = {"baseColorFactor": [1, 1, 1, 1]} | base
    material = {"pbrMetallicRoughness": base, "extensions": extensions}
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [_merged({"mesh": 0}, given.pop("node", {}))],
        "meshes": [{"primitives": [_merged(primitive, given.pop("prim", {}))]}],
        "materials": [_merged(_merged(MATERIAL, material), given.pop("mat", {}))],
        "accessors": data.accessors,
        "bufferViews": data.views,
        "extensionsUsed": ["KHR_materials_specular", *extensions, *used],
    }
    if "tex" in given:
        _add_image(document, given, data)
    eye = {"translation": [0, 0, 2]} | given.pop("eye", {})
    for kind in {"camera", "light"} & set(given):
        _add_node(document, kind, given.pop(kind), eye)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data.bytes).decode()
    document["buffers"] = [{"byteLength": len(data.bytes)} | ({} if binary else {"uri": uri})]
    text = json.dumps(_merged(document, given))
    if not binary:
        return {f"{stem}.gltf": made(text)}
    body = text.encode() + b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(body), b"JSON") + body
    chunks += struct.pack("<I4s", len(data.bytes), b"BIN\0") + data.bytes
    return {f"{stem}.glb": struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks}


def _add_image(document: dict[str, Any], given: dict[str, Any], data: _Data) -> None:
    """An image for one of the material's values."""
    file, embed = given.pop("tex"), given.pop("embed", "")
    into = document["materials"][0]
    for name in given.pop("as", "pbrMetallicRoughness.baseColorTexture").split("."):
        into = into.setdefault(name, {})
    into |= {"index": 0} | given.pop("info", {})
    document["textures"] = [{"source": 0, "sampler": 0}]
    document["samplers"] = [given.pop("sampler", {})]
    image: dict[str, Any] = {"uri": file}
    if embed == "uri":
        image = {"uri": "data:image/png;base64," + base64.b64encode(pictures()[file]).decode()}
    elif embed:
        image = {"bufferView": data.view(pictures()[file], {}), "mimeType": "image/png"}
    document["images"] = [image]


def _add_node(document: dict[str, Any], kind: str, given: Any, node: dict[str, Any]) -> None:
    """A node with a camera or a light."""
    if kind == "camera":
        ((lens, values),) = given.items()
        document["cameras"] = [{"type": lens, lens: values}]
        node["camera"] = 0
    else:
        document["extensions"] = {"KHR_lights_punctual": {"lights": [given]}}
        document["extensionsUsed"].append("KHR_lights_punctual")
        node["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    document["nodes"].append(node)
    document["scenes"][0]["nodes"].append(1)


def _merged(old: Any, new: Any) -> Any:
    """New values over old ones; null takes away, and `{"0": …}` changes one entry of a list."""
    if isinstance(old, list) and isinstance(new, dict):
        size = max([len(old), *(int(i) + 1 for i in new)])
        padded = [*old, *[{}] * (size - len(old))]
        return [_merged(entry, new.get(str(i), {})) for i, entry in enumerate(padded)]
    if not (isinstance(old, dict) and isinstance(new, dict)):
        return new
    both = {name: _merged(old.get(name, {}), value) for name, value in new.items()}
    return {name: value for name, value in (old | both).items() if value is not None}
