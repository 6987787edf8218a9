#pragma once
// Which of a fixed set of directions are free at each point: rows of bits.
#include <optional>
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"
#include "viscache/visibility/exact.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

struct RowInput {
    std::span<const Vec3> position;   ///< on surfaces
    std::span<const Vec3> normal;     ///< unit, one per position
    std::span<const Vec3> direction;  ///< unit, the same for all points
    float t_max = kInfinity;          ///< how far they look
};

/// The directions as the far ends of a block.
FarEnds far_ends(std::span<const Vec3> directions, float t_max);

/// Some points and the directions above their planes, ready for an oracle.
struct RowBlock {
    EyeBlock eyes;
    BitMatrix wanted;
    void fill(const RowInput& input, const FarEnds& sky, std::span<const uint32_t> points, float extent);
};

/// [VisMap Eq. 7] V(x, ω) over the whole sphere: bit k of row i is 1 if direction k lies above the plane of
/// point i and its ray hits nothing; the lower hemisphere is 0 by definition and costs no ray. `rows` has
/// row_words_for(directions) words a point; padding bits become 0. Packet order changes no bit; without one,
/// each thread finds the faster. `done` counts the points on the way. Returns the number of rays.
uint64_t visibility_rows(const RayCaster& caster, float extent, const RowInput& input, std::span<Word> rows,
                         std::optional<PacketOrder> order, int threads, const Control& control,
                         std::atomic<uint64_t>* done = nullptr);

}  // namespace viscache
