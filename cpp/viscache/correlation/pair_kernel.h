#pragma once
// Computes n11, the number of directions visible from both of two points, by and + popcount + add. One
// variant per instruction set, chosen at run time; all give the same counts.
#include "viscache/correlation/bit_panels.h"
#include "viscache/math/isa.h"

namespace viscache {

struct PairKernel {
    /// n11 of four rows of a panel with the 16 rows of another panel; counts[4][16]. Only the units marked
    /// in `live` are counted; all other units must be dead on at least one side.
    void (*quad)(const Word* rows, const Word* columns, const Word* live, size_t live_words, int32_t* counts);
    /// n11 of two rows in the ordinary layout.
    uint32_t (*dot)(const Word* a, const Word* b, size_t words);
};

const PairKernel& pair_kernel(Isa isa);

/// n11 of the 16 × 16 pairs of two panels; counts[16][16].
void count_panels(const PairKernel& kernel, const BitPanels& a, size_t pa, const BitPanels& b, size_t pb,
                  int32_t* counts);

/// Reference of the benchmark: runs and + popcount + add of 512 bits `steps` times in registers, on 16
/// independent sums, and returns their total. Returns 0 without AVX-512 VPOPCNTDQ.
uint64_t and_popcount_add(size_t steps);

}  // namespace viscache
