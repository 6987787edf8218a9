#pragma once
// Masked sums over shared lights for a glossy BRDF.
#include "viscache/math/isa.h"
#include "viscache/render/shared_lights.h"

namespace viscache {

/// Σ f(wi_k) · g_k · value_k over the set bits, in the order of `sum_row`. All instruction sets give the same
/// bits.
Rgb sum_row_glossy(const SharedLights& lights, const EyeShade& eye, const ShadingPoint& brdf, const Word* row,
                   Isa isa = active_isa());

}  // namespace viscache
