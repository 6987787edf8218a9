#pragma once
// Octahedral map of many directions. The kernel is chosen at run time; all kernels give the same bits.
#include <span>

#include "viscache/math/isa.h"

namespace viscache {

/// Computes `octahedral_square<double>` of every direction. The result is NaN for zero vectors and for input
/// that is not finite.
void octahedral_batch(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                      std::span<double> u, std::span<double> v, Isa isa = active_isa());

}  // namespace viscache
