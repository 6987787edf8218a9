#include "viscache/vismap/node_directions.h"

#include <array>

#include "viscache/math/morton.h"
#include "viscache/math/octahedral.h"

namespace viscache {

namespace {

constexpr int kLast = kDeepestLevel + kSampleLevels;

/// Direction of a point inside a node; at_x and at_y are in [0, 1].
Vec3 direction(uint32_t code, int level, float at_x, float at_y) {
    const float cells = float(1 << level);
    return equal_area_to_direction(
        {(float(gather2(code)) + at_x) / cells, (float(gather2(code >> 1)) + at_y) / cells});
}

DirectionTable centres(int level) {
    DirectionTable t;
    const size_t n = size_t{1} << (2 * level);
    t.x.resize(n);
    t.y.resize(n);
    t.z.resize(n);
    for (size_t i = 0; i < n; ++i) {
        const Vec3 d = direction(uint32_t(i), level, 0.5f, 0.5f);
        t.x[i] = d.x;
        t.y[i] = d.y;
        t.z[i] = d.z;
    }
    return t;
}

/// Largest angle between the centre and sample points of the border, enlarged by 10 % for the points between
/// them.
std::vector<float> radius_sines(int level) {
    // The border of a node is curved on the sphere; four steps per side sample it.
    constexpr int kSteps = 4;
    std::vector<float> sines(size_t{1} << (2 * level));
    for (size_t i = 0; i < sines.size(); ++i) {
        const Vec3 centre = node_centres(level).at(i);
        float chord2 = 0;
        for (int k = 0; k <= kSteps; ++k) {
            const float t = float(k) / kSteps;
            for (const Vec2 p : {Vec2{t, 0}, Vec2{t, 1}, Vec2{0, t}, Vec2{1, t}})
                chord2 = std::max(chord2, length2(direction(uint32_t(i), level, p.x, p.y) - centre));
        }
        sines[i] = 1.1f * std::sqrt(chord2);  // a chord is longer than the sine
    }
    return sines;
}

}  // namespace

// Tables are made at the first use and then only read, so threads share them without a lock.
const DirectionTable& node_centres(int level) {
    static const std::array tables = [] {
        std::array<DirectionTable, kLast - kBaseLevel + 1> t;
        for (int l = kBaseLevel; l <= kLast; ++l) t[size_t(l - kBaseLevel)] = centres(l);
        return t;
    }();
    return tables[size_t(level - kBaseLevel)];
}

std::span<const float> node_radius_sines(int level) {
    static const std::array tables = [] {
        std::array<std::vector<float>, kDeepestLevel - kBaseLevel + 1> t;
        for (int l = kBaseLevel; l <= kDeepestLevel; ++l) t[size_t(l - kBaseLevel)] = radius_sines(l);
        return t;
    }();
    return tables[size_t(level - kBaseLevel)];
}

}  // namespace viscache
