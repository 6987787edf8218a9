#pragma once
// Sums over shared lights with a glossy BRDF, under a mask of bits.
#include "viscache/math/isa.h"
#include "viscache/render/shared_lights.h"

namespace viscache {

/// Σ f(wi_k) · g_k · value_k over the set bits, in the order of `sum_row`; the same bits from every variant.
Rgb sum_row_glossy(const SharedLights& lights, const EyeShade& eye, const ShadingPoint& brdf, const Word* row,
                   Isa isa = active_isa());

}  // namespace viscache
