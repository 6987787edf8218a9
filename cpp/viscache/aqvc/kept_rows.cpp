#include "viscache/aqvc/kept_rows.h"

#include <bit>
#include <cstring>
#include <stdexcept>

#include "viscache/sampling/rng.h"

namespace viscache {

namespace {

template <class T>
uint64_t mixed(uint64_t digest, std::span<const T> values) {
    for (const T v : values) {
        uint64_t bits = 0;
        std::memcpy(&bits, &v, sizeof v);
        digest = mix64(digest ^ bits) + 0x9E3779B97F4A7C15ull;
    }
    return digest;
}

/// Never 0, which stands for "no rows".
uint64_t digest_of(const Columns& columns, const std::vector<double>& levels) {
    const FarEnds& l = columns.lights();
    uint64_t digest = mix64(uint64_t(l.count) << 8 | uint64_t(l.semantic));
    for (const auto* v : {&l.x, &l.y, &l.z, &l.nx, &l.ny, &l.nz, &l.tx, &l.ty, &l.tz, &l.density})
        digest = mixed(digest, std::span<const float>(v->data(), std::min(l.count, v->size())));
    return mixed(digest, std::span<const double>(levels)) | 1;
}

}  // namespace

void KeptRows::clear() {
    numbers_.clear();
    rows_.clear();
    committed_ = 0;
    changed_.clear();
    before_.clear();
}

void KeptRows::begin(const Columns& columns, const std::vector<double>& levels) {
    const uint64_t digest = digest_of(columns, levels);
    if (digest == digest_) return;
    clear();
    digest_ = digest;
    row_words_ = row_words_for(columns.count());
}

void KeptRows::load(const TileCells& cells, BitMatrix& known, BitMatrix& value) {
    const size_t bytes = row_words_ * sizeof(Word);
    kept_of_.resize(cells.size());
    for (size_t level = 0; level < cells.levels(); ++level)
        for (uint32_t c = cells.begin(level); c < cells.begin(level + 1); ++c) {
            kept_of_[c] = numbers_.size() ? numbers_.find(cells.cell(c), uint32_t(level)) : kNoCell;
            if (kept_of_[c] == kNoCell) continue;
            std::memcpy(known.row(c), row(kept_of_[c]), bytes);
            std::memcpy(value.row(c), row(kept_of_[c]) + row_words_, bytes);
        }
}

uint64_t KeptRows::store(const TileCells& cells, const BitMatrix& known, const BitMatrix& value,
                         uint64_t most_bytes) {
    const size_t bytes = row_words_ * sizeof(Word), most_cells = most_bytes / bytes_per_cell();
    uint64_t left_out = 0;
    if (numbers_.size() == 0) numbers_.clear();
    for (size_t level = 0; level < cells.levels(); ++level)
        for (uint32_t c = cells.begin(level); c < cells.begin(level + 1); ++c) {
            uint32_t kept = kept_of_[c];
            if (kept == kNoCell) {
                if (numbers_.size() >= most_cells) {
                    ++left_out;
                    continue;
                }
                kept = numbers_.number(cells.cell(c), uint32_t(level));
                rows_.resize(2 * row_words_ * numbers_.size());
            } else {
                // Bits are only added, so that equal masks mean equal rows
                if (std::memcmp(row(kept), known.row(c), bytes) == 0) continue;
                if (kept < committed_) {
                    changed_.push_back(kept);
                    before_.insert(before_.end(), row(kept), row(kept) + 2 * row_words_);
                }
            }
            std::memcpy(row(kept), known.row(c), bytes);
            std::memcpy(row(kept) + row_words_, value.row(c), bytes);
        }
    return left_out;
}

void KeptRows::commit() {
    committed_ = numbers_.size();
    changed_ = {};
    before_ = {};
}

void KeptRows::roll_back() {
    for (size_t i = 0; i < changed_.size(); ++i)
        std::memcpy(row(changed_[i]), before_.data() + i * 2 * row_words_, 2 * row_words_ * sizeof(Word));
    numbers_.truncate(committed_);
    rows_.resize(2 * row_words_ * committed_);
    changed_.clear();
    before_.clear();
}

KeptRows::State KeptRows::state() const {
    State s{digest_, row_words_, {}, {}};
    for (size_t i = 0; i < committed_; ++i) {
        const Cell& c = numbers_[i];
        s.cells.insert(s.cells.end(), {c.bin, c.slot, c.x, c.y, c.z, int64_t(numbers_.tag(i))});
    }
    s.rows.assign(rows_.begin(), rows_.begin() + ptrdiff_t(2 * row_words_ * committed_));
    return s;
}

void KeptRows::restore(const State& s) {
    const size_t n = s.cells.size() / kCellNumbers;
    if (s.cells.size() % kCellNumbers || s.row_words % kRowAlignmentWords || s.row_words > 1 << 20 ||
        s.rows.size() != 2 * s.row_words * n)
        throw std::invalid_argument("kept rows must have six numbers per cell and two rows");
    clear();
    digest_ = s.digest;
    row_words_ = s.row_words;
    for (size_t i = 0; i < n; ++i) {
        const int64_t* v = s.cells.data() + i * kCellNumbers;
        if (numbers_.number({int32_t(v[0]), int32_t(v[1]), v[2], v[3], v[4]}, uint32_t(v[5])) != i)
            throw std::invalid_argument("kept rows must name each cell once");
    }
    rows_ = s.rows;
    committed_ = n;
}

void AqvcRows::begin_frame(size_t tiles) {
    if (tiles != tiles_.size()) tiles_.clear();
    tiles_.resize(tiles);
    for (Tile& tile : tiles_)
        for (KeptRows& rows : tile) rows.roll_back();
}

void AqvcRows::commit() {
    for (Tile& tile : tiles_)
        for (KeptRows& rows : tile) rows.commit();
    ++frames_;
}

uint64_t AqvcRows::most_bytes(size_t tile, int group) const {
    uint64_t others = 0;
    for (size_t g = 0; g < kLightGroups; ++g)
        if (int(g) != group) others += tiles_.at(tile)[g].bytes();
    const uint64_t share = max_bytes_ / tiles_.size();
    return share > others ? share - others : 0;
}

uint64_t AqvcRows::cells() const {
    uint64_t n = 0;
    for (const Tile& tile : tiles_)
        for (const KeptRows& rows : tile) n += rows.cells();
    return n;
}

uint64_t AqvcRows::bytes() const {
    uint64_t n = 0;
    for (const Tile& tile : tiles_)
        for (const KeptRows& rows : tile) n += rows.bytes();
    return n;
}

void AqvcRows::begin_restore(size_t tiles, uint64_t frames) {
    tiles_.clear();
    tiles_.resize(tiles);
    frames_ = frames;
}

}  // namespace viscache
