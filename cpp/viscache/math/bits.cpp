#include "viscache/math/bits.h"

#include <algorithm>

namespace viscache {

uint16_t column16(const BitMatrix& m, size_t first_row, size_t k) {
    const size_t n = std::min<size_t>(16, m.rows() - std::min(m.rows(), first_row));
    uint16_t column = 0;
    for (size_t i = 0; i < n; ++i) column |= uint16_t(uint16_t(m.get(first_row + i, k)) << i);
    return column;
}

namespace {

/// Transposes an 8×8 bit block stored in one word; byte i is row i (Hacker's Delight, 7-3).
///
///     1 × 1 blocks:  a b  ->  a c        then 2 × 2 blocks, then 4 × 4 blocks: each step exchanges the
///                    c d      b d        two blocks beside the diagonal, in all places at once.
///
/// t marks the bits in which two partners differ; flipping both exchanges them.
Word transpose8(Word x) {
    Word t = (x ^ (x >> 7)) & 0x00AA00AA00AA00AAull;
    x ^= t ^ (t << 7);
    t = (x ^ (x >> 14)) & 0x0000CCCC0000CCCCull;
    x ^= t ^ (t << 14);
    t = (x ^ (x >> 28)) & 0x00000000F0F0F0F0ull;
    return x ^ t ^ (t << 28);
}

}  // namespace

uint64_t count_bits(std::span<const Word> words) {
    uint64_t n = 0;
    for (Word w : words) n += uint64_t(std::popcount(w));
    return n;
}

uint64_t count_bits(const BitMatrix& m) {
    uint64_t n = 0;
    for (size_t r = 0; r < m.rows(); ++r) n += count_bits(m.row_span(r).first(words_for(m.columns())));
    return n;
}

// Byte by byte: 8 × 8 bits of the rows 0 ... 7, and of the rows 8 ... 15.
void columns16(const BitMatrix& m, size_t first_row, size_t w, uint16_t columns[64]) {
    const size_t n = std::min<size_t>(16, m.rows() - std::min(m.rows(), first_row));
    Word rows[16] = {};
    for (size_t i = 0; i < n; ++i) rows[i] = m.row(first_row + i)[w];
    for (size_t byte = 0; byte < 8; ++byte) {
        Word low = 0, high = 0;
        for (size_t i = 0; i < 8; ++i) {
            low |= (rows[i] >> (8 * byte) & 0xff) << (8 * i);
            high |= (rows[8 + i] >> (8 * byte) & 0xff) << (8 * i);
        }
        low = transpose8(low);
        high = transpose8(high);
        for (size_t j = 0; j < 8; ++j)
            columns[8 * byte + j] = uint16_t((low >> (8 * j) & 0xff) | (high >> (8 * j) & 0xff) << 8);
    }
}

// A transposition is its own inverse.
void or_columns16(BitMatrix& m, size_t first_row, size_t w, const uint16_t columns[64]) {
    const size_t n = std::min<size_t>(16, m.rows() - std::min(m.rows(), first_row));
    Word rows[16] = {};
    for (size_t byte = 0; byte < 8; ++byte) {
        Word low = 0, high = 0;
        for (size_t j = 0; j < 8; ++j) {
            low |= Word(columns[8 * byte + j] & 0xff) << (8 * j);
            high |= Word(columns[8 * byte + j] >> 8) << (8 * j);
        }
        low = transpose8(low);
        high = transpose8(high);
        for (size_t i = 0; i < 8; ++i) {
            rows[i] |= (low >> (8 * i) & 0xff) << (8 * byte);
            rows[8 + i] |= (high >> (8 * i) & 0xff) << (8 * byte);
        }
    }
    for (size_t i = 0; i < n; ++i) m.row(first_row + i)[w] |= rows[i];
}

}  // namespace viscache
