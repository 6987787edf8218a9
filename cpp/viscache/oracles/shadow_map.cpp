#include "viscache/oracles/shadow_map.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "viscache/visibility/parameter_row.h"
#include "viscache/visibility/query.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

namespace {

constexpr size_t kFaces = 6;
constexpr size_t kBandRows = 4;      // rows of texels traced together, in squares of 4 × 4 texels
constexpr size_t kPieceRays = 1024;  // rays per call of the caster
constexpr float kGrow = 1.0001f;     // enlarges the directional map, so that points on the sphere lie inside
constexpr float kBehind = 2.f;       // distance of the origin of directional depths from the centre, in radii

size_t faces_of(Semantic s) { return is_direction(s) ? 1 : kFaces; }

/// Texel of a coordinate in [-1, 1]. A coordinate outside, or NaN, belongs to the border.
inline uint32_t texel_of(float u, float resolution) {
    float t = 0.5f * (u + 1.f) * resolution;
    // Comparisons that are false for NaN, so that it ends at the border
    t = t > 0 ? t : 0;
    t = t < resolution - 1 ? t : resolution - 1;
    return uint32_t(t);
}

}  // namespace

ShadowMaps::ShadowMaps(const RayCaster& caster, const ShadowMapExtent& extent,
                       const ShadowMapSettings& settings, std::span<const FarEnds* const> lights, int threads,
                       Control& control)
    : extent_(extent),
      resolution_(settings.resolution),
      bias_(float(settings.bias) * 2 * extent.radius),
      slope_(float(settings.slope_bias) / float(settings.resolution)) {
    settings.validate();
    // Check the memory of all maps before any is allocated
    const size_t square = size_t(resolution_) * size_t(resolution_);
    uint64_t bytes = 0;
    // All groups together, in 64 bits: one map of 16384² has 1 GiB
    for (const FarEnds* l : lights) bytes += l->count * faces_of(l->semantic) * square * sizeof(float);
    if (bytes > settings.max_bytes)
        throw std::invalid_argument("max_bytes must be >= " + std::to_string(bytes) +
                                    " for the shadow maps of these lights, got " +
                                    std::to_string(settings.max_bytes));
    // Bands of rows of all maps are distributed over threads
    struct Band {
        const FarEnds* lights;
        size_t light, first, last;
    };
    std::vector<Band> bands;
    for (const FarEnds* l : lights) {
        const size_t rows = faces_of(l->semantic) * size_t(resolution_);
        Group& group = groups_[size_t(l->group)];
        group = {l->semantic, l->count, rows * size_t(resolution_), {}};
        group.depth.resize(group.count * group.texels);
        for (size_t k = 0; k < l->count; ++k)
            for (size_t row = 0; row < rows; row += kBandRows)
                bands.push_back({l, k, row, std::min(row + kBandRows, rows)});
    }
    control.total = bands.size();
    parallel_for(bands.size(), threads, [&](size_t i, int) {
        control.check();
        trace_rows(caster, *bands[i].lights, bands[i].light, bands[i].first, bands[i].last);
        control.done.fetch_add(1);
    });
    control.done = 0;
}

/// Traces rows [first, last) of the maps of a light, in squares of neighbouring texels. The faces are stacked
/// vertically.
void ShadowMaps::trace_rows(const RayCaster& caster, const FarEnds& lights, size_t k, size_t first,
                            size_t last) {
    Group& group = groups_[size_t(lights.group)];
    // Bands of a map write separate rows: no lock
    float* depth = group.depth.data() + k * group.texels;
    const size_t columns = size_t(resolution_);
    std::vector<Ray> rays;
    std::vector<size_t> texels;
    std::vector<Hit> hits(kPieceRays);
    const auto flush = [&] {
        caster.intersect(rays, std::span(hits).first(rays.size()), Coherence::kCoherent);
        for (size_t i = 0; i < rays.size(); ++i) depth[texels[i]] = hits[i].valid() ? hits[i].t : kInfinity;
        rays.clear();
        texels.clear();
    };
    // In squares, so that the rays of a packet stay close in both directions
    for (size_t left = 0; left < columns; left += kBandRows)
        for (size_t row = first; row < last; ++row)
            for (size_t column = left; column < std::min(left + kBandRows, columns); ++column) {
                rays.push_back(texel_ray(lights, k, row, column));
                texels.push_back(row * columns + column);
                if (rays.size() == kPieceRays) flush();
            }
    flush();
}

/// The ray through the centre of a texel. Its direction has depth 1, so t of the hit is the depth.
Ray ShadowMaps::texel_ray(const FarEnds& lights, size_t k, size_t row, size_t column) const {
    const float resolution = float(resolution_);
    const float u = (2 * float(column) + 1) / resolution - 1;
    const float v = (2 * float(row % size_t(resolution_)) + 1) / resolution - 1;
    const Vec3 end{lights.tx[k], lights.ty[k], lights.tz[k]};
    if (is_direction(lights.semantic)) {
        // From outside of the bounding sphere, across it
        const Frame3 f = frame_around(-end);
        const float r = extent_.radius * kGrow;
        return {extent_.center + f.x * (u * r) + f.y * (v * r) - f.z * (kBehind * r), 0, f.z, kInfinity};
    }
    // Faces are ordered +x, −x, +y, −y, +z, −z; u and v are the next two axes
    const size_t face = row / size_t(resolution_), axis = face / 2;
    float d[3];
    d[axis] = face % 2 ? -1.f : 1.f;
    d[(axis + 1) % 3] = u;
    d[(axis + 2) % 3] = v;
    return {end, spawn_offset(end, 0), {d[0], d[1], d[2]}, kInfinity};
}

bool ShadowMaps::covers(const FarEnds& lights) const {
    const Group& group = groups_[size_t(lights.group)];
    return group.count > 0 && group.count == lights.count && group.semantic == lights.semantic;
}

std::span<const float> ShadowMaps::depths(const FarEnds& lights, size_t k) const {
    const Group& group = groups_[size_t(lights.group)];
    return std::span(group.depth).subspan(k * group.texels, group.texels);
}

uint16_t ShadowMaps::lit16(const FarEnds& lights, size_t k, const Receivers16& receivers) const {
    const float* depth = depths(lights, k).data();
    const Vec3 end{lights.tx[k], lights.ty[k], lights.tz[k]};
    return is_direction(lights.semantic) ? lit_by_direction(depth, end, receivers)
                                         : lit_by_point(depth, end, receivers);
}

uint16_t ShadowMaps::lit_by_point(const float* depth, Vec3 light, const Receivers16& p) const {
    const float resolution = float(resolution_);
    const uint32_t columns = uint32_t(resolution_), square = columns * columns;
    uint32_t texel[16];
    float limit[16];
    for (int i = 0; i < 16; ++i) {
        // The face of the largest coordinate, and the coordinates on that face
        const float qx = p.x[i] - light.x, qy = p.y[i] - light.y, qz = p.z[i] - light.z;
        const float ax = std::fabs(qx), ay = std::fabs(qy), az = std::fabs(qz);
        // Ties go to x, then y, in every lane: no branch, and no face is left out
        const bool is_x = ax >= ay && ax >= az, is_y = !is_x && ay >= az;
        const float along = is_x ? qx : is_y ? qy : qz;
        const float qu = is_x ? qy : is_y ? qz : qx, qv = is_x ? qz : is_y ? qx : qy;
        const float nu = is_x ? p.ny[i] : is_y ? p.nz[i] : p.nx[i];
        const float nv = is_x ? p.nz[i] : is_y ? p.nx[i] : p.ny[i];
        const float z = std::fabs(along), inverse = 1.f / z;
        const uint32_t face = (is_x ? 0u : is_y ? 2u : 4u) + (along < 0 ? 1u : 0u);
        texel[i] =
            face * square + texel_of(qv * inverse, resolution) * columns + texel_of(qu * inverse, resolution);
        // Plane n·q = c along d = q/z: ∂z/∂u = −z² n_u / (n·q)
        // A grazing plane gains without a bound: such a receiver counts as lit
        const float facing = std::fabs(p.nx[i] * qx + p.ny[i] * qy + p.nz[i] * qz);
        const float gain = z * z * (std::fabs(nu) + std::fabs(nv)) / std::max(facing, 1e-30f);
        limit[i] = z - bias_ - slope_ * gain;
    }
    uint32_t lit = 0;
    // Not "<=": NaN counts as lit, which hides nothing
    for (int i = 0; i < 16; ++i) lit |= uint32_t(!(limit[i] > depth[texel[i]])) << i;
    return uint16_t(lit);
}

uint16_t ShadowMaps::lit_by_direction(const float* depth, Vec3 towards, const Receivers16& p) const {
    const Frame3 f = frame_around(-towards);
    const Vec3 c = extent_.center;
    const float r = extent_.radius * kGrow, inverse = 1 / r, resolution = float(resolution_);
    uint32_t texel[16];
    float limit[16];
    for (int i = 0; i < 16; ++i) {
        const float qx = p.x[i] - c.x, qy = p.y[i] - c.y, qz = p.z[i] - c.z;
        const float u = (qx * f.x.x + qy * f.x.y + qz * f.x.z) * inverse;
        const float v = (qx * f.y.x + qy * f.y.y + qz * f.y.z) * inverse;
        const float z = qx * f.z.x + qy * f.z.y + qz * f.z.z + kBehind * r;
        const float nu = p.nx[i] * f.x.x + p.ny[i] * f.x.y + p.nz[i] * f.x.z;
        const float nv = p.nx[i] * f.y.x + p.ny[i] * f.y.y + p.nz[i] * f.y.z;
        const float nz = std::fabs(p.nx[i] * f.z.x + p.ny[i] * f.z.y + p.nz[i] * f.z.z);
        texel[i] = texel_of(v, resolution) * uint32_t(resolution_) + texel_of(u, resolution);
        // Half a texel is r/resolution wide; the depth of a plane grows by n_u/n_z per unit of width
        const float gain = r * (std::fabs(nu) + std::fabs(nv)) / std::max(nz, 1e-30f);
        // Nothing beside the sphere can block
        const bool inside = std::fabs(u) <= 1 && std::fabs(v) <= 1;
        limit[i] = inside ? z - bias_ - slope_ * gain : -kInfinity;
    }
    uint32_t lit = 0;
    for (int i = 0; i < 16; ++i) lit |= uint32_t(!(limit[i] > depth[texel[i]])) << i;
    return uint16_t(lit);
}

uint64_t ShadowMaps::rays() const {
    uint64_t n = 0;
    for (const Group& group : groups_) n += group.depth.size();
    return n;
}

size_t ShadowMaps::maps() const {
    size_t n = 0;
    for (const Group& group : groups_) n += group.count;
    return n;
}

}  // namespace viscache
