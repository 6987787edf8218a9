#pragma once
// Blended maps from arrays of bool.
#include <cmath>

#include "arrays.h"
#include "viscache/math/morton.h"
#include "viscache/vismap/blended_maps.h"
#include "viscache/vismap/record.h"

namespace viscache::bindings {

/// Owns the words of the maps in Z order, and the core's view of them.
class BoundMaps {
public:
    /// `maps` has shape (n, 2^m, 2^m). `beta` (n,) is positive and sums to one. `dilated` is empty or holds
    /// the dilated maps of blended_maps.h.
    BoundMaps(const BoolArray& maps, const FloatArray& beta, const std::vector<BoolArray>& dilated) {
        const py::ssize_t edge = maps.ndim() == 3 ? maps.shape(1) : 0,
                          n = maps.ndim() == 3 ? maps.shape(0) : 0;
        // The smallest m whose maps are at least as large; then the size must be exactly that.
        while (view.m < kMaxMapLog2 && (py::ssize_t{1} << view.m) < edge) ++view.m;
        if (edge != py::ssize_t{1} << view.m || maps.shape(2) != edge || n > kMaxBlended)
            throw py::value_error("maps must have shape (n, 2^m, 2^m), n <= 8 and 4 <= m <= 7, got " +
                                  shape_text(maps));
        if (beta.ndim() != 1 || beta.shape(0) != n)
            throw py::value_error("beta must have shape (" + std::to_string(n) + ",), got " +
                                  shape_text(beta));
        view.count = int(n);
        // Pointers into the elements are kept, so the vector must not move: one map, one hierarchy and three
        // dilations each.
        words_.reserve(size_t(n) * 5);
        double sum = 0;
        for (int i = 0; i < view.count; ++i) {
            const float b = view.beta[i] = beta.at(i);
            if (!(b > 0) || !std::isfinite(b))
                throw py::value_error("beta must be > 0 and finite, got " + std::to_string(b));
            sum += b;
            view.bits[i] = add(maps, i, view.m);
            // Behind the map's words: `bits` points to an element before
            words_.emplace_back(hierarchy_words(view.m));
            build_hierarchy(view.m, view.bits[i], words_.back().data());
            view.hierarchy[i] = words_.back().data();
        }
        if (view.count && std::abs(sum - 1) > 1e-5)
            throw py::value_error("beta must have the sum 1, got " + std::to_string(sum));
        add_dilated(dilated);
    }
    BoundMaps(BoundMaps&&) = default;
    bool dilated() const { return dilated_; }

    BlendedMaps view{.m = kMinMapLog2};

private:
    void add_dilated(const std::vector<BoolArray>& dilated) {
        if (dilated.empty()) return;
        if (int(dilated.size()) != dilations(view.m))
            throw py::value_error("dilated must have " + std::to_string(dilations(view.m)) + " arrays, got " +
                                  std::to_string(dilated.size()));
        for (int k = 0; k < dilations(view.m); ++k) {
            const BoolArray& a = dilated[size_t(k)];
            // Each dilation is half as wide as the one before it, beginning with the full map.
            const py::ssize_t edge = py::ssize_t{1} << (view.m - k);
            if (a.ndim() != 3 || a.shape(0) != view.count || a.shape(1) != edge || a.shape(2) != edge)
                throw py::value_error("dilated[" + std::to_string(k) + "] must have shape (n, " +
                                      std::to_string(edge) + ", " + std::to_string(edge) + "), got " +
                                      shape_text(a));
            for (int i = 0; i < view.count; ++i) view.dilated[k][i] = add(a, i, view.m - k);
        }
        dilated_ = true;
    }
    const Word* add(const BoolArray& maps, int i, int level) {
        const uint32_t edge = uint32_t{1} << level;
        std::vector<Word>& words = words_.emplace_back(words_for(size_t(edge) * edge));
        for (uint32_t y = 0; y < edge; ++y)
            for (uint32_t x = 0; x < edge; ++x)
                // Rows of bool become bits in Morton order.
                if (maps.at(i, py::ssize_t(y), py::ssize_t(x))) set_bit(words.data(), morton2(x, y));
        return words.data();
    }

    std::vector<std::vector<Word>> words_;
    bool dilated_ = false;
};

}  // namespace viscache::bindings
