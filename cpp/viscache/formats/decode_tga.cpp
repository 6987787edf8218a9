// Truevision TGA: grey, colour and palettes of 8 to 32 bits, flat or with runs.
#include <algorithm>
#include <array>

#include "viscache/formats/decoders.h"

namespace viscache::loading {

namespace {

constexpr size_t kHeaderBytes = 18;

struct TgaHeader {
    int id_bytes = 0, type = 0;
    int map_first = 0, map_length = 0, map_bits = 0;
    int width = 0, height = 0, bits = 0;
    bool has_map = false, from_top = false, from_right = false;

    bool has_runs() const { return type >= 9; }
    int kind() const { return type & 7; }  ///< 1: palette, 2: colour, 3: grey
    int value_bits() const { return kind() == 1 ? map_bits : bits; }
    int channels() const {
        if (kind() == 3) return bits == 16 ? 2 : 1;
        return value_bits() == 32 ? 4 : 3;
    }
};

TgaHeader read_tga_header(ByteReader& in) {
    TgaHeader h;
    h.id_bytes = in.u8();
    const int map_type = in.u8();
    h.has_map = map_type != 0;
    h.type = map_type > 1 ? 0 : in.u8();  // 0: not an image
    in.seek(3);
    h.map_first = in.u16();
    h.map_length = in.u16();
    h.map_bits = in.u8();
    in.take(4);  // origin
    h.width = in.u16();
    h.height = in.u16();
    h.bits = in.u8();
    const int descriptor = in.u8();
    h.from_right = descriptor & 0x10;
    h.from_top = descriptor & 0x20;
    return h;
}

bool is_color_bits(int bits) { return bits == 15 || bits == 16 || bits == 24 || bits == 32; }

bool is_known_tga(const TgaHeader& h) {
    if (h.width < 1 || h.height < 1 || h.type > 11) return false;
    switch (h.kind()) {
        case 1:
            return h.has_map && h.map_length > 0 && is_color_bits(h.map_bits) &&
                   (h.bits == 8 || h.bits == 16);
        case 2: return is_color_bits(h.bits);
        case 3: return h.bits == 8 || h.bits == 16;
        default: return false;
    }
}

/// Writes the channels of a stored value: 5 bits each, or bytes in the order blue, green, red, alpha.
void expand(const uint8_t* stored, int bits, bool is_grey, uint8_t* out) {
    if (is_grey) {
        std::copy_n(stored, bits / 8, out);
    } else if (bits <= 16) {
        const int v = stored[0] | stored[1] << 8;
        for (int c = 0; c < 3; ++c) out[c] = uint8_t((v >> (10 - 5 * c) & 31) * 255 / 31);
    } else {
        for (int c = 0; c < 3; ++c) out[c] = stored[2 - c];
        if (bits == 32) out[3] = stored[3];
    }
}

using Value = std::array<uint8_t, 4>;

std::vector<Value> read_map(ByteReader& in, const TgaHeader& h) {
    std::vector<Value> map;
    if (!h.has_map) return map;
    const auto entry = size_t((h.map_bits + 7) / 8);
    if (h.kind() != 1) {
        in.take(entry * size_t(h.map_length));
        return map;
    }
    for (int i = 0; i < h.map_length; ++i)
        expand(in.take(entry), h.map_bits, false, map.emplace_back().data());
    return map;
}

/// The stored values one after the other, with runs unrolled.
class TgaValues {
public:
    TgaValues(ByteReader& in, const TgaHeader& h)
        : in_(in), bytes_(size_t(h.bits + 7) / 8), has_runs_(h.has_runs()) {}
    const uint8_t* next() {
        if (!has_runs_) return in_.take(bytes_);
        if (left_ == 0) {
            const int code = in_.u8();
            left_ = (code & 127) + 1;
            repeats_ = code > 127;
            if (repeats_) value_ = in_.take(bytes_);
        }
        --left_;
        return repeats_ ? value_ : in_.take(bytes_);
    }

private:
    ByteReader& in_;
    size_t bytes_;
    bool has_runs_, repeats_ = false;
    int left_ = 0;
    const uint8_t* value_ = nullptr;
};

}  // namespace

bool looks_like_tga(std::string_view bytes) {
    const std::string nowhere;
    ByteReader in(bytes, nowhere);
    return bytes.size() >= kHeaderBytes && is_known_tga(read_tga_header(in));
}

Image decode_tga(std::string_view bytes, const std::string& where, bool srgb) {
    ByteReader in(bytes, where);
    const TgaHeader h = read_tga_header(in);
    if (!is_known_tga(h)) fail_broken(where, "not a TGA header");
    Image image = empty_image(uint64_t(h.width), uint64_t(h.height), h.channels(), where, srgb);
    in.take(size_t(h.id_bytes));
    const std::vector<Value> map = read_map(in, h);
    const uint64_t pixels = uint64_t(h.width) * uint64_t(h.height), stored = uint64_t(h.bits + 7) / 8;
    check_holds(in.left(), h.has_runs() ? (pixels + 127) / 128 * (1 + stored) : pixels * stored, image);
    image.bytes.resize(size_t(pixels) * size_t(image.channels));
    TgaValues values(in, h);
    for (int row = 0; row < h.height; ++row)
        for (int column = 0; column < h.width; ++column) {
            const int y = h.from_top ? row : h.height - 1 - row;
            const int x = h.from_right ? h.width - 1 - column : column;
            uint8_t* out = &image.bytes[(size_t(y) * size_t(h.width) + size_t(x)) * size_t(image.channels)];
            const uint8_t* value = values.next();
            if (h.kind() != 1) {
                expand(value, h.bits, h.kind() == 3, out);
                continue;
            }
            const int index = (stored == 2 ? value[0] | value[1] << 8 : value[0]) - h.map_first;
            if (index < 0 || index >= h.map_length)
                fail_broken(where, "colour " + std::to_string(index) + " of a palette of " +
                                       std::to_string(h.map_length));
            std::copy_n(map[size_t(index)].data(), image.channels, out);
        }
    return image;
}

}  // namespace viscache::loading
