#pragma once
// Visibility maps as arrays of words.
#include "arrays.h"
#include "viscache/vismap/record.h"

namespace viscache::bindings {

inline int checked_m(int m) {
    if (m < kMinMapLog2 || m > kMaxMapLog2)
        throw py::value_error("m must be in [4, 7], got " + std::to_string(m));
    return m;
}

inline const Word* checked_map(const WordArray& bits, int m) {
    const auto words = py::ssize_t(map_words(checked_m(m)));
    if (bits.ndim() != 1 || bits.shape(0) != words)
        throw py::value_error("bits must have shape (" + std::to_string(words) + ",), got " +
                              shape_text(bits));
    return bits.data();
}

}  // namespace viscache::bindings
