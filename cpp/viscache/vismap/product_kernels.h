#pragma once
// The inner loops of product sampling. One variant per instruction set; all give the same bits.
#include <cstddef>
#include <cstdint>

#include "viscache/scene/lobes.h"

namespace viscache {

struct ProductKernels {
    /// f·cos of a diffuse or a glossy surface for sixteen unit directions.
    void (*diffuse)(const LobeConstants&, const float* x, const float* y, const float* z, RgbBlock& out);
    void (*glossy)(const LobeConstants&, const float* x, const float* y, const float* z, RgbBlock& out);
    /// above[i] = 1 if the cone around direction i reaches above both tangent planes.
    void (*above)(const LobeConstants&, const float* x, const float* y, const float* z, const float* sine,
                  uint8_t* above, size_t n);
    /// For the four leaves of a block: means of four samples each, their luminance, and the range of the
    /// samples' luminances. Returns the largest luminance of a leaf.
    float (*gather)(const RgbBlock& block, float* r, float* g, float* b, float* luminance, float* spread);
    /// Raises luminances below `floor` to it, and the channels by the same amount, where touched is set; n
    /// leaves.
    void (*raise)(const uint8_t* touched, float floor, float* r, float* g, float* b, float* luminance,
                  size_t n);
    /// Σ b[i] · light[i]; n is a multiple of 8.
    double (*weigh)(const float* b, const double* light, size_t n);
    /// flags[i] = 1 if spread[i] · light[i] > threshold.
    void (*flag)(const float* spread, const double* light, double threshold, uint8_t* flags, size_t n);
    /// out[i] = b[i / span] · light[i] for n·span products; span is 1, 4 or 16.
    void (*scale)(const float* b, const double* light, double* out, size_t n, size_t span);
    /// Sums of groups of four: (a + b) + (c + d).
    void (*sum_fours)(const double* children, double* parents, size_t parents_count);
};

const ProductKernels& product_kernels(Isa isa);
inline const ProductKernels& product_kernels() { return product_kernels(active_isa()); }

}  // namespace viscache
