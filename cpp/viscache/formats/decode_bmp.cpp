// Windows and OS/2 bitmaps: 1 to 8 bits with a palette, 16 to 32 bits with or without masks, no compression.
#include <array>
#include <bit>

#include "viscache/formats/decoders.h"

namespace viscache::loading {

namespace {

enum Compression : uint32_t { kPlainRows = 0, kMasks = 3, kMasksWithAlpha = 6 };

/// The bits of one channel in a pixel.
struct Mask {
    uint32_t bits = 0;
    int shift = 0, count = 0;

    Mask() = default;
    Mask(uint32_t mask, const std::string& where) : bits(mask) {
        if (mask == 0) return;
        shift = std::countr_zero(mask);
        count = std::popcount(mask);
        // `of` shifts the channel down in one piece.
        if (mask >> shift != (count == 32 ? ~0u : (1u << count) - 1))
            fail_broken(where, "the bits of a channel are not side by side");
    }
    /// The channel with 8 bits: fewer are repeated, of more the highest count.
    uint8_t of(uint32_t pixel) const {
        if (count == 0) return 0;
        uint32_t v = (pixel & bits) >> shift;
        if (count >= 8) return uint8_t(v >> (count - 8));
        uint32_t filled = 0;
        // Repeated bits map the largest value to 255 and 0 to 0: 5 bits 11111 become 11111111.
        for (int have = 8 - count;; have -= count) {
            filled |= have >= 0 ? v << have : v >> -have;
            if (have <= 0) return uint8_t(filled);
        }
    }
};

struct BmpHeader {
    uint64_t data = 0;  ///< offset of the pixels
    int64_t width = 0, height = 0;
    bool from_top = false;
    int bits = 0;
    std::array<Mask, 4> masks;  ///< red, green, blue, alpha
    std::vector<std::array<uint8_t, 3>> palette;
    /// Rows are padded to multiples of 4 bytes.
    uint64_t row_bytes() const { return (uint64_t(width) * uint64_t(bits) + 31) / 32 * 4; }
};

void read_masks(BmpHeader& h, ByteReader& in, uint32_t header_bytes, uint32_t compression,
                const std::string& where) {
    std::array<uint32_t, 4> masks{};
    // Headers of 52 bytes and more contain masks. Behind the one of 40 bytes they follow if the compression
    // says so.
    if (header_bytes >= 52 || compression != kPlainRows) {
        const int stored = header_bytes >= 56 || compression == kMasksWithAlpha ? 4 : 3;
        for (int i = 0; i < stored; ++i) masks[size_t(i)] = in.u32();
    }
    if (compression == kPlainRows) {
        // The usual layouts without masks: 5-5-5, B G R, and B G R A.
        if (h.bits == 16) masks = {0x7c00, 0x3e0, 0x1f, 0};
        if (h.bits == 24) masks = {0xff0000, 0xff00, 0xff, 0};
        if (h.bits == 32) masks = {0xff0000, 0xff00, 0xff, 0xff000000};
    }
    for (size_t i = 0; i < 4; ++i) h.masks[i] = Mask(masks[i], where);
    if (masks[0] == 0 && masks[1] == 0 && masks[2] == 0) fail_broken(where, "no bits hold colour");
}

void read_palette(BmpHeader& h, ByteReader& in, uint32_t header_bytes, uint32_t colors,
                  const std::string& where) {
    const uint64_t most = uint64_t(1) << h.bits, entry = header_bytes == 12 ? 3 : 4;
    uint64_t n = colors == 0 ? most : colors;
    if (n > most) fail_broken(where, "a palette of " + std::to_string(n) + " colours");
    // Some writers store fewer colours than the header says; the pixels begin at their offset all the same.
    if (h.data > in.at()) n = std::min(n, (h.data - in.at()) / entry);
    for (uint64_t i = 0; i < n; ++i) {
        const uint8_t* p = in.take(size_t(entry));
        // Stored as blue, green, red, and an unused byte in the larger entries.
        h.palette.push_back({p[2], p[1], p[0]});
    }
}

BmpHeader read_bmp_header(ByteReader& in, const std::string& where) {
    BmpHeader h;
    in.seek(10);
    h.data = in.u32();
    const uint32_t header_bytes = in.u32();
    // OS/2 1.x (12), Windows 3 (40), with masks (52, 56), versions 4 (108) and 5 (124).
    if (header_bytes != 12 && header_bytes != 40 && header_bytes != 52 && header_bytes != 56 &&
        header_bytes != 108 && header_bytes != 124)
        fail(where, "a BMP header of " + std::to_string(header_bytes) + " bytes is not known");
    const bool is_small = header_bytes == 12;
    h.width = is_small ? in.u16() : int32_t(in.u32());
    h.height = is_small ? in.u16() : int32_t(in.u32());
    // Rows run from the bottom to the top, unless the height is negative.
    h.from_top = h.height < 0;
    h.height = std::abs(h.height);
    in.u16();  // planes
    h.bits = in.u16();
    uint32_t compression = kPlainRows, colors = 0;
    if (!is_small) {
        compression = in.u32();
        in.take(12);  // size of the pixels, resolution
        colors = in.u32();
        in.take(4);  // important colours
    }
    const bool has_palette = h.bits == 1 || h.bits == 4 || h.bits == 8;
    if (!has_palette && h.bits != 16 && h.bits != 24 && h.bits != 32)
        fail_broken(where, std::to_string(h.bits) + " bits per pixel");
    const bool has_masks = compression == kMasks || compression == kMasksWithAlpha;
    if (compression != kPlainRows && !(has_masks && (h.bits == 16 || h.bits == 32)))
        fail(where, "BMP compression " + std::to_string(compression) + " is not read; save it uncompressed");
    if (h.width < 1 || h.height < 1) fail_broken(where, "it has no pixels");
    if (!has_palette)
        read_masks(h, in, header_bytes, compression, where);
    else {
        // The palette follows the file's header of 14 bytes and this header.
        in.seek(14 + uint64_t(header_bytes));
        read_palette(h, in, header_bytes, colors, where);
    }
    return h;
}

/// Pixel x of a row as a palette index or as its bits.
uint32_t pixel_bits(const uint8_t* row, int64_t x, int bits) {
    // The leftmost pixel is in the highest bits of a byte.
    if (bits < 8) return uint32_t(row[x * bits / 8]) >> (8 - bits - x * bits % 8) & ((1u << bits) - 1);
    uint32_t v = 0;
    for (int i = 0; i < bits / 8; ++i) v |= uint32_t(row[x * (bits / 8) + i]) << (8 * i);
    return v;
}

}  // namespace

Image decode_bmp(std::string_view bytes, const std::string& where, bool srgb) {
    ByteReader in(bytes, where);
    const BmpHeader h = read_bmp_header(in, where);
    const bool has_palette = !h.palette.empty() || h.bits <= 8,
               has_alpha = !has_palette && h.masks[3].bits != 0;
    Image image = empty_image(uint64_t(h.width), uint64_t(h.height), has_alpha ? 4 : 3, where, srgb);
    in.seek(h.data);
    const uint64_t used =
        (uint64_t(h.width) * uint64_t(h.bits) + 7) / 8;  // the last row may lack its padding
    // Before the array is made: a header of a few bytes may claim 2^28 pixels.
    check_holds(in.left(), h.row_bytes() * uint64_t(h.height - 1) + used, image);
    image.bytes.resize(size_t(h.width) * size_t(h.height) * size_t(image.channels));
    uint8_t any_alpha = 0;
    for (int64_t y = 0; y < h.height; ++y) {
        const uint8_t* row = in.take(size_t(y + 1 < h.height ? h.row_bytes() : used));
        uint8_t* out =
            &image
                 .bytes[size_t(h.from_top ? y : h.height - 1 - y) * size_t(h.width) * size_t(image.channels)];
        for (int64_t x = 0; x < h.width; ++x, out += image.channels) {
            const uint32_t v = pixel_bits(row, x, h.bits);
            // A palette may have fewer entries than the bits of a pixel can name.
            if (has_palette && v >= h.palette.size())
                fail_broken(where, "colour " + std::to_string(v) + " of a palette of " +
                                       std::to_string(h.palette.size()));
            for (size_t c = 0; c < 3; ++c) out[c] = has_palette ? h.palette[v][c] : h.masks[c].of(v);
            if (has_alpha) any_alpha |= out[3] = h.masks[3].of(v);
        }
    }
    // Many writers leave the fourth byte 0 and mean opaque.
    if (has_alpha && any_alpha == 0)
        for (size_t i = 3; i < image.bytes.size(); i += 4) image.bytes[i] = 255;
    return image;
}

}  // namespace viscache::loading
