#pragma once
// Bits in words: single bits, spans of bits, and the bit matrix that holds visibility.
//
// Visibility is stored as bits. Rows are eye points; columns are far ends (lights, VPLs, sky directions);
// 1 = visible. Column k is bit k % 64 of word k / 64. Rows are padded to 512 bits and aligned to 64 bytes;
// padding bits are always 0.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <span>

namespace viscache {

using Word = uint64_t;
constexpr size_t kWordBits = 64;
constexpr size_t kRowAlignmentWords = 8;  // 512 bits

inline bool get_bit(const Word* words, size_t k) { return words[k / kWordBits] >> (k % kWordBits) & 1; }
inline void set_bit(Word* words, size_t k) { words[k / kWordBits] |= Word{1} << (k % kWordBits); }
inline void clear_bit(Word* words, size_t k) { words[k / kWordBits] &= ~(Word{1} << (k % kWordBits)); }
inline size_t words_for(size_t bits) { return (bits + kWordBits - 1) / kWordBits; }
/// Number of words in one padded row of `columns` bits.
inline size_t row_words_for(size_t columns) {
    return (words_for(columns) + kRowAlignmentWords - 1) / kRowAlignmentWords * kRowAlignmentWords;
}
/// The bits of word w that are in [first, last).
inline Word range_bits(size_t w, size_t first, size_t last) {
    // Bits of the word below position k
    const auto below = [w](size_t k) {
        if (k <= w * kWordBits) return Word{0};
        return k >= (w + 1) * kWordBits ? ~Word{0} : (Word{1} << (k % kWordBits)) - 1;
    };
    return below(last) & ~below(first);
}
/// Calls visit(k) for every set bit, in increasing order of k.
template <class Visit>
void for_each_bit(std::span<const Word> words, Visit visit) {
    for (size_t w = 0; w < words.size(); ++w)
        for (Word rest = words[w]; rest; rest &= rest - 1)
            visit(w * kWordBits + size_t(std::countr_zero(rest)));
}

/// A matrix of bits; the layout is described at the top of this file.
class BitMatrix {
public:
    BitMatrix() = default;
    BitMatrix(size_t rows, size_t columns) { reset(rows, columns); }

    /// Resizes the matrix and clears every bit. Memory is reused when it suffices.
    void reset(size_t rows, size_t columns) {
        rows_ = rows;
        columns_ = columns;
        row_words_ = row_words_for(columns);
        const size_t words = rows_ * row_words_;
        if (words > capacity_) {
            data_.reset(static_cast<Word*>(::operator new[](words * sizeof(Word), std::align_val_t{64})));
            capacity_ = words;
        }
        // All of it, so that padding bits are 0 (see the top of this file).
        if (words) std::memset(data_.get(), 0, words * sizeof(Word));
    }
    size_t rows() const { return rows_; }
    size_t columns() const { return columns_; }
    size_t row_words() const { return row_words_; }
    Word* row(size_t r) { return data_.get() + r * row_words_; }
    const Word* row(size_t r) const { return data_.get() + r * row_words_; }
    std::span<Word> row_span(size_t r) { return {row(r), row_words_}; }
    std::span<const Word> row_span(size_t r) const { return {row(r), row_words_}; }
    bool get(size_t r, size_t k) const { return get_bit(row(r), k); }
    void set(size_t r, size_t k) { set_bit(row(r), k); }

private:
    struct AlignedDelete {
        void operator()(Word* p) const { ::operator delete[](p, std::align_val_t{64}); }
    };
    std::unique_ptr<Word[], AlignedDelete> data_;
    size_t rows_ = 0, columns_ = 0, row_words_ = 0, capacity_ = 0;
};

/// Number of set bits.
uint64_t count_bits(std::span<const Word> words);
uint64_t count_bits(const BitMatrix& m);

/// One column of 16 rows: bit i of the result is bit k of row first_row + i. Rows past the end count as 0.
uint16_t column16(const BitMatrix& m, size_t first_row, size_t k);
/// Transposes a block of 16 rows × 64 columns: columns[j] receives column 64·w + j of the 16 rows that start
/// at `first_row`.
void columns16(const BitMatrix& m, size_t first_row, size_t w, uint16_t columns[64]);
/// The inverse: ORs 64 columns of 16 bits into the rows.
void or_columns16(BitMatrix& m, size_t first_row, size_t w, const uint16_t columns[64]);

}  // namespace viscache
