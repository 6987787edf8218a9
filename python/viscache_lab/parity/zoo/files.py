"""The mesh and picture files that zoo scenes name; every file is made here."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
#: Positions, normals, texture coordinates and faces.
Mesh = tuple[Array, Array | None, Array | None, Array]

#: A wedge with a slanted top: positions, faces seen from outside, texture coordinates.
_CORNERS = np.array(
    [[-0.9, -0.8, 0.5], [0.8, -0.8, 0.6], [-0.7, -0.8, -0.6], [-0.8, 0.9, 0.3], [0.3, 0.2, -0.2]]
)
_FACES = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 3, 4], [2, 0, 3], [0, 2, 1]])
_UVS = np.array([[0.1, 0.0], [0.9, 0.2], [0.6, 1.0], [0.2, 0.8], [0.7, 0.5]])


def write_files(folder: Path) -> None:
    """Write all files into a folder."""
    # Some normals of the smooth wedge lean from their faces by more than 90 degrees
    smooth = _CORNERS, _mean_normals(_CORNERS, _FACES), _UVS, _FACES
    meshes: dict[str, Mesh] = {
        "wedge": (_CORNERS, None, _UVS, _FACES),
        "wedge-smooth": smooth,
        "wedge-creased": _creased(),
        "wedge-bare": (_CORNERS, None, None, _FACES),
        "pebble": _pebble(),
    }
    for name, mesh in meshes.items():
        (folder / f"{name}.obj").write_text(_obj(*mesh), encoding="ascii")
        (folder / f"{name}.ply").write_text(_ply(*mesh), encoding="ascii")
        if mesh[2] is not None:
            (folder / f"{name}.serialized").write_bytes(_serialized(*mesh))
    _write_pictures(folder)


def picture(side: int = 16) -> Array:
    """(side, side, 3) in [0, 1]: blocks of random colours, alike in no two directions."""
    cells = np.random.default_rng(7).uniform(0.05, 0.95, (side // 4, side // 4, 3))
    return np.repeat(np.repeat(cells, 4, axis=0), 4, axis=1)


def sky_picture() -> Array:
    """(256, 512, 3) radiance: a gradient, and one bright patch to one side."""
    v, u = np.mgrid[0:256, 0:512] / np.array([256, 512]).reshape(2, 1, 1)
    sky = np.stack([0.2 + 0.5 * u, 0.3 + 0.3 * v, 0.8 - 0.5 * u], axis=2)
    sky[64:96, 160:208] = (9, 7, 4)
    return sky


def _pebble() -> Mesh:
    """Rings between two poles, with dents; normals of vertices lean little from those of faces."""
    rings, around = 11, 24
    theta, phi = np.mgrid[1 : rings + 1, 0:around]
    theta, phi = np.pi / (rings + 1) * theta, 2 * np.pi / around * phi
    ring = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], 2)
    unit = np.concatenate([[[0, 1, 0]], ring.reshape(-1, 3), [[0, -1, 0]]])
    dents = 1 + 0.15 * np.sin(unit @ [2.0, 1.1, -1.7]) + 0.1 * np.sin(unit @ [-1.0, 2.3, 1.9])
    positions = unit * dents[:, None] * [0.9, 0.75, 0.6]
    first = 1 + around * np.arange(rings - 1)[:, None] + np.arange(around)
    after = first + np.where(np.arange(around) == around - 1, 1 - around, 1)
    top = np.stack([np.zeros(around, int), after[0], first[0]], 1)
    low = np.stack([np.full(around, len(unit) - 1), first[-1] + around, after[-1] + around], 1)
    sides = [[first, after, after + around], [first, after + around, first + around]]
    faces = np.concatenate([top, *(np.stack(s, 2).reshape(-1, 3) for s in sides), low])
    return positions, _mean_normals(positions, faces), 0.5 + positions[:, :2] / 3, faces


def _mean_normals(positions: Array, faces: Array) -> Array:
    """Means of the normals of faces, weighted by their area, as a smoothing editor makes them."""
    normals = np.zeros_like(positions)
    for face in faces:
        a, b, c = positions[face]
        normals[face] += np.cross(b - a, c - a)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _creased() -> Mesh:
    """Each face has corners and a normal of its own."""
    corners, faces = _CORNERS[_FACES], np.arange(3 * len(_FACES)).reshape(-1, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    positions = corners.reshape(-1, 3)
    return positions, np.repeat(normals, 3, axis=0), _UVS[_FACES].reshape(-1, 2), faces


def _obj(positions: Array, normals: Array | None, uvs: Array | None, faces: Array) -> str:
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in positions]
    lines += [] if uvs is None else [f"vt {u:.6g} {v:.6g}" for u, v in uvs]
    if normals is not None:
        lines += [f"vn {x:.6g} {y:.6g} {z:.6g}" for x, y, z in normals]
    for face in faces + 1:
        uv = "" if uvs is None else "/{0}"
        corner = "{0}" + uv + ("" if normals is None else "/{0}" if uv else "//{0}")
        lines.append("f " + " ".join(corner.format(i) for i in face))
    return "\n".join(lines) + "\n"


def _ply(positions: Array, normals: Array | None, uvs: Array | None, faces: Array) -> str:
    columns = [c for c in (positions, normals, uvs) if c is not None]
    names = ["x", "y", "z"]
    names += [] if normals is None else ["nx", "ny", "nz"]
    names += [] if uvs is None else ["u", "v"]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(positions)}"]
    lines += [f"property float {name}" for name in names]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{v:.6g}" for v in row) for row in np.concatenate(columns, axis=1)]
    lines += ["3 " + " ".join(map(str, face)) for face in faces]
    return "\n".join(lines) + "\n"


def _serialized(positions: Array, normals: Array | None, uvs: Array | None, faces: Array) -> bytes:
    """Version 4 of Mitsuba's format: one mesh, then the table of offsets."""
    # Single precision, uvs, normals
    flags = 0x1000 | 0x0002 | 0x0001 * (normals is not None)
    body = struct.pack("<I", flags) + b"wedge\0" + struct.pack("<QQ", len(positions), len(faces))
    for values in (positions, normals, uvs):
        body += b"" if values is None else values.astype("<f4").tobytes()
    body += faces.astype("<u4").tobytes()
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(body) + struct.pack("<QI", 0, 1)


def _write_pictures(folder: Path) -> None:
    from PIL import Image

    linear, sky = picture(), sky_picture()
    eight = np.round(255 * linear).astype(np.uint8)
    cut = np.where(eight[..., 2:] > 128, 255, 0).astype(np.uint8)
    Image.fromarray(eight).save(folder / "blocks.jpg", quality=95, subsampling=0)
    for name, image in {
        "blocks": Image.fromarray(eight),
        "palette": Image.fromarray(eight).quantize(16),
        "grey": Image.fromarray(eight[..., 0]),
        "deep": Image.fromarray(eight[..., 1].astype(np.uint16) * 257),
        "alpha": Image.fromarray(np.concatenate([eight, cut], axis=2)),
        "sky": Image.fromarray(np.round(28 * sky).astype(np.uint8)),
    }.items():
        image.save(folder / f"{name}.png")
    for name, pixels in {"blocks": linear, "sky": sky}.items():
        _write_exr(folder / f"{name}.exr", pixels)
        (folder / f"{name}.hdr").write_bytes(_rgbe(pixels))


def _write_exr(path: Path, pixels: Array) -> None:
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {"RGB": np.ascontiguousarray(pixels, np.float32)}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))


def _rgbe(pixels: Array) -> bytes:
    """Radiance's format without run lengths."""
    height, width, _ = pixels.shape
    largest = pixels.max(axis=2)
    _, exponent = np.frexp(largest)
    scaled = pixels * np.ldexp(256.0, -exponent)[..., None]
    rows = np.concatenate([np.floor(scaled), (exponent + 128)[..., None]], axis=2)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    return head.encode("ascii") + rows.astype(np.uint8).tobytes()
