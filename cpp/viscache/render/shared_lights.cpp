#include "viscache/render/shared_lights.h"

#include "viscache/math/isa_variants.h"
#include "viscache/math/x86_intrinsics.h"

namespace viscache {

namespace {
struct Columns {
    const float *x, *y, *z, *nx, *ny, *nz, *r, *g, *b;
    ColumnRange range;
    float bound2;
    const float* cone;  ///< factors of the columns' cones; nullptr without cones
};
}  // namespace

// One body of kernels, three instruction sets. Each region fixes how many lanes a register has; the
// order of sums is always that of 16 lanes, so all three give the same bits.
namespace portable {
constexpr size_t kWidth = 4;
// Columns start at any float of an array, so loads must not assume the register's alignment
typedef float F __attribute__((vector_size(16), aligned(4), may_alias));
typedef int I __attribute__((vector_size(16)));
// IEEE square roots are correctly rounded everywhere, which approximate reciprocals are not
inline F vec_sqrt(F v) { return F{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])}; }
// Comparisons give lanes of all ones or all zeros; one bit of each is enough
inline Word sign_bits(I m) { return Word((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8)); }
#include "shared_kernels.inc"
}  // namespace portable

#if VISCACHE_X86
#pragma GCC push_options
#pragma GCC target("avx2,bmi,bmi2,popcnt")
namespace avx2 {
constexpr size_t kWidth = 8;
typedef float F __attribute__((vector_size(32), aligned(4), may_alias));
typedef int I __attribute__((vector_size(32)));
inline F vec_sqrt(F v) { return (F)_mm256_sqrt_ps((__m256)v); }
inline Word sign_bits(I m) { return Word(unsigned(_mm256_movemask_ps((__m256)m))); }
#include "shared_kernels.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi,bmi2,popcnt,prefer-vector-width=512")
namespace avx512 {
constexpr size_t kWidth = 16;
typedef float F __attribute__((vector_size(64), aligned(4), may_alias));
typedef int I __attribute__((vector_size(64)));
// The masked form has no undefined operand, about which gcc 12 warns in the plain one
inline F vec_sqrt(F v) { return (F)_mm512_maskz_sqrt_ps(0xffff, (__m512)v); }
inline Word sign_bits(I m) { return Word(_mm512_movepi32_mask((__m512i)m)); }
#include "shared_kernels.inc"
}  // namespace avx512
#pragma GCC pop_options
#endif

namespace {

/// The arrays of a group as the kernels take them.
Columns columns_of(const SharedLights& s, const EyeShade& eye, ColumnRange range) {
    const FarEnds& e = s.ends;
    return {e.x.data(), e.y.data(), e.z.data(), e.nx.data(), e.ny.data(), e.nz.data(),
            s.r.data(), s.g.data(), s.b.data(), range,       s.bound2,    cone_row(s, eye.position)};
}

/// All columns, padded to words.
Columns columns_of(const SharedLights& s, const EyeShade& eye) {
    return columns_of(s, eye, {0, words_for(s.ends.count) * kWordBits});
}

}  // namespace

const float* cone_row(const SharedLights& s, Vec3 position) {
    if (s.cones.empty()) return nullptr;
    // One row per thread: the kernels need the factors as an array, and they depend on the eye
    // point
    thread_local std::vector<float> row;
    row.assign(s.ends.x.size(), 1.f);
    for (size_t k = 0; k < s.cones.size(); ++k)
        // Only spot lights cost a normalisation; plain points keep their 1
        if (s.cones[k].falloff != Falloff::kNone)
            row[k] =
                spot_factor(s.cones[k], normalize(position - Vec3{s.ends.x[k], s.ends.y[k], s.ends.z[k]}));
    return row.data();
}

// The instruction set is chosen once per row, not per column: the cost of the switch vanishes in a
// row of lights
uint64_t wanted_row(const SharedLights& s, const EyeShade& eye, ColumnRange range, Word* row) {
    return VISCACHE_REGION(active_isa(), wanted_any)(s.ends.semantic, columns_of(s, eye, range), eye, row);
}

float contribution_row(const SharedLights& s, const EyeShade& eye, ColumnRange range,
                       std::vector<float>& row) {
    row.resize(s.ends.x.size());
    return VISCACHE_REGION(active_isa(), contributions_any)(s.ends.semantic, columns_of(s, eye, range), eye,
                                                            row.data());
}

void at_most_rows(std::span<const float> row, std::span<const float> bounds, std::span<Word* const> rows) {
    return VISCACHE_REGION(active_isa(), at_most)(row, bounds, rows);
}

float masked_sum(std::span<const float> row, const Word* mask) {
    return VISCACHE_REGION(active_isa(), masked_sum)(row, mask);
}

Rgb sum_row(const SharedLights& s, const EyeShade& eye, const Word* row) {
    return VISCACHE_REGION(active_isa(), sum_any)(s.ends.semantic, columns_of(s, eye), eye, row);
}

/// Columns stand in arrays by component, so that a kernel loads the same component of many lights
/// at once.
void SharedLights::add(Vec3 p, Vec3 n, Vec3 end, Rgb value, float density) {
    FarEnds& e = ends;
    e.x.push_back(p.x);
    e.y.push_back(p.y);
    e.z.push_back(p.z);
    e.nx.push_back(n.x);
    e.ny.push_back(n.y);
    e.nz.push_back(n.z);
    e.tx.push_back(end.x);
    e.ty.push_back(end.y);
    e.tz.push_back(end.z);
    e.density.push_back(density);
    r.push_back(value.x);
    g.push_back(value.y);
    b.push_back(value.z);
    ++e.count;
}

void SharedLights::set_cone(const SpotCone& cone) {
    if (cone.falloff == Falloff::kNone) return;
    cones.resize(ends.count);
    // Lights before the first spot light get the cone that lets everything through
    cones.back() = cone;
}

void SharedLights::pad() {
    // Lights after the last spot light have no entry yet
    if (!cones.empty()) cones.resize(ends.count);
    // Kernels read whole registers behind the last column. A padded column has the value 0, so its
    // contribution is never positive and its bit never set
    const size_t padded = row_words_for(ends.count) * kWordBits;
    if (!lobe_ratio.empty()) lobe_ratio.resize(padded, 0.f);
    for (auto* v : {&ends.x, &ends.y, &ends.z, &ends.nx, &ends.ny, &ends.nz, &ends.tx, &ends.ty, &ends.tz,
                    &ends.density, &r, &g, &b})
        v->resize(padded, 0.f);
}

}  // namespace viscache
