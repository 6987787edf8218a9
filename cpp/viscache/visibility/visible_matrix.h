#pragma once
// Visibility of all targets from all points: exact rows of bits.
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Bit k of row i is 1 if points[i] sees targets[k] along `segment_between`. `rows` has words_for(targets)
/// words per point; unused bits become 0. The bits equal those of single rays, for any number of threads.
/// Besides `rows`, the call needs 4 bytes per point and a few hundred bytes per thread.
void visible_matrix(const RayCaster& caster, std::span<const Vec3> points, std::span<const Vec3> targets,
                    std::span<Word> rows, int threads, Control& control);

/// Whether each x sees its y along `segment_between`.
void visible_pairs(const RayCaster& caster, std::span<const Vec3> x, std::span<const Vec3> y,
                   std::span<bool> visible);

/// Traces some points × the targets `wanted` of word `word`, and sets the bits of the visible ones.
/// Neighbouring points should be close together.
void trace_matrix_tile(const RayCaster& caster, std::span<const Vec3> points, std::span<const uint32_t> some,
                       std::span<const Vec3> targets, size_t word, Word wanted, std::span<Word> rows);

/// The targets of a word.
inline Word targets_of_word(size_t targets, size_t word) {
    const size_t left = targets - word * kWordBits;
    return left >= kWordBits ? ~Word{0} : (Word{1} << left) - 1;
}

}  // namespace viscache
