// libFuzzer: bytes of a picture are decoded, or refused with a SceneError. Pixels are finite.
// VISCACHE_FUZZ_FORMAT: png, jpg, hdr, bmp or tga; the corpus decides which decoder is met.
#include <cmath>
#include <cstdint>
#include <new>
#include <string_view>

#include "viscache/formats/decode_image.h"

namespace {

void decode(std::string_view content) {
    using namespace viscache;
    const Image image = loading::decode_image(content, VISCACHE_FUZZ_FORMAT, true);
    if (image.size() != size_t(image.width) * size_t(image.height) * size_t(image.channels)) std::abort();
    for (const float at : {0.f, 0.3f, 0.999f}) {
        const Rgb c = sample_image(image, {at, 1 - at}).rgb;
        if (!(std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z))) std::abort();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    try {
        decode({reinterpret_cast<const char*>(data), size});
    } catch (const viscache::SceneError&) {
    } catch (const std::bad_alloc&) {
    }
    return 0;
}
