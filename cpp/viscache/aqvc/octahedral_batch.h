#pragma once
// Octahedral maps of many directions; the variant is chosen at run time, the bits are the same.
#include <span>

#include "viscache/math/isa.h"

namespace viscache {

/// `octahedral_square<double>` of every direction; not a number for the zero vector and for what is not
/// finite.
void octahedral_batch(std::span<const float> x, std::span<const float> y, std::span<const float> z,
                      std::span<double> u, std::span<double> v, Isa isa = active_isa());

}  // namespace viscache
