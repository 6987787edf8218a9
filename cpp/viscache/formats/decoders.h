#pragma once
// One decoder per image format. Each reads a whole file in memory, refuses what its bytes cannot hold before
// memory is taken for it, and throws SceneError (place, what was found) for broken files.
#include <cstdint>
#include <string>
#include <string_view>

#include "viscache/formats/loading.h"
#include "viscache/scene/image.h"

namespace viscache::loading {

constexpr uint64_t kMaxPixels = uint64_t(1) << 28;       ///< of images of 8 bits
constexpr uint64_t kMaxFloatPixels = uint64_t(1) << 27;  ///< of images of more bits: they are kept as floats

/// `srgb`: values of 8 and 16 bits are encoded colour. The path of the result is empty.
Image decode_png(std::string_view bytes, const std::string& where, bool srgb);
Image decode_jpeg(std::string_view bytes, const std::string& where, bool srgb);
Image decode_bmp(std::string_view bytes, const std::string& where, bool srgb);
Image decode_tga(std::string_view bytes, const std::string& where, bool srgb);
Image decode_hdr(std::string_view bytes, const std::string& where);

/// A TGA file has no signature: whether the 18 bytes of its header make sense.
bool looks_like_tga(std::string_view bytes);

/// An image without pixels. Refuses empty and too large sizes.
Image empty_image(uint64_t width, uint64_t height, int channels, const std::string& where, bool srgb,
                  uint64_t most_pixels = kMaxPixels);

/// Refuses a file that has fewer than `needed` bytes for what its header claims.
void check_holds(uint64_t have, uint64_t needed, const Image& image);

[[noreturn]] inline void fail_broken(const std::string& where, const std::string& what) {
    fail(where, "the image is broken: " + what);
}

/// Reads little-endian numbers; refuses to read past the end.
class ByteReader {
public:
    ByteReader(std::string_view bytes, const std::string& where) : bytes_(bytes), where_(where) {}
    size_t left() const { return bytes_.size() - at_; }
    size_t at() const { return at_; }
    void seek(uint64_t at) {
        if (at > bytes_.size()) end();
        at_ = size_t(at);
    }
    uint8_t u8() { return *take(1); }
    uint16_t u16() { return uint16_t(number(2)); }
    uint32_t u32() { return uint32_t(number(4)); }
    /// A number of `n` bytes, 1 to 4.
    uint64_t number(size_t n) {
        const uint8_t* p = take(n);
        uint64_t value = 0;
        for (size_t i = 0; i < n; ++i) value |= uint64_t(p[i]) << (8 * i);
        return value;
    }
    const uint8_t* take(size_t n) {
        if (n > left()) end();
        const auto* p = reinterpret_cast<const uint8_t*>(bytes_.data()) + at_;
        at_ += n;
        return p;
    }

private:
    [[noreturn]] void end() const { fail_broken(where_, "the file ends too early"); }
    std::string_view bytes_;
    const std::string& where_;
    size_t at_ = 0;
};

}  // namespace viscache::loading
