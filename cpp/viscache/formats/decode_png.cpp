// PNG, read by libpng. Its errors come back by longjmp, so that the functions between setjmp and libpng hold
// no objects with destructors; what they fill belongs to `decode_png`.
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

#include "viscache/formats/decoders.h"

namespace viscache::loading {

namespace {

constexpr uint64_t kMostInflation = 1032;  // of deflate: 258 bytes for two bits

struct PngReader {
    std::string_view bytes;
    size_t at = 0;
    png_structp png = nullptr;
    png_infop info = nullptr;
    size_t stored_row_bytes = 0;  ///< in the file, inflated
    std::jmp_buf failed;
    std::array<char, 200> message{};

    explicit PngReader(std::string_view given) : bytes(given) {}
    PngReader(const PngReader&) = delete;
    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void on_png_error(png_structp png, png_const_charp message) {
    auto& reader = *static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader.message.data(), message, reader.message.size() - 1);
    std::longjmp(reader.failed, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep out, size_t n) {
    auto& reader = *static_cast<PngReader*>(png_get_io_ptr(png));
    if (n > reader.bytes.size() - reader.at) png_error(png, "the file ends too early");
    std::memcpy(out, reader.bytes.data() + reader.at, n);
    reader.at += n;
}

/// Up to the pixels, and how they are to be given: grey or RGB, with alpha where there is any, of 8 or 16
/// bits.
bool read_png_head(PngReader& reader) {
    if (setjmp(reader.failed)) return false;
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_png_error, on_warning);
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info) return false;
    png_set_read_fn(reader.png, &reader, on_read);
    png_set_user_limits(reader.png, 0x7fffffff, 0x7fffffff);  // `empty_image` limits the number of pixels
    png_read_info(reader.png, reader.info);
    reader.stored_row_bytes = png_get_rowbytes(reader.png, reader.info);
    png_set_expand(reader.png);  // palettes, fewer than 8 bits and tRNS
    png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    return true;
}

bool read_png_rows(PngReader& reader, png_bytepp rows) {
    if (setjmp(reader.failed)) return false;
    png_read_image(reader.png, rows);
    return true;
}

[[noreturn]] void fail_with(const PngReader& reader, const std::string& where) {
    fail_broken(where, reader.message[0] ? reader.message.data() : "libpng cannot be used");
}

/// The linear floats of big-endian values of 16 bits.
void set_deep_pixels(Image& image, const std::vector<uint8_t>& stored) {
    std::vector<float> plain(1 << 16), linear(1 << 16);
    for (size_t v = 0; v < plain.size(); ++v) {
        plain[v] = float(v) / 65535.f;
        linear[v] = image.srgb ? srgb_to_linear(plain[v]) : plain[v];
    }
    image.pixels.resize(stored.size() / 2);
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        const size_t v = size_t(stored[2 * i]) << 8 | stored[2 * i + 1];
        image.pixels[i] = image.is_alpha(int(i % size_t(image.channels))) ? plain[v] : linear[v];
    }
}

}  // namespace

Image decode_png(std::string_view bytes, const std::string& where, bool srgb) {
    PngReader reader(bytes);
    if (!read_png_head(reader)) fail_with(reader, where);
    const uint64_t width = png_get_image_width(reader.png, reader.info),
                   height = png_get_image_height(reader.png, reader.info);
    const bool is_deep = png_get_bit_depth(reader.png, reader.info) == 16;
    Image image = empty_image(width, height, png_get_channels(reader.png, reader.info), where, srgb,
                              is_deep ? kMaxFloatPixels : kMaxPixels);
    check_holds(bytes.size() * kMostInflation, height * (1 + uint64_t(reader.stored_row_bytes)), image);

    const size_t row_bytes = png_get_rowbytes(reader.png, reader.info);
    std::vector<uint8_t> stored(row_bytes * size_t(height));
    std::vector<png_bytep> rows(static_cast<size_t>(height));
    for (size_t y = 0; y < rows.size(); ++y) rows[y] = stored.data() + y * row_bytes;
    if (!read_png_rows(reader, rows.data())) fail_with(reader, where);
    if (is_deep)
        set_deep_pixels(image, stored);
    else
        image.bytes = std::move(stored);
    return image;
}

}  // namespace viscache::loading
