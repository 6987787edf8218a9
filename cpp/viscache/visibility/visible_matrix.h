#pragma once
// Every point against every target: exact visibility as rows of bits.
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Bit k of row i is 1 if points[i] sees targets[k] along `segment_between`. `rows` has words_for(targets)
/// words a point; unused bits become 0. The bits are those of one ray after another, for any number of
/// threads. Besides `rows`, each thread needs a few hundred bytes and all together 4 bytes a point.
void visible_matrix(const RayCaster& caster, std::span<const Vec3> points, std::span<const Vec3> targets,
                    std::span<Word> rows, int threads, Control& control);

}  // namespace viscache
