#include "viscache/vismap/map_kernels.h"

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

// Vectors of eight doubles on every CPU: the compiler splits them where registers are smaller. `aligned(8)`:
// arrays need no more than the alignment of a double.
typedef double Double8 __attribute__((vector_size(64), aligned(8), may_alias));
typedef int64_t Int8 __attribute__((vector_size(64)));
#define VISCACHE_INLINE inline __attribute__((always_inline))

VISCACHE_INLINE Double8 load(const double* p) { return *reinterpret_cast<const Double8*>(p); }
VISCACHE_INLINE void store(double* p, Double8 v) { *reinterpret_cast<Double8*>(p) = v; }
/// Pairs first, in a fixed order: the sum has the same bits in every variant.
VISCACHE_INLINE double total(const Double8& v) {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

/// Ṽ = Σ β_i V_i of eight cells: the sum of the weights of the records whose bit is set. Lane i tests bit
/// `lanes[i]` of the word, counted from bit `first`.
VISCACHE_INLINE Double8 blend(const Word* const* words, const double* beta, int count, size_t first,
                              const Int8& lanes) {
    Double8 sum{};
    for (int i = 0; i < count; ++i) {
        // The eight bits from `first` on go to all lanes; each lane keeps its own and turns it into a mask:
        //
        //     bits      0b01101001 in all lanes
        //     lanes     1   2   4   8   16  32  64  128
        //     set       -1  0   0   -1  0   -1  -1  0        (−1: all bits set)
        //     set & β   β   0   0   β   0   β   β   0        exact: the bits of β, or those of 0.0
        const Int8 bits = Int8{} + int64_t(words[i][first / kWordBits] >> (first % kWordBits) & 0xff);
        const Int8 set = (bits & lanes) != 0;
        const Double8 b = Double8{} + beta[i];
        sum += (Double8)(set & (Int8)b);
    }
    return sum;
}

VISCACHE_INLINE CellSums expand_body(const BlendedMaps& maps, int dilations, const CellMasses& masses,
                                     double* visible, double* const* dilated) {
    // Eight cells of the map, two blocks of four cells, one block of sixteen
    const Int8 cells{1, 2, 4, 8, 16, 32, 64, 128}, pairs{1, 1, 1, 1, 2, 2, 2, 2}, one{1, 1, 1, 1, 1, 1, 1, 1};
    double beta[kMaxBlended];
    // Weights are floats in the cache and exact in double.
    for (int i = 0; i < maps.count; ++i) beta[i] = double(maps.beta[i]);
    Double8 j{}, w2{}, colour[3]{}, grown[3]{};
    const size_t n = size_t{1} << (2 * maps.m);
    // Eight cells never cross a word: 64 is a multiple of 8.
    for (size_t z = 0; z < n; z += 8) {
        const Double8 p = load(masses.luminance + z), v = blend(maps.bits, beta, maps.count, z, cells);
        store(visible + z, v);
        j += p * v;
        w2 += p * v * v;
        for (int c = 0; c < 3; ++c) colour[c] += load(masses.colour[c] + z) * v;
        if (dilations == 0) continue;
        // Coarser maps have one bit for four or sixteen cells: eight cells share two bits, or one.
        const Double8 v1 = blend(maps.dilated[0], beta, maps.count, z, cells);
        const Double8 v2 = blend(maps.dilated[1], beta, maps.count, z / 4, pairs);
        store(dilated[0] + z, v1);
        store(dilated[1] + z, v2);
        grown[0] += p * v1;
        grown[1] += p * v2;
        if (dilations == 2) continue;
        const Double8 v3 = blend(maps.dilated[2], beta, maps.count, z / 16, one);
        store(dilated[2] + z, v3);
        grown[2] += p * v3;
    }
    return {total(j),
            total(w2),
            {total(colour[0]), total(colour[1]), total(colour[2])},
            {total(grown[0]), total(grown[1]), total(grown[2])}};
}

VISCACHE_INLINE double shape_body(size_t n, double floor, const double* share, int dilations,
                                  const double* mass, const double* visible, const double* const* dilated,
                                  double* density) {
    Double8 w2{};
    for (size_t z = 0; z < n; z += 8) {
        Double8 d = Double8{} + floor;
        // D = η + Σ share_k Ṽ^k; `share` contains (1 − η) a_k / μ_k.
        for (int k = 0; k < dilations; ++k) d += load(dilated[k] + z) * share[k];
        store(density + z, d);
        const Double8 v = load(visible + z);
        w2 += load(mass + z) * v * v / d;
    }
    return total(w2);
}

#undef VISCACHE_INLINE

constexpr MapKernels map_kernels_of(Isa isa) {
    return {variant_of<expand_body>(isa), variant_of<shape_body>(isa)};
}

}  // namespace

const MapKernels& map_kernels(Isa isa) { return table_of<map_kernels_of>(isa); }

}  // namespace viscache
