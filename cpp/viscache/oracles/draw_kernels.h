#pragma once
// Which queries of an eye point are checked: 512 at a time, by masks. The variant for the instruction set is
// chosen at run time; all variants draw the same bits.
//
// Rows are those of a BitMatrix: aligned, and a multiple of 8 words long.
#include <array>
#include <cstddef>
#include <cstdint>

#include "viscache/math/bits.h"
#include "viscache/math/isa.h"
#include "viscache/visibility/counters.h"

namespace viscache {

/// q = 2^−h, with h at most this.
constexpr size_t kMostHalvings = 8;
/// Octaves of a class of answers: its bounds begin so many further above.
constexpr size_t kMostOctaves = 4;

/// The queries of one eye point, and what tells how they are drawn.
struct DrawRow {
    size_t words = 0;
    const Word* wanted = nullptr;
    const Word* visible = nullptr;
    const Word* doubts = nullptr;
    const Word* differs = nullptr;  ///< a neighbouring light has the other answer
    /// Row b: the queries that lie below bound b. Rows above the highest bound that a class counts are
    /// absent.
    std::array<const Word*, kMostOctaves + kMostHalvings> below_bound{};
    const std::array<uint8_t, kAnswerClasses>* octaves = nullptr;
    uint64_t key = 0;   ///< of the random words
    uint32_t turn = 0;  ///< number of the sample of the pixel
};

struct DrawKernels {
    /// Sets `drawn`: the wanted queries that lie below h of the bounds of their class, with probability 2^−h
    /// (the picture in residual_oracle.h). In turns of 2^h samples that follow each other each query is drawn
    /// once. Row h of `halved` (kMostHalvings rows, one after another) has the queries below more than h
    /// bounds. Adds the queries of each class to `counts`.
    void (*draw)(const DrawRow& row, Word* drawn, Word* halved, uint64_t* counts);
    /// Sets `differs` of a row.
    void (*differs)(const Word* wanted, const Word* visible, Word* differs, size_t words);
    /// Number of set bits.
    uint64_t (*count)(const Word* a, size_t words);
};

const DrawKernels& draw_kernels(Isa isa);

}  // namespace viscache
