#pragma once
// Masked sums over shared lights for a glossy BRDF.
#include "viscache/math/isa.h"
#include "viscache/render/shared_lights.h"

namespace viscache {

/// Σ f(wi_k) · g_k · value_k over the set bits, in the order of `sum_row`. All instruction sets give the same
/// bits.
Rgb sum_row_glossy(const SharedLights& lights, const EyeShade& eye, const ShadingPoint& brdf, const Word* row,
                   Isa isa = active_isa());

/// Unoccluded contribution f·g·value of the columns of the set bits, summed over the channels; padded. 0 for
/// the other columns. Returns the mean of the positive ones.
float contribution_row_glossy(const SharedLights& lights, const EyeShade& eye, const ShadingPoint& brdf,
                              const Word* row, std::vector<float>& contributions, Isa isa = active_isa());

}  // namespace viscache
