#include "viscache/scene/decode_image.h"

#include <array>
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_HDR
#define STBI_ONLY_TGA
#define STBI_ONLY_BMP
#define STBI_NO_STDIO
#define STBI_ASSERT(x) ((void)0)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image.h>
#pragma GCC diagnostic pop

#include "viscache/scene/spectra.h"

namespace viscache::loading {

namespace {

constexpr uint64_t kMaxPixels = uint64_t(1) << 28;

struct StbFree {
    void operator()(void* p) const { stbi_image_free(p); }
};

bool is_alpha(int channel, int channels) {
    return (channels == 2 || channels == 4) && channel == channels - 1;
}

/// Converts 8-bit values to float with a lookup table.
void decode_bytes(Image& image, const stbi_uc* data, bool srgb) {
    std::array<float, 256> plain, linear;
    for (int i = 0; i < 256; ++i) {
        plain[i] = float(i) / 255.f;
        linear[i] = srgb ? srgb_to_linear(plain[i]) : plain[i];
    }
    const int channels = image.channels;
    for (size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = is_alpha(int(i % size_t(channels)), channels) ? plain[data[i]] : linear[data[i]];
}

}  // namespace

Image decode_image(std::string_view bytes, const std::string& where, bool srgb) {
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    if (bytes.size() > 0x7fffffff) fail(where, "the image file is larger than 2 GiB");
    const int size = int(bytes.size());
    Image image;
    image.where = where;
    image.srgb = srgb;
    if (!stbi_info_from_memory(data, size, &image.width, &image.height, &image.channels))
        fail(where, std::string("the image cannot be read (PNG, JPEG, HDR, TGA or BMP is expected): ") +
                        stbi_failure_reason());
    const uint64_t pixels = uint64_t(image.width) * uint64_t(image.height);
    if (pixels == 0 || pixels > kMaxPixels)
        fail(where, "the image has " + std::to_string(pixels) + " pixels; 1 to 2^28 are read");
    int w = 0, h = 0, c = 0;
    if (stbi_is_hdr_from_memory(data, size)) {
        std::unique_ptr<float, StbFree> loaded(stbi_loadf_from_memory(data, size, &w, &h, &c, 0));
        if (!loaded) fail(where, std::string("the image is broken: ") + stbi_failure_reason());
        image.width = w;
        image.height = h;
        image.channels = c;
        image.pixels.assign(loaded.get(), loaded.get() + size_t(w) * size_t(h) * size_t(c));
        return image;
    }
    std::unique_ptr<stbi_uc, StbFree> loaded(stbi_load_from_memory(data, size, &w, &h, &c, 0));
    if (!loaded) fail(where, std::string("the image is broken: ") + stbi_failure_reason());
    image.width = w;
    image.height = h;
    image.channels = c;
    image.pixels.resize(size_t(w) * size_t(h) * size_t(c));
    decode_bytes(image, loaded.get(), srgb);
    return image;
}

namespace {

/// Decodes image `i` in place. Returns false if the file is unusable and that is not an error.
bool decode_pending(Loading& loading, Image& image) {
    try {
        const std::string bytes = read_file(image.path, image.where);
        if (extension_of(image.path) == ".exr") return true;
        Image decoded = decode_image(bytes, image.where + ": " + image.path, image.srgb);
        decoded.path = image.path;
        decoded.where = image.where;
        decoded.nearest = image.nearest;
        image = std::move(decoded);
        return true;
    } catch (const SceneError& error) {
        if (loading.strict) throw;
        loading.scene.warnings.push_back({image.where, std::string(error.what()) + "; it is left out"});
        return false;
    }
}

}  // namespace

void decode_images(Loading& loading) {
    SceneDescription& scene = loading.scene;
    std::vector<int> moved_to(scene.images.size(), -1);
    std::vector<Image> kept;
    for (size_t i = 0; i < scene.images.size(); ++i) {
        Image& image = scene.images[i];
        if (image.width == 0 && !decode_pending(loading, image)) continue;
        moved_to[i] = int(kept.size());
        kept.push_back(std::move(image));
    }
    scene.images = std::move(kept);
    // References come next. A material that loses its base texture keeps half of its base colour.
    for (Material& m : scene.materials) {
        if (m.base_texture >= 0 && moved_to[size_t(m.base_texture)] < 0) m.base_color = m.base_color * 0.5f;
        if (m.base_texture >= 0) m.base_texture = moved_to[size_t(m.base_texture)];
        if (m.alpha_texture >= 0) m.alpha_texture = moved_to[size_t(m.alpha_texture)];
    }
    if (scene.environment && scene.environment->image >= 0) {
        scene.environment->image = moved_to[size_t(scene.environment->image)];
        if (scene.environment->image < 0) scene.environment.reset();
    }
}

ImageMean mean_of(const Image& image) {
    double sum[4] = {};
    const int n = image.channels;
    const size_t pixels = n > 0 ? image.pixels.size() / size_t(n) : 0;
    for (size_t i = 0; i < pixels; ++i)
        for (int c = 0; c < n; ++c) sum[c] += image.pixels[i * size_t(n) + size_t(c)];
    for (double& s : sum) s /= double(std::max<size_t>(pixels, 1));
    ImageMean mean;
    mean.color = n >= 3 ? Rgb{float(sum[0]), float(sum[1]), float(sum[2])}
                        : Rgb{float(sum[0]), float(sum[0]), float(sum[0])};
    if (n == 2 || n == 4) mean.alpha = float(sum[n - 1]);
    return mean;
}

}  // namespace viscache::loading
