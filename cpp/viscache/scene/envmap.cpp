#include "viscache/scene/envmap.h"

#include <sstream>

#include "viscache/math/equal_area_batch.h"
#include "viscache/math/octahedral.h"
#include "viscache/scene/latlong_resample.h"

namespace viscache {

namespace {

constexpr size_t whole_lanes(size_t n) {
    return (n + kEqualAreaLanes - 1) / kEqualAreaLanes * kEqualAreaLanes;
}
// Whole registers: the last lanes repeat a direction
static_assert(Distribution2D::kBatch % kEqualAreaLanes == 0);

}  // namespace

EnvironmentMap EnvironmentMap::constant(Rgb radiance) {
    if (!usable_radiance(radiance)) {
        std::ostringstream s;
        s << "environment radiance must be finite and >= 0, got (" << radiance.x << ", " << radiance.y << ", "
          << radiance.z << ")";
        throw SceneError(s.str());
    }
    EnvironmentMap map;
    // One texel, and no distribution: a constant sky is sampled evenly
    map.texels_ = OctahedralTexels(1);
    map.texels_[0] = radiance;
    map.total_power_ = map.texels_.power();
    return map;
}

EnvironmentMap EnvironmentMap::from_latlong(const Image& image, Rgb scale, const Affine& to_world,
                                            int resolution, int threads) {
    ResampledImage resampled = resample_latlong(image, scale, to_world, resolution, threads);
    EnvironmentMap map;
    map.texels_ = std::move(resampled.texels);
    map.power_ratio_ = resampled.power_ratio;
    map.total_power_ = map.texels_.power();
    if (map.total_power_ > 0) {
        const auto n = size_t(map.resolution());
        map.choice_ = Distribution2D(n, n, [&](size_t row, size_t column) {
            // Texels have equal areas on the sphere, so luminance alone is the weight
            return luminance_in_double(map.texels_[map.texels_.index(column, row)]);
        });
    }
    return map;
}

size_t EnvironmentMap::texel(Vec2 p) const {
    const int n = resolution();
    // 1 may come from rounding
    return texels_.index(size_t(std::min(int(p.x * float(n)), n - 1)),
                         size_t(std::min(int(p.y * float(n)), n - 1)));
}

/// Directions are sampled in proportion to luminance, so their density follows from the texel alone.
float EnvironmentMap::density(const Rgb& radiance) const {
    return choice_.empty() ? 1 / (4 * kPi) : float(luminance_in_double(radiance) / total_power_);
}

void EnvironmentMap::look_up(std::span<const Vec3> wi, std::span<Sample> found) const {
    constexpr size_t kBatch = Distribution2D::kBatch;
    const Rgb* place[kBatch];
    alignas(64) float x[kBatch], y[kBatch], z[kBatch], u[kBatch], v[kBatch];
    for (size_t first = 0; first < wi.size(); first += kBatch) {
        const size_t count = std::min(kBatch, wi.size() - first), whole = whole_lanes(count);
        for (size_t i = 0; i < whole; ++i) {
            const Vec3 d = wi[first + std::min(i, count - 1)];
            x[i] = d.x;
            y[i] = d.y;
            z[i] = d.z;
        }
        if (!is_constant()) directions_to_equal_area(x, y, z, whole, u, v);
        for (size_t i = 0; i < count; ++i) {
            place[i] = &texels_[is_constant() ? 0 : texel({u[i], v[i]})];
            // Texels of a large map lie anywhere in memory: all are on their way before the first
            // is read
            __builtin_prefetch(place[i]);
        }
        for (size_t i = 0; i < count; ++i) found[first + i] = {wi[first + i], *place[i], density(*place[i])};
    }
}

void EnvironmentMap::sample(std::span<const Vec2> u, std::span<Sample> samples) const {
    if (choice_.empty()) {
        for (size_t i = 0; i < u.size(); ++i) {
            const Vec3 wi = equal_area_to_direction(u[i]);
            samples[i] = {wi, eval(wi), density({})};
        }
        return;
    }
    // Stay farther from the texel's edges than the rounding error of a direction, so that `eval(wi)` finds
    // this texel
    const float n = float(resolution()), margin = n * 0x1p-21f;
    const auto place = [&](size_t index, float jitter) {
        return (float(index) + std::clamp(jitter, margin, 1 - margin)) / n;
    };
    static_assert(OctahedralTexels::kTile % Distribution2D::kBlock == 0, "a block lies side by side");
    const auto block = [&](size_t row, size_t column) { return &texels_[texels_.index(column, row)]; };
    constexpr size_t kBatch = Distribution2D::kBatch;
    Distribution2D::Cell cells[kBatch];
    alignas(64) float column[kBatch], row[kBatch], x[kBatch], y[kBatch], z[kBatch];
    for (size_t first = 0; first < u.size(); first += kBatch) {
        const size_t count = std::min(kBatch, u.size() - first), whole = whole_lanes(count);
        choice_.sample(
            count, [&](size_t i) { return std::pair(u[first + i].x, u[first + i].y); }, block,
            luminance_in_double, cells);
        for (size_t i = 0; i < whole; ++i) {
            const auto& c = cells[std::min(i, count - 1)];
            column[i] = place(c.column, c.u_column);
            row[i] = place(c.row, c.u_row);
        }
        equal_area_to_directions(column, row, whole, x, y, z);
        for (size_t i = 0; i < count; ++i) {
            const Rgb& pixel = texels_[texels_.index(cells[i].column, cells[i].row)];
            samples[first + i] = {{x[i], y[i], z[i]}, pixel, density(pixel)};
        }
    }
}

}  // namespace viscache
