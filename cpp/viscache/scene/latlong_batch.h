#pragma once
// Places in a lat-long image of directions that lie along a row of the equal-area octahedral map. The loop is
// vectorised; the variant is chosen at run time.
#include <cstddef>

#include "viscache/math/affine.h"
#include "viscache/math/isa.h"

namespace viscache {

/// Turns directions of the world into those of an image's frame (convention in description.h).
struct LatLongTurn {
    float rows[3][3];
    /// `to_world` is a rotation, times a scale > 0 that does not matter: the transpose inverts it.
    explicit LatLongTurn(const Affine& to_world);
};

/// Points ((first + i) · step, y) for i < n of the octahedral square [0, 1]²: column u[i] and row v[i] in
/// [0, 1] of their directions. Within 2e-6 of exact arithmetic, where u may differ by 1. All variants give
/// the same bits.
void latlong_batch(const LatLongTurn& turn, float y, float first, float step, size_t n, float* u, float* v,
                   Isa isa = active_isa());

}  // namespace viscache
