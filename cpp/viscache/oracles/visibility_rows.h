#pragma once
// Rows of bits: which of a fixed set of far ends, mostly directions, are free at each point.
#include <atomic>
#include <optional>
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/visibility/packet_choice.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/visibility/row_input.h"

namespace viscache {

/// [VisMap Eq. 7] V(x, ω) over the whole sphere: bit k of row i is 1 if direction k lies above the tangent
/// plane of point i and its ray hits nothing. The lower hemisphere is 0 by definition and costs no rays.
/// `rows` has row_words_for(directions) words per point; padding bits are set to 0. The packet order changes
/// no bits; without one, each thread measures which is faster. `done` counts finished points. Returns the
/// number of rays.
uint64_t visibility_rows(const RayCaster& caster, float extent, const RowInput& input, std::span<Word> rows,
                         std::optional<PacketOrder> order, int threads, const Control& control,
                         std::atomic<uint64_t>* done = nullptr);

}  // namespace viscache
