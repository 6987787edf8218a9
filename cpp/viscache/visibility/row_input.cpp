#include "viscache/visibility/row_input.h"

#include "viscache/visibility/shadow_ray.h"

namespace viscache {

namespace {

/// Bits of the far ends above the plane through p with normal n; for directions, p is the origin.
void upper_hemisphere(const FarEnds& ends, Vec3 p, Vec3 n, std::span<Word> row) {
    for (size_t w = 0; w < words_for(ends.count); ++w) {
        uint8_t above[kWordBits];
        const size_t first = w * kWordBits;
        for (size_t j = 0; j < kWordBits; ++j)
            above[j] = (ends.x[first + j] - p.x) * n.x + (ends.y[first + j] - p.y) * n.y +
                           (ends.z[first + j] - p.z) * n.z >
                       0;
        Word bits = 0;
        for (size_t j = 0; j < kWordBits; ++j) bits |= Word{above[j]} << j;
        row[w] = bits;
    }
    // Padding columns are zero vectors, which may lie above a plane
    if (const size_t used = ends.count % kWordBits) row[ends.count / kWordBits] &= (Word{1} << used) - 1;
}

}  // namespace

FarEnds far_ends(std::span<const Vec3> directions, float t_max) {
    FarEnds sky;
    sky.semantic = Semantic::kDirection;
    sky.group = int(LightGroup::kAmbient);
    sky.count = directions.size();
    sky.t_max = t_max;
    for (auto* v : {&sky.x, &sky.y, &sky.z, &sky.nx, &sky.ny, &sky.nz, &sky.density})
        v->resize(row_words_for(sky.count) * kWordBits);
    for (size_t k = 0; k < sky.count; ++k) {
        sky.x[k] = directions[k].x;
        sky.y[k] = directions[k].y;
        sky.z[k] = directions[k].z;
    }
    sky.tx = sky.x;
    sky.ty = sky.y;
    sky.tz = sky.z;
    return sky;
}

void RowBlock::fill(const RowInput& input, const FarEnds& ends, std::span<const uint32_t> points,
                    float extent) {
    const bool along = is_direction(ends.semantic);
    eyes.clear();
    wanted.reset(points.size(), ends.count);
    for (size_t i = 0; i < points.size(); ++i) {
        const Vec3 position = input.position[points[i]], normal = input.normal[points[i]];
        eyes.position.push_back(position);
        eyes.normal.push_back(normal);
        eyes.origin.push_back(spawn(position, normal, extent));
        upper_hemisphere(ends, along ? Vec3{} : position, normal, wanted.row_span(i));
    }
}

}  // namespace viscache
