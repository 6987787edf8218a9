#include "viscache/formats/decode_image.h"

#include "viscache/formats/decoders.h"

namespace viscache::loading {

Image empty_image(uint64_t width, uint64_t height, int channels, const std::string& where, bool srgb,
                  uint64_t most_pixels) {
    if (width == 0 || height == 0) fail_broken(where, "it has no pixels");
    if (width > most_pixels || height > most_pixels / width)
        fail(where, "the image has " + std::to_string(width) + " x " + std::to_string(height) +
                        " pixels; at most 2^" + (most_pixels == kMaxPixels ? "28" : "27") +
                        " are read, or 2^27 with more than 8 bits");
    Image image;
    image.where = where;
    image.srgb = srgb;
    image.width = int(width);
    image.height = int(height);
    image.channels = channels;
    return image;
}

void check_holds(uint64_t have, uint64_t needed, const Image& image) {
    if (have < needed)
        fail_broken(image.where, "the file is too short for the " + std::to_string(image.width) + " x " +
                                     std::to_string(image.height) + " pixels of its header");
}

Image decode_image(std::string_view bytes, const std::string& where, bool srgb) {
    if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return decode_png(bytes, where, srgb);
    if (bytes.starts_with("\xff\xd8\xff")) return decode_jpeg(bytes, where, srgb);
    if (bytes.starts_with("#?")) return decode_hdr(bytes, where);
    if (bytes.starts_with("BM")) return decode_bmp(bytes, where, srgb);
    if (looks_like_tga(bytes)) return decode_tga(bytes, where, srgb);
    fail(where, "the image cannot be read (PNG, JPEG, HDR, TGA or BMP is expected)");
}

namespace {

/// Decodes image `i` in place. Returns false if the file is unusable and that is not an error.
bool decode_pending(Loading& loading, Image& image) {
    try {
        if (extension_of(image.path) == ".exr") return check_file(image.path, image.where) > 0;
        Image decoded =
            decode_image(read_file(image.path, image.where), image.where + ": " + image.path, image.srgb);
        decoded.path = image.path;
        decoded.where = image.where;
        set_look_up(decoded, {image.nearest, image.wrap_u, image.wrap_v});
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
    // References come next. A lamp whose picture is gone is dark: most of such pictures are.
    for (Mesh& mesh : scene.meshes) {
        if (mesh.emission_texture < 0) continue;
        mesh.emission_texture = moved_to[size_t(mesh.emission_texture)];
        if (mesh.emission_texture < 0) mesh.emission = {};
    }
    // A material that loses its base texture keeps half of its base colour.
    for (Material& m : scene.materials) {
        if (m.base_texture >= 0 && moved_to[size_t(m.base_texture)] < 0) m.base_color = m.base_color * 0.5f;
        for (int* t :
             {&m.base_texture, &m.alpha_texture, &m.metallic_roughness_texture, &m.roughness_texture})
            if (*t >= 0) *t = moved_to[size_t(*t)];
    }
    // False for a sky whose image is gone
    const auto moved = [&](Environment& sky) {
        return sky.image < 0 || (sky.image = moved_to[size_t(sky.image)]) >= 0;
    };
    if (scene.environment && !moved(*scene.environment)) scene.environment.reset();
    std::erase_if(scene.added_environments, [&](Environment& sky) { return !moved(sky); });
}

ImageMean mean_of(const Image& image) {
    double sum[4] = {};
    const int n = image.channels;
    const size_t pixels = n > 0 ? image.size() / size_t(n) : 0;
    for (size_t i = 0; i < pixels; ++i)
        for (int c = 0; c < n; ++c) sum[c] += image.value(i * size_t(n) + size_t(c));
    for (double& s : sum) s /= double(std::max<size_t>(pixels, 1));
    ImageMean mean;
    mean.color = n >= 3 ? Rgb{float(sum[0]), float(sum[1]), float(sum[2])}
                        : Rgb{float(sum[0]), float(sum[0]), float(sum[0])};
    if (n == 2 || n == 4) mean.alpha = float(sum[n - 1]);
    return mean;
}

}  // namespace viscache::loading
