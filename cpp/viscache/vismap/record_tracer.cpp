#include "viscache/vismap/record_tracer.h"

#include "viscache/math/morton.h"
#include "viscache/oracles/visibility_rows.h"
#include "viscache/sampling/direction_pattern.h"

namespace viscache {

std::vector<Vec3> record_pattern(int m, uint64_t seed) {
    const uint32_t size = 1u << m;
    const std::vector<Vec3> by_rows = direction_pattern(int(size), PatternKind::kLloyd, seed);
    std::vector<Vec3> pattern(by_rows.size());
    // Patterns come row by row; maps are in Morton order.
    for (uint32_t z = 0; z < pattern.size(); ++z) pattern[z] = by_rows[gather2(z >> 1) * size + gather2(z)];
    return pattern;
}

float ambient_visibility(std::span<const Word> bits, std::span<const Vec3> pattern, Vec3 normal) {
    double sum = 0;
    for_each_bit(bits, [&](size_t k) { sum += double(std::max(0.f, dot(pattern[k], normal))); });
    // (1/π) Σ cos · 4π/N: every cell has the solid angle 4π/N.
    return float(sum * 4 / double(pattern.size()));
}

RecordTracer::Traced RecordTracer::trace(std::span<const Vec3> positions, std::span<const Vec3> normals,
                                         int threads, const Control& control) const {
    Traced out;
    out.row_words = row_words_for(pattern_.size());
    out.rows.assign(positions.size() * out.row_words, 0);
    out.ambient.resize(positions.size());
    if (positions.empty()) return out;
    if (distances_)
        // Nearest hits cost more than any hits, so distances are traced only where R is wanted.
        trace_nearest(positions, normals, threads, control, out);
    else
        trace_any(positions, normals, threads, control, out);
    for (size_t i = 0; i < positions.size(); ++i)
        out.ambient[i].visibility =
            ambient_visibility({out.bits(i), words_for(pattern_.size())}, pattern_, normals[i]);
    return out;
}

void RecordTracer::trace_any(std::span<const Vec3> positions, std::span<const Vec3> normals, int threads,
                             const Control& control, Traced& out) const {
    // Records are far apart, so the rays of one point are more coherent than those of sixteen points
    const RowInput input{positions, normals, pattern_, kInfinity};
    out.rays = visibility_rows(caster_, extent_, input, out.rows, PacketOrder::kByPixel, threads, control);
}

void RecordTracer::trace_nearest(std::span<const Vec3> positions, std::span<const Vec3> normals, int threads,
                                 const Control& control, Traced& out) const {
    std::vector<uint64_t> rays_of(positions.size());
    parallel_for(positions.size(), threads, [&](size_t i, int) {
        control.check();
        std::vector<Ray> rays;
        std::vector<uint32_t> cells;
        const Vec3 origin = spawn(positions[i], normals[i], extent_);
        // Cells below the horizon stay 0, blocked, without a ray.
        for (uint32_t k = 0; k < pattern_.size(); ++k)
            if (dot(pattern_[k], normals[i]) > 0) {
                rays.push_back({origin, 0, pattern_[k], kInfinity});
                cells.push_back(k);
            }
        std::vector<Hit> hits(rays.size());
        caster_.intersect(rays, hits, Coherence::kIncoherent);
        for (size_t k = 0; k < hits.size(); ++k)
            if (hits[k].valid())
                // R is the nearest hit of all rays.
                out.ambient[i].nearest_hit = std::min(out.ambient[i].nearest_hit, hits[k].t);
            else
                set_bit(&out.rows[i * out.row_words], cells[k]);
        rays_of[i] = rays.size();
    });
    // Added in order; the sum of integers would be the same in any.
    for (uint64_t n : rays_of) out.rays += n;
}

}  // namespace viscache
