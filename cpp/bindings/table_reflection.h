#pragma once
// Reflection given as a table over the equal-area map. Tests can compute its sums exactly.
#include <bit>

#include "arrays.h"
#include "viscache/math/morton.h"
#include "viscache/vismap/reflection.h"

namespace viscache::bindings {

class TableReflection final : public Reflection {
public:
    /// `table` has shape (N, N, 3) with N a power of two in [32, 4096]; its values are finite and >= 0.
    explicit TableReflection(const FloatArray& table) {
        const py::ssize_t n = table.ndim() == 3 ? table.shape(0) : 0;
        if (n < 32 || n > 4096 || !std::has_single_bit(size_t(n)) || table.shape(1) != n ||
            table.shape(2) != 3)
            throw py::value_error("b must have shape (N, N, 3), N a power of two in [32, 4096], got " +
                                  shape_text(table));
        const int last = std::countr_zero(size_t(n));
        mean_.resize(size_t(last) + 1);
        most_.resize(size_t(last) + 1);
        // From the finest level up: nodes are means, and maxima, of four.
        for (int l = last; l >= 0; --l) {
            const size_t count = size_t{1} << (2 * l);
            mean_[size_t(l)].resize(count);
            most_[size_t(l)].resize(count);
            for (uint32_t z = 0; z < count; ++z) l == last ? read(table, z) : gather(size_t(l), z);
        }
    }
    void sample(int level, uint32_t first, RgbBlock& out) const override {
        for (uint32_t i = 0; i < 16; ++i) {
            const Rgb c = at(mean_, level, first + i);
            out.r[i] = c.x;
            out.g[i] = c.y;
            out.b[i] = c.z;
        }
    }
    void touched(int level, uint32_t first, std::span<uint8_t> touched) const override {
        for (uint32_t i = 0; i < touched.size(); ++i) touched[i] = at(most_, level, first + i) > 0;
    }
    bool black() const override { return !(most_[0][0] > 0); }
    /// B at a texel, given by its Morton code, of a map that is at least as fine.
    Rgb value(int level, uint32_t texel) const { return at(mean_, level, texel); }
    int level() const { return int(mean_.size()) - 1; }

private:
    template <class T>
    static T at(const std::vector<std::vector<T>>& pyramid, int level, uint32_t z) {
        const int last = int(pyramid.size()) - 1;
        // Below the table's own level, a node is a part of a texel.
        return level <= last ? pyramid[size_t(level)][z] : pyramid[size_t(last)][z >> (2 * (level - last))];
    }
    void read(const FloatArray& table, uint32_t z) {
        const float* c = table.data(py::ssize_t(gather2(z >> 1)), py::ssize_t(gather2(z)), 0);
        mean_.back()[z] = {c[0], c[1], c[2]};
        if (!is_finite(mean_.back()[z]) || std::min({c[0], c[1], c[2]}) < 0)
            throw py::value_error("b must be finite and >= 0");
        most_.back()[z] = std::max({c[0], c[1], c[2]});
    }
    void gather(size_t l, uint32_t z) {
        Rgb sum;
        float most = 0;
        for (uint32_t k = 4 * z; k < 4 * z + 4; ++k) {
            sum += mean_[l + 1][k];
            most = std::max(most, most_[l + 1][k]);
        }
        mean_[l][z] = sum * 0.25f;
        most_[l][z] = most;
    }

    std::vector<std::vector<Rgb>> mean_;
    std::vector<std::vector<float>> most_;
};

}  // namespace viscache::bindings
