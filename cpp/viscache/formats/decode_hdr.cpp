// Radiance HDR (.hdr, .pic): RGBE pixels, flat or with runs of the old or the new kind.
#include <algorithm>
#include <array>
#include <cmath>

#include "viscache/formats/decoders.h"

namespace viscache::loading {

namespace {

// Header lines have any length and number; without a limit, pixels would be searched for newlines.
constexpr size_t kMaxHeaderBytes = 1 << 16;

struct Rgbe {
    uint8_t v[4];
};

/// Where pixels go: scanlines may run along either axis, in either direction.
struct Layout {
    int width, height;
    bool columns;      ///< scanlines are columns
    bool from_bottom;  ///< rows go from the bottom to the top
    bool from_right;   ///< columns go from the right to the left
    int length() const { return columns ? height : width; }
    int lines() const { return columns ? width : height; }
    size_t index(int line, int i) const {
        int x = columns ? line : i, y = columns ? i : line;
        if (from_right) x = width - 1 - x;
        if (from_bottom) y = height - 1 - y;
        return size_t(y) * size_t(width) + size_t(x);
    }
};

/// "-Y 4 +X 8": the outer axis first. -Y runs down, +X to the right.
Layout layout_of(const std::string& line, const std::string& where) {
    const auto broken = [&] {
        fail_broken(where, "the size must read like '-Y 4 +X 8', got '" + line.substr(0, 80) + "'");
    };
    std::string_view rest = line;
    const auto word = [&] {
        rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
        const std::string_view found = rest.substr(0, std::min(rest.find(' '), rest.size()));
        rest.remove_prefix(found.size());
        return found;
    };
    std::string_view axes[2];
    int64_t sizes[2];
    for (int i = 0; i < 2; ++i) {
        axes[i] = word();
        const auto size = parse_integer(word());
        if (axes[i].size() != 2 || (axes[i][0] != '-' && axes[i][0] != '+') || !size || *size < 1 ||
            *size > 0x7fffffff)
            broken();
        sizes[i] = *size;
    }
    // Each axis must occur once.
    const int y = axes[0][1] == 'Y' ? 0 : 1;
    if (axes[y][1] != 'Y' || axes[1 - y][1] != 'X' || !word().empty()) broken();
    return {int(sizes[1 - y]), int(sizes[y]), y == 1, axes[y][0] == '+', axes[1 - y][0] == '-'};
}

/// Reads the header up to the line of the size.
Layout read_hdr_header(ByteReader& in, const std::string& where) {
    const auto line = [&] {
        std::string text;
        for (char c; (c = char(in.u8())) != '\n';) {
            if (in.at() > kMaxHeaderBytes) fail_broken(where, "the header has no end");
            text += c;
        }
        if (text.ends_with('\r')) text.pop_back();
        return text;
    };
    line();  // the signature
    // An empty line ends the variables. EXPOSURE and others are not applied.
    for (std::string text = line(); !text.empty(); text = line())
        if (text.starts_with("FORMAT=") && text != "FORMAT=32-bit_rle_rgbe")
            fail(where, "the image has the format '" + text.substr(7, 80) + "'; 32-bit_rle_rgbe is read");
    return layout_of(line(), where);
}

/// Runs of each component by itself.
void read_new_runs(ByteReader& in, std::vector<Rgbe>& line, const std::string& where) {
    for (int component = 0; component < 4; ++component)
        for (size_t i = 0; i < line.size();) {
            const int code = in.u8();
            // Codes up to 128: so many literal bytes. Above: a run of code − 128 equal bytes.
            const bool is_run = code > 128;
            const size_t n = size_t(is_run ? code - 128 : code);
            if (n == 0) fail_broken(where, "a run of 0 pixels");
            if (n > line.size() - i) fail_broken(where, "a run is longer than its scanline");
            const uint8_t* values = in.take(is_run ? 1 : n);
            Rgbe* const out = line.data() + i;  // bytes may alias the vector's own pointers
            if (is_run)
                for (size_t k = 0, value = *values; k < n; ++k) out[k].v[component] = uint8_t(value);
            else
                for (size_t k = 0; k < n; ++k) out[k].v[component] = values[k];
            i += n;
        }
}

/// Whole pixels; (1, 1, 1, n) repeats the pixel before it. Further counts are the higher bytes.
void read_old_runs(ByteReader& in, std::vector<Rgbe>& line, const std::string& where) {
    int shift = 0;
    for (size_t i = 0; i < line.size();) {
        const uint8_t* v = in.take(4);
        if (v[0] != 1 || v[1] != 1 || v[2] != 1) {
            line[i++] = {v[0], v[1], v[2], v[3]};
            shift = 0;
            continue;
        }
        // Four counts already exceed any scanline, and a shift by more than the word's bits is not defined.
        const size_t n = shift < 32 ? size_t(v[3]) << shift : 0;
        if (n == 0) fail_broken(where, "a run of 0 pixels");
        if (i == 0 || n > line.size() - i) fail_broken(where, "a run does not fit its scanline");
        for (size_t k = 0; k < n; ++k, ++i) line[i] = line[i - 1];
        shift += 8;
    }
}

void read_scanline(ByteReader& in, std::vector<Rgbe>& line, const std::string& where) {
    const size_t n = line.size(), start = in.at();
    // The new form begins with 2, 2 and the length in 15 bits, so it exists for these lengths only. Old files
    // may begin with any pixel: then the four bytes are read again.
    if (n >= 8 && n < 32768) {
        const uint8_t* mark = in.take(4);
        if (mark[0] == 2 && mark[1] == 2 && mark[2] < 128) {
            const size_t claimed = size_t(mark[2]) << 8 | mark[3];
            if (claimed != n)
                fail_broken(where, "a scanline of " + std::to_string(claimed) + " pixels, " +
                                       std::to_string(n) + " are due");
            return read_new_runs(in, line, where);
        }
        in.seek(start);
    }
    read_old_runs(in, line, where);
}

/// Factors of the mantissas, by the exponent's byte.
std::array<float, 256> scales() {
    std::array<float, 256> table{};
    // A mantissa of 8 bits stands for m/256, the exponent has a bias of 128: m·2^(e − 136). Exponent 0 is
    // black.
    for (int e = 1; e < 256; ++e) table[size_t(e)] = std::ldexp(1.f, e - (128 + 8));
    return table;
}

/// The fewest bytes that a scanline of n pixels takes: a pixel, and an old run of any number of pixels.
uint64_t least_bytes(int n) { return n == 1 ? 4 : 8; }

}  // namespace

Image decode_hdr(std::string_view bytes, const std::string& where) {
    ByteReader in(bytes, where);
    const Layout layout = read_hdr_header(in, where);
    Image image =
        empty_image(uint64_t(layout.width), uint64_t(layout.height), 3, where, false, kMaxFloatPixels);
    check_holds(in.left(), least_bytes(layout.length()) * uint64_t(layout.lines()), image);
    // Old runs claim many pixels with few bytes: memory is touched line by line where the order allows it.
    const size_t row = size_t(layout.width) * 3, all = row * size_t(layout.height);
    const bool in_order = !layout.columns && !layout.from_bottom;
    image.pixels.reserve(all);
    const std::array<float, 256> scale_of = scales();
    std::vector<Rgbe> line(size_t(layout.length()));
    // Pixels of a scanline are a constant number of floats apart, negative if it runs backwards. A line of
    // one pixel takes no step.
    const auto step = 3 * (ptrdiff_t(layout.index(0, 1)) - ptrdiff_t(layout.index(0, 0)));
    for (int l = 0; l < layout.lines(); ++l) {
        read_scanline(in, line, where);
        image.pixels.resize(in_order ? row * size_t(l + 1) : all);
        float* const first = &image.pixels[layout.index(l, 0) * 3];
        for (int i = 0; i < layout.length(); ++i) {
            const Rgbe& p = line[size_t(i)];
            const float scale = scale_of[p.v[3]];
            for (int c = 0; c < 3; ++c) first[i * step + c] = float(p.v[c]) * scale;
        }
    }
    return image;
}

}  // namespace viscache::loading
