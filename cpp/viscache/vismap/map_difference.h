#pragma once
// Difference of two maps. One variant per instruction set, chosen at run time; all give the same counts.
#include "viscache/math/isa.h"
#include "viscache/vismap/record.h"

namespace viscache {

/// Number of bits in which two arrays of words differ.
using CountDifferences = uint32_t (*)(const Word* a, const Word* b, size_t words);
CountDifferences count_differences(Isa isa);

/// [VisMap Eq. 11] δ: the fraction of the cells of the whole sphere, including the lower hemispheres, in
/// which two maps differ.
inline float map_difference(int m, const Word* a, const Word* b, CountDifferences count) {
    return float(count(a, b, map_words(m))) / float(map_cells(m));
}

}  // namespace viscache
