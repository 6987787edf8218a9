// math/: bit rows and their transposes, the choice of the ISA, affine transforms.
#include <cfenv>
#include <cmath>
#include <cstdint>
#include <random>

#include "check.h"
#include "viscache/math/affine.h"
#include "viscache/math/any_length.h"
#include "viscache/math/bits.h"
#include "viscache/math/float_mode.h"
#include "viscache/math/isa.h"

namespace viscache::test::math_tests {
namespace {

BitMatrix random_bits(size_t rows, size_t columns, uint64_t seed) {
    std::mt19937_64 random(seed);
    BitMatrix m(rows, columns);
    for (size_t r = 0; r < rows; ++r)
        for (size_t k = 0; k < columns; ++k)
            if (random() & 1) m.set(r, k);
    return m;
}

void rows_are_padded_and_zero() {
    BitMatrix m(3, 513);
    check_equal(m.row_words(), size_t{16}, "words of a row of 513 bits");
    for (size_t r = 0; r < 3; ++r) {
        check_equal(reinterpret_cast<uintptr_t>(m.row(r)) % 64, uintptr_t{0}, "alignment of a row");
        for (Word w : m.row_span(r)) check_equal(w, Word{0}, "a fresh word");
    }
    m.set(2, 512);
    m.reset(2, 700);
    for (size_t r = 0; r < 2; ++r)
        for (Word w : m.row_span(r)) check_equal(w, Word{0}, "a word after reset");
}

void set_bits_are_visited_in_order() {
    BitMatrix m(1, 600);
    const std::vector<size_t> expected = {0, 63, 64, 127, 511, 512, 599};
    for (size_t k : expected) m.set(0, k);
    std::vector<size_t> visited;
    for_each_bit(m.row_span(0), [&](size_t k) { visited.push_back(k); });
    check(visited == expected, "for_each_bit visits exactly the set bits, lowest first");
    clear_bit(m.row(0), 64);
    check(!m.get(0, 64) && m.get(0, 63), "clear_bit clears only its own bit");
}

// Blocks that start inside, at and past the last row: lanes past the end read as 0.
void columns_are_the_transpose() {
    const BitMatrix m = random_bits(37, 130, 1);
    for (size_t first : {size_t{0}, size_t{5}, size_t{30}, size_t{37}, size_t{50}})
        for (size_t w = 0; w < 3; ++w) {
            uint16_t columns[64];
            columns16(m, first, w, columns);
            for (size_t j = 0; j < 64; ++j) {
                uint16_t expected = 0;
                for (size_t i = 0; i < 16; ++i)
                    if (first + i < m.rows() && m.get(first + i, 64 * w + j)) expected |= uint16_t(1u << i);
                check_equal(columns[j], expected, "columns16");
                check_equal(column16(m, first, 64 * w + j), expected, "column16");
            }
        }
}

void columns_written_back_give_the_matrix() {
    const BitMatrix m = random_bits(37, 130, 2);
    BitMatrix copy(37, 130);
    copy.set(0, 0);  // or_columns16 keeps bits that are set
    for (size_t first = 0; first < 37; first += 16)
        for (size_t w = 0; w < 3; ++w) {
            uint16_t columns[64];
            columns16(m, first, w, columns);
            or_columns16(copy, first, w, columns);
        }
    for (size_t r = 0; r < 37; ++r)
        for (size_t k = 0; k < 130; ++k)
            check_equal(copy.get(r, k), m.get(r, k) || (r == 0 && k == 0), "a bit after the round trip");
}

void isa_choice_is_supported() {
    check(active_isa() <= best_isa(), "the variant in use is one the CPU has");
    for (Isa isa : {Isa::kPortable, Isa::kAvx2, Isa::kAvx512})
        check(isa_name(isa) != "unknown", "every ISA has a name");
}

Affine sheared(double scale) {
    Affine a;
    a.m = {{{scale, 0.5, 0, 1}, {0, -2, 0.25, 2}, {0.125, 0, 3, -3}}};
    return a;
}

void normals_stay_perpendicular() {
    for (double scale : {1.0, -1.0, 1e-3}) {
        const Affine a = sheared(scale);
        const Vec3 u{1, 2, 3}, v{-2, 0.5, 1};
        const Vec3 n = a.normal(cross(u, v));
        const Vec3 tu = a.vector(u), tv = a.vector(v);
        check_near(dot(n, tu) / (length(n) * length(tu)), 0, 1e-6, "normal · transformed tangent u");
        check_near(dot(n, tv) / (length(n) * length(tv)), 0, 1e-6, "normal · transformed tangent v");
    }
}

// A mirrored surface keeps its normal on the side of the transformed normal: n' · (A n) > 0 for a mirror A =
// diag(-1, 1, 1).
void normals_keep_their_side_under_mirrors() {
    Affine mirror;
    mirror.m[0][0] = -1;
    const Vec3 n = mirror.normal({1, 0, 0});
    check_near(n.x, -1, 0, "normal of a mirrored plane");
}

void products_apply_right_to_left() {
    const Affine a = sheared(1), b = sheared(-0.5);
    const Vec3 p{0.5, -1, 2};
    const Vec3 one = (a * b).point(p), two = a.point(b.point(p));
    for (int axis = 0; axis < 3; ++axis) check_near(one[axis], two[axis], 1e-5, "(a b) p = a (b p)");
    check_near((a * b).determinant(), a.determinant() * b.determinant(), 1e-12, "det (a b) = det a det b");
}

// Within the range of squares: the bits of length. Outside: length gives 0 or infinity.
void lengths_are_right_for_small_and_large_vectors() {
    const Vec3 v{0.3f, -0.5f, 0.7f};
    check(any_length(v) == length(v) && any_direction(v) == normalize(v), "ordinary vectors keep their bits");
    for (float scale : {1e-30f, 1e-22f, 1e25f}) {
        const Vec3 scaled = v * scale;
        check_near(any_length(scaled) / scale, length(v), 1e-6, "length of a scaled vector");
        for (int axis = 0; axis < 3; ++axis)
            check_near(any_direction(scaled)[axis], normalize(v)[axis], 1e-6, "direction of a scaled vector");
        check(!(std::fabs(length(scaled) / scale - length(v)) < 1e-3f), "squares leave the range");
    }
    check(any_length({}) == 0 && any_direction({}) == Vec3{}, "the zero vector");
}

// What the caller's mode was comes back.
void floats_have_their_mode_for_a_while() {
    const int before = std::fegetround();
    std::fesetround(FE_UPWARD);
    volatile float one = 1, little = 1e-10f;
    {
        const DefaultFloats floats;
        check(one + little == 1, "rounding to nearest");
    }
    check(one + little > 1, "rounding up again");
    std::fesetround(before);
}

const Suite suite{
    {"lengths: small and large vectors have them", lengths_are_right_for_small_and_large_vectors},
    {"floats: rounding is to nearest for a while", floats_have_their_mode_for_a_while},
    {"bits: rows are padded to 512 bits, aligned and zero", rows_are_padded_and_zero},
    {"bits: set bits are visited in order", set_bits_are_visited_in_order},
    {"bits: columns are the transpose of the rows", columns_are_the_transpose},
    {"bits: columns written back give the matrix", columns_written_back_give_the_matrix},
    {"isa: the chosen variant is supported", isa_choice_is_supported},
    {"affine: normals stay perpendicular to the surface", normals_stay_perpendicular},
    {"affine: normals keep their side under mirrors", normals_keep_their_side_under_mirrors},
    {"affine: products apply right to left", products_apply_right_to_left},
};

}  // namespace
}  // namespace viscache::test::math_tests
