"""Picture files written byte by byte, so that headers may claim anything."""

import struct
import zlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Bytes = npt.NDArray[np.uint8]

#: First row, first column, step of rows and columns of the seven passes of an interlaced PNG.
PASSES = (
    (0, 0, 8, 8),
    (0, 4, 8, 8),
    (4, 0, 8, 4),
    (0, 2, 4, 4),
    (2, 0, 4, 2),
    (0, 1, 2, 2),
    (1, 0, 2, 1),
)
COLOR_TYPES = {1: 0, 3: 2, 2: 4, 4: 6}


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(
    pixels: npt.NDArray[np.unsignedinteger],
    *,
    interlaced: bool = False,
    size: tuple[int, int] | None = None,
) -> bytes:
    """Pixels (H, W, C) of 8 or 16 bits; `size` is what the header claims."""
    height, width, channels = pixels.shape
    depth = 8 * pixels.dtype.itemsize
    claimed = (width, height) if size is None else size
    head = struct.pack(">2I5B", *claimed, depth, COLOR_TYPES[channels], 0, 0, int(interlaced))
    stored = pixels.astype(pixels.dtype.newbyteorder(">"))
    parts = [stored[r::dr, c::dc] for r, c, dr, dc in PASSES] if interlaced else [stored]
    rows = b"".join(b"\0" + row.tobytes() for part in parts if part.size for row in part)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def bmp(
    rows: Sequence[bytes],
    size: tuple[int, int],
    bits: int,
    *,
    palette: bytes = b"",
    masks: Sequence[int] = (),
) -> bytes:
    """Stored rows, from the bottom; a negative height in `size` means from the top."""
    start = 54 + 4 * len(masks) + len(palette)
    body = b"".join(row + b"\0" * (-len(row) % 4) for row in rows)
    compression = 3 if masks else 0
    head = struct.pack("<iiHHIIiiII", *size, 1, bits, compression, 0, 0, 0, len(palette) // 4, 0)
    return (
        b"BM"
        + struct.pack("<IIII", start + len(body), 0, start, 40)
        + head
        + struct.pack(f"<{len(masks)}I", *masks)
        + palette
        + body
    )


def tga(kind: int, size: tuple[int, int], bits: int, body: bytes, descriptor: int = 0) -> bytes:
    """Without a palette."""
    return struct.pack("<BBBHHBHHHHBB", 0, 0, kind, 0, 0, 0, 0, 0, *size, bits, descriptor) + body


def hdr(resolution: str, body: bytes, head: str = "FORMAT=32-bit_rle_rgbe\n") -> bytes:
    """`resolution` is the line of the size, such as `-Y 4 +X 8`."""
    return b"#?RADIANCE\n" + head.encode() + b"\n" + resolution.encode() + b"\n" + body


def new_runs(rgbe: Bytes) -> bytes:
    """Scanlines (H, W, 4) with runs of each component."""
    width = rgbe.shape[1]
    out = bytearray()
    for row in rgbe:
        out += bytes([2, 2, width >> 8, width & 255])
        for values in row.T:
            i = 0
            while i < width:
                same = 1
                while same < 127 and i + same < width and values[i + same] == values[i]:
                    same += 1
                out += bytes([128 + same, values[i]] if same > 2 else [1, values[i]])
                i += same if same > 2 else 1
    return bytes(out)


def old_runs(rgbe: Bytes) -> bytes:
    """Scanlines (H, W, 4) with runs of whole pixels; a long run takes several counts."""
    out = bytearray()
    for row in rgbe:
        i = 0
        while i < len(row):
            out += row[i].tobytes()
            same = 0
            while i + 1 + same < len(row) and (row[i + 1 + same] == row[i]).all():
                same += 1
            left = same
            while left:
                out += bytes([1, 1, 1, left & 255])
                left >>= 8
            i += 1 + same
    return bytes(out)


def jpeg_with_huffman_counts(counts: Sequence[int]) -> bytes:
    """A grey picture of 8 x 8 pixels whose table of codes has `counts` codes of 1 to 16 bits."""

    def segment(marker: int, data: bytes) -> bytes:
        return bytes([0xFF, marker]) + struct.pack(">H", 2 + len(data)) + data

    table = bytes([0]) + bytes(counts) + bytes(k & 255 for k in range(sum(counts)))
    return (
        b"\xff\xd8"
        + segment(0xDB, bytes([0]) + bytes([1] * 64))
        + segment(0xC0, struct.pack(">BHHB", 8, 8, 8, 1) + bytes([1, 0x11, 0]))
        + segment(0xC4, table)
        + segment(0xC4, bytes([0x10, 1] + [0] * 15 + [0]))
        + segment(0xDA, bytes([1, 1, 0, 0, 63, 0]))
        + b"\x00\x00\xff\xd9"
    )
