"""Pictures of every format: the values that others read, and clear errors for broken files."""

import io
import resource
import struct

import numpy as np
import pytest
from PIL import Image

from scene import picture_files as files
from viscache import _core as core

RNG = np.random.default_rng(3)
WIDTH, HEIGHT = 17, 13


def smooth(channels):
    """Smooth in its upper half, noise below."""
    row, column = np.mgrid[:HEIGHT, :WIDTH]
    planes = [(column * 7 + row * 3 * (c + 1)) % 256 for c in range(channels)]
    picture = np.stack(planes, axis=-1).astype(np.uint8)
    picture[HEIGHT // 2 :] ^= RNG.integers(0, 256, picture[HEIGHT // 2 :].shape, dtype=np.uint8)
    return picture


def read(folder, content):
    path = folder / "picture"
    path.write_bytes(content)
    return core.read_image(str(path))


def linear(encoded, most=255):
    """Linear values of sRGB-encoded colour; the last of 2 or 4 channels is alpha."""
    v = encoded / most
    out = np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    if encoded.shape[2] in (2, 4):
        out[..., -1] = v[..., -1]
    return out


def encoded(values):
    """The bytes of linear colour, in fractions of 255."""
    v = values.astype(np.float64)
    return 255 * np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def saved(picture, kind, **options):
    out = io.BytesIO()
    picture.save(out, kind, **options)
    return out.getvalue()


def by_pillow(content, mode=None):
    picture = Image.open(io.BytesIO(content))
    pixels = np.asarray(picture.convert(mode) if mode else picture)
    return pixels.reshape(*pixels.shape[:2], -1)


def same_bytes(read_values, expected):
    assert read_values.shape == expected.shape
    np.testing.assert_allclose(read_values, linear(expected), rtol=1e-6, atol=1e-9)


COLOR = Image.fromarray(smooth(3))
GREY = Image.fromarray(smooth(1)[..., 0])
ALPHA = Image.fromarray(smooth(4), "RGBA")
GREY_ALPHA = Image.fromarray(smooth(2), "LA")
PALETTE = COLOR.quantize(16)
BITS = GREY.convert("1")

PNGS = {
    "grey": (saved(GREY, "png"), None),
    "grey and alpha": (saved(GREY_ALPHA, "png"), None),
    "colour": (saved(COLOR, "png"), None),
    "colour and alpha": (saved(ALPHA, "png"), None),
    "1 bit": (saved(BITS, "png"), "L"),
    "palette": (saved(PALETTE, "png"), "RGB"),
    "palette with a transparent colour": (saved(PALETTE, "png", transparency=3), "RGBA"),
    "grey with a transparent value": (saved(GREY, "png", transparency=7), "LA"),
    "colour with a transparent one": (saved(COLOR, "png", transparency=(0, 0, 0)), "RGBA"),
    "interlaced": (files.png(smooth(3), interlaced=True), None),
    "interlaced with alpha": (files.png(smooth(4), interlaced=True), None),
}
JPEGS = {
    "grey": (saved(GREY, "jpeg"), None),
    "4:2:0": (saved(COLOR, "jpeg", quality=90), None),
    "4:4:4": (saved(COLOR, "jpeg", quality=97, subsampling=0), None),
    "progressive": (saved(COLOR, "jpeg", progressive=True), None),
    "inks": (saved(COLOR.convert("CMYK"), "jpeg", quality=97), "RGB"),
}
BMPS = {
    "colour": (saved(COLOR, "bmp"), None),
    "grey": (saved(GREY, "bmp"), "RGB"),
    "palette": (saved(PALETTE, "bmp"), "RGB"),
    "1 bit": (saved(BITS, "bmp"), "RGB"),
}
TGAS = {
    f"{name}{runs or ', flat'}": (saved(picture, "tga", compression=runs), mode)
    for name, picture, mode in (
        ("colour", COLOR, None),
        ("alpha", ALPHA, None),
        ("grey", GREY, None),
        ("grey and alpha", GREY_ALPHA, None),
        ("palette", PALETTE, "RGB"),
    )
    for runs in (None, "tga_rle")
}
EXACT = {
    f"{kind} {name}": case
    for kind, cases in (("png", PNGS), ("bmp", BMPS), ("tga", TGAS))
    for name, case in cases.items()
}


@pytest.mark.parametrize("name", EXACT)
def test_a_picture_has_the_bytes_that_pillow_reads(tmp_path, name):
    content, mode = EXACT[name]
    same_bytes(read(tmp_path, content), by_pillow(content, mode))


@pytest.mark.parametrize("name", JPEGS)
def test_a_jpeg_is_within_one_step_of_what_pillow_reads(tmp_path, name):
    content, mode = JPEGS[name]
    got, expected = encoded(read(tmp_path, content)), by_pillow(content, mode)
    assert got.shape == expected.shape
    assert np.abs(got - expected).max() < 1.01
    assert np.abs(got - np.roll(expected, 1, axis=1)).max() > 20  # another picture is not


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("interlaced", [False, True])
def test_a_png_of_16_bits_keeps_them(tmp_path, channels, interlaced):
    pixels = RNG.integers(0, 1 << 16, (HEIGHT, WIDTH, channels), dtype=np.uint16)
    got = read(tmp_path, files.png(pixels, interlaced=interlaced))
    np.testing.assert_allclose(got, linear(pixels, 65535), rtol=2e-6, atol=1e-9)
    assert np.abs(got - linear(pixels >> 8)).max() > 1e-3  # the upper byte alone is not enough


@pytest.mark.parametrize(("masks", "green_bits"), [((), 5), ((0xF800, 0x7E0, 0x1F), 6)])
def test_a_bmp_of_16_bits_has_its_masks(tmp_path, masks, green_bits):
    stored = RNG.integers(0, 1 << (10 + green_bits), (HEIGHT, WIDTH), dtype=np.uint16)
    content = files.bmp([row.tobytes() for row in stored[::-1]], (WIDTH, HEIGHT), 16, masks=masks)
    blue, green, red = (
        stored & 31,
        stored >> 5 & (1 << green_bits) - 1,
        stored >> 5 + green_bits & 31,
    )
    wide = [
        red << 3 | red >> 2,
        green << 8 - green_bits | green >> 2 * green_bits - 8,
        blue << 3 | blue >> 2,
    ]
    same_bytes(read(tmp_path, content), np.stack(wide, axis=-1).astype(np.uint8))


@pytest.mark.parametrize("has_alpha", [True, False])
def test_a_bmp_may_go_from_the_top_and_leave_its_fourth_bytes_0(tmp_path, has_alpha):
    pixels = smooth(4)
    if not has_alpha:
        pixels[..., 3] = 0  # what many writers leave there
    rows = [np.ascontiguousarray(row[:, [2, 1, 0, 3]]).tobytes() for row in pixels]
    got = read(tmp_path, files.bmp(rows, (WIDTH, -HEIGHT), 32))
    if not has_alpha:
        pixels[..., 3] = 255
    same_bytes(got, pixels)


@pytest.mark.parametrize("descriptor", [0, 0x10, 0x20, 0x30])
def test_a_tga_starts_in_any_corner(tmp_path, descriptor):
    pixels = smooth(3)
    flipped = pixels[:: 1 if descriptor & 0x20 else -1, :: -1 if descriptor & 0x10 else 1]
    body = np.ascontiguousarray(flipped[..., ::-1]).tobytes()
    same_bytes(read(tmp_path, files.tga(2, (WIDTH, HEIGHT), 24, body, descriptor)), pixels)


def test_a_tga_of_16_bits_has_five_per_channel(tmp_path):
    stored = RNG.integers(0, 1 << 15, (HEIGHT, WIDTH), dtype=np.uint16)
    planes = np.stack([stored >> 10 & 31, stored >> 5 & 31, stored & 31], axis=-1)
    got = read(tmp_path, files.tga(2, (WIDTH, HEIGHT), 16, stored.tobytes(), 0x20))
    same_bytes(got, (planes * 255 // 31).astype(np.uint8))


def rgbe(width=40, height=6):
    pixels = RNG.integers(2, 256, (height, width, 4), dtype=np.uint8)
    pixels[:, 5:30, :] = pixels[:, 5:6, :]  # a run of whole pixels
    pixels[..., 3] = RNG.integers(120, 140, (height, 1))
    pixels[0, :2, 3] = 0  # black
    return pixels


def radiance(pixels):
    exponent = pixels[..., 3:].astype(int)
    return np.where(exponent == 0, 0.0, pixels[..., :3] * 2.0 ** (exponent - 136)).astype(
        np.float32
    )


@pytest.mark.parametrize("store", [np.ndarray.tobytes, files.new_runs, files.old_runs])
@pytest.mark.parametrize("width", [1, 7, 8, 40, 700])
def test_an_hdr_has_its_radiance_flat_and_in_runs(tmp_path, store, width):
    pixels = rgbe(width)
    if store is files.new_runs and width < 8:
        pytest.skip("such runs need scanlines of 8 pixels")
    content = files.hdr(f"-Y {pixels.shape[0]} +X {width}", store(pixels))
    assert np.array_equal(read(tmp_path, content), radiance(pixels))


@pytest.mark.parametrize("rows_first", [True, False])
@pytest.mark.parametrize("y", "-+")
@pytest.mark.parametrize("x", "-+")
def test_an_hdr_may_run_along_either_axis_in_either_direction(tmp_path, rows_first, y, x):
    pixels = rgbe()
    stored = pixels[:: 1 if y == "-" else -1, :: 1 if x == "+" else -1]
    axes = [f"{y}Y {pixels.shape[0]}", f"{x}X {pixels.shape[1]}"]
    if not rows_first:
        stored, axes = stored.transpose(1, 0, 2), axes[::-1]
    content = files.hdr(" ".join(axes), np.ascontiguousarray(stored).tobytes())
    assert np.array_equal(read(tmp_path, content), radiance(pixels))


LINE = bytes([2, 2, 0, 16])
#: What is broken, the file, what the error says.
BROKEN = {
    "an hdr's run of 0": (files.hdr("-Y 8 +X 16", LINE + bytes(9999)), "a run of 0 pixels"),
    "an hdr's old run of 0": (
        files.hdr("-Y 1 +X 2", bytes([9, 9, 9, 128, 1, 1, 1, 0])),
        "a run of 0 pixels",
    ),
    "an hdr's run over its scanline": (
        files.hdr("-Y 1 +X 16", LINE + bytes([128 + 17, 5]) * 9),
        "longer than its scanline",
    ),
    "an hdr's run before any pixel": (
        files.hdr("-Y 1 +X 2", bytes([1, 1, 1, 2]) * 2),
        "does not fit its scanline",
    ),
    "an hdr's scanline of another length": (
        files.hdr("-Y 1 +X 17", LINE + bytes(99)),
        "scanline of 16 pixels, 17 are due",
    ),
    "an hdr's two axes of rows": (files.hdr("-Y 1 +Y 2", bytes(99)), "must read like '-Y 4"),
    "an hdr of xyz": (
        files.hdr("-Y 1 +X 1", bytes(4), "FORMAT=32-bit_rle_xyze\n"),
        "32-bit_rle_xyze",
    ),
    "an hdr without an end of its header": (b"#?RADIANCE\n" + b"x" * 99999, "header has no end"),
    "a bmp with runs": (
        (flat := saved(GREY, "bmp"))[:30] + b"\1" + flat[31:],
        "compression 1 is not read",
    ),
    "a bmp's colour outside of its palette": (
        files.bmp([bytes([0, 2])], (2, 1), 8, palette=bytes(8)),
        "colour 2 of a palette of 2",
    ),
    "a tga's colour outside of its palette": (
        struct.pack("<BBBHHBHHHHBB", 0, 1, 1, 5, 2, 24, 0, 0, 1, 1, 8, 0) + bytes(6) + bytes([7]),
        "colour 2 of a palette of 2",
    ),
    "a jpeg's table of too many codes": (files.jpeg_with_huffman_counts([255] * 16), "Huffman"),
    "a jpeg's table of 257 codes": (
        files.jpeg_with_huffman_counts([0] * 7 + [200, 57] + [0] * 7),
        "Huffman",
    ),
    "no picture": (b"hello, this is some text", "PNG, JPEG, HDR, TGA or BMP is expected"),
    "a png's damaged row": (
        (whole := files.png(smooth(3)))[:60] + bytes([whole[60] ^ 255]) + whole[61:],
        "the image is broken",
    ),
}


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_picture_is_named_with_what_is_broken(tmp_path, what):
    content, message = BROKEN[what]
    with pytest.raises(core.SceneError, match=message) as error:
        read(tmp_path, content)
    assert str(error.value).startswith(str(tmp_path / "picture"))


def with_scans(n):
    """A progressive JPEG whose first scan stands `n` times more in the file."""
    whole = JPEGS["progressive"][0]
    start = whole.index(b"\xff\xda")
    head = start + 2 + int.from_bytes(whole[start + 2 : start + 4], "big")
    end = next(i for i in range(head, len(whole)) if whole[i] == 0xFF and whole[i + 1] != 0)
    return whole[:start] + whole[start:end] * n + whole[start:]


def test_a_progressive_jpeg_has_a_largest_number_of_scans(tmp_path):
    once = read(tmp_path, JPEGS["progressive"][0])
    assert np.array_equal(read(tmp_path, with_scans(20)), once)
    with pytest.raises(core.SceneError, match="more than 64 scans"):
        read(tmp_path, with_scans(70))


CLAIMS = {
    "bmp": files.bmp([bytes(384)], (16384, 16384), 24),
    "tga": files.tga(2, (65535, 4000), 24, bytes(384)),
    "tga with runs": files.tga(10, (65535, 4000), 24, bytes(384)),
    "hdr": files.hdr("-Y 8000 +X 16000", bytes(384)),
    "png": files.png(smooth(3), size=(16000, 16000)),
    "jpeg": (grey := saved(GREY, "jpeg"))[: (at := grey.index(b"\xff\xc0"))]
    + grey[at : at + 5]
    + struct.pack(">HH", 16000, 16000)
    + grey[at + 9 :],
}


@pytest.mark.parametrize("name", CLAIMS)
def test_a_claim_that_the_bytes_cannot_hold_takes_no_memory(tmp_path, name):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(core.SceneError, match="too short for the"):
        read(tmp_path, CLAIMS[name])
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 32 * 1024  # KiB


@pytest.mark.parametrize(
    ("content", "most"),
    [
        (files.png(smooth(3), size=(1 << 15, (1 << 13) + 1)), "2\\^28"),
        (files.png(smooth(3).astype(np.uint16), size=(1 << 15, (1 << 12) + 1)), "2\\^27"),
        (files.hdr("-Y 100000 +X 100000", bytes(99)), "2\\^27"),
        (files.bmp([bytes(9)], (1 << 30, 1 << 30), 24), "2\\^28"),
    ],
)
def test_pictures_have_a_largest_size(tmp_path, content, most):
    with pytest.raises(core.SceneError, match=f"at most {most} are read"):
        read(tmp_path, content)


WHOLE = {
    **{f"png {n}": c for n, (c, _) in PNGS.items()},
    **{f"jpeg {n}": c for n, (c, _) in JPEGS.items()},
    **{f"bmp {n}": c for n, (c, _) in BMPS.items()},
    **{f"tga {n}": c[: c.rindex(b"TRUEVISION") - 8] for n, (c, _) in TGAS.items()},
    "hdr flat": files.hdr("-Y 6 +X 40", rgbe().tobytes()),
    "hdr new": files.hdr("-Y 6 +X 40", files.new_runs(rgbe())),
    "hdr old": files.hdr("-Y 6 +X 40", files.old_runs(rgbe())),
}


@pytest.mark.parametrize("name", WHOLE)
def test_a_picture_that_ends_too_early_is_refused(tmp_path, name):
    content = WHOLE[name]
    # The last bytes may be padding or an end mark.
    for end in [*range(1, 60), *range(60, len(content) - 12, 11)]:
        with pytest.raises(core.SceneError):
            read(tmp_path, content[:end])
