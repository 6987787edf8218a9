#pragma once
// Traces the rays of records: one in each cell of the upper hemisphere of a point.
#include <span>
#include <vector>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/record_pool.h"

namespace viscache {

/// Directions of the cells of a record in Z order: stratified, and spread evenly by Lloyd's iteration
/// without leaving their cells. They are the same for all records of a cache, so that equal visibility gives
/// equal maps.
std::vector<Vec3> record_pattern(int m, uint64_t seed);

/// [VisMap Eq. 12] A: the cosine-weighted fraction of the hemisphere that is free in a map.
// Differs (M3): divided by π, so that an open plane has 1
float ambient_visibility(std::span<const Word> bits, std::span<const Vec3> pattern, Vec3 normal);

class RecordTracer {
public:
    /// `extent` is Scene::offset_extent. With `distances`, nearest hits are traced instead of any hits, to
    /// obtain R.
    RecordTracer(const RayCaster& caster, float extent, std::span<const Vec3> pattern, bool distances)
        : caster_(caster), extent_(extent), pattern_(pattern), distances_(distances) {}

    struct Traced {
        size_t row_words = 0;
        std::vector<Word> rows;              ///< maps, row_words words each
        std::vector<AmbientRecord> ambient;  ///< nearest_hit is set only with `distances`
        uint64_t rays = 0;
        const Word* bits(size_t i) const { return &rows[i * row_words]; }
    };
    Traced trace(std::span<const Vec3> positions, std::span<const Vec3> normals, int threads,
                 const Control& control) const;

private:
    void trace_any(std::span<const Vec3> positions, std::span<const Vec3> normals, int threads,
                   const Control& control, Traced& out) const;
    void trace_nearest(std::span<const Vec3> positions, std::span<const Vec3> normals, int threads,
                       const Control& control, Traced& out) const;

    const RayCaster& caster_;
    float extent_;
    std::span<const Vec3> pattern_;
    bool distances_;
};

}  // namespace viscache
