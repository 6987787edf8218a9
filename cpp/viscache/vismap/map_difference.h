#pragma once
// How much two maps differ. One variant per instruction set, chosen at run time, same counts.
#include "viscache/math/isa.h"
#include "viscache/vismap/record.h"

namespace viscache {

/// Number of differing bits of two runs of words.
using CountDifferences = uint32_t (*)(const Word* a, const Word* b, size_t words);
CountDifferences count_differences(Isa isa);

/// [VisMap Eq. 11] δ: the share of all cells of the sphere, the lower hemispheres too, in which two maps
/// differ.
inline float map_difference(int m, const Word* a, const Word* b, CountDifferences count) {
    return float(count(a, b, map_words(m))) / float(map_cells(m));
}

}  // namespace viscache
