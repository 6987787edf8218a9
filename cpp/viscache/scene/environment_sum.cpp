#include "viscache/scene/environment_sum.h"

#include "viscache/math/parallel.h"
#include "viscache/scene/envmap.h"

namespace viscache {

namespace {

constexpr int kLooks = 4;  ///< look-ups along the edge of a pixel

Rgb pixel_of(const Image& image, size_t i) {
    const auto n = size_t(image.channels);
    if (n < 3) return Rgb{1, 1, 1} * image.value(i * n);
    return {image.value(i * n), image.value(i * n + 1), image.value(i * n + 2)};
}

/// Means over the pixels of a lat-long map of width × height with this rotation, row by row. They have the
/// power of `sky`.
std::vector<Rgb> means_over_pixels(const EnvironmentMap& sky, int width, int height, const Affine& to_world,
                                   int threads) {
    std::vector<Rgb> means(size_t(width) * size_t(height));
    const auto rows = size_t(height);
    std::vector<double> power(rows);
    parallel_for(rows, threads, [&](size_t row, int) {
        std::vector<Vec3> wi(size_t(width) * kLooks);
        std::vector<EnvironmentMap::Sample> found(wi.size());
        Rgb* const pixels = &means[row * size_t(width)];
        for (int j = 0; j < kLooks; ++j) {
            const double theta = M_PI * (double(row) + (j + 0.5) / kLooks) / height;
            for (size_t i = 0; i < wi.size(); ++i) {
                const double phi = 2 * M_PI * (double(i) + 0.5) / double(wi.size());
                wi[i] =
                    normalize(to_world.vector({float(std::sin(theta) * std::sin(phi)), float(std::cos(theta)),
                                               float(-std::sin(theta) * std::cos(phi))}));
            }
            sky.look_up(wi, found);
            for (size_t i = 0; i < wi.size(); ++i)
                pixels[i / kLooks] += found[i].radiance / float(kLooks * kLooks);
        }
        const double solid_angle =
            2 * M_PI / width *
            (std::cos(M_PI * double(row) / height) - std::cos(M_PI * double(row + 1) / height));
        for (int x = 0; x < width; ++x) power[row] += luminance_in_double(pixels[x]) * solid_angle;
    });
    double sum = 0;
    for (const double p : power) sum += p;
    const auto correction = float(sum > 0 ? sky.total_power() / sum : 1);
    for (Rgb& mean : means) mean = mean * correction;
    return means;
}

}  // namespace

void add_up_environments(SceneDescription& d, int threads) {
    if (d.added_environments.empty()) return;
    std::vector<Environment> skies;
    if (d.environment) skies.push_back(*d.environment);
    skies.insert(skies.end(), d.added_environments.begin(), d.added_environments.end());
    d.added_environments.clear();
    Rgb constant{};
    const Environment* largest = nullptr;
    const auto size = [&](const Environment& e) { return d.images[size_t(e.image)].size(); };
    for (const Environment& e : skies)
        if (e.image < 0)
            constant += e.scale;
        else if (!largest || size(e) > size(*largest))
            largest = &e;
    d.environment = Environment{constant, -1, {}};
    if (!largest) return;
    const Image& model = d.images[size_t(largest->image)];
    const Affine to_world = largest->to_world;
    const size_t pixels = size_t(model.width) * size_t(model.height);
    std::vector<Rgb> sum(pixels, constant);
    for (const Environment& e : skies) {
        if (e.image < 0) continue;
        const Image& image = d.images[size_t(e.image)];
        if (image.width == model.width && image.height == model.height && e.to_world.m == to_world.m) {
            for (size_t i = 0; i < pixels; ++i) sum[i] += pixel_of(image, i) * e.scale;
            continue;
        }
        const auto sky = EnvironmentMap::from_latlong(image, e.scale, e.to_world, 0, threads);
        const auto means = means_over_pixels(sky, model.width, model.height, to_world, threads);
        for (size_t i = 0; i < pixels; ++i) sum[i] += means[i];
    }
    Image added;
    added.path = model.path;
    added.where = model.where;
    added.srgb = false;
    added.width = model.width;
    added.height = model.height;
    added.channels = 3;
    added.pixels.reserve(3 * pixels);
    for (const Rgb& c : sum) added.pixels.insert(added.pixels.end(), {c.x, c.y, c.z});
    d.environment = Environment{{1, 1, 1}, int(d.images.size()), to_world};
    d.images.push_back(std::move(added));
}

}  // namespace viscache
