#include "viscache/aqvc/kept_rows.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "viscache/sampling/rng.h"

namespace viscache {

namespace {

/// Mixes the bits of values in order.
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
    // Everything that a bit of these rows depends on besides the geometry: positions, normals, targets and
    // densities of the lights, and C_E of the levels.
    for (const auto* v : {&l.x, &l.y, &l.z, &l.nx, &l.ny, &l.nz, &l.tx, &l.ty, &l.tz, &l.density})
        // Arrays that a semantic does not need may be empty, others padded.
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
    // The same lights and levels: the rows of earlier frames hold.
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
            // A cell is the same in every frame: its number in the grid does not depend on eye points.
            kept_of_[c] = numbers_.size() ? numbers_.find(cells.cell(c), uint32_t(level)) : kNoCell;
            if (kept_of_[c] == kNoCell) continue;
            std::memcpy(known.row(c), row(kept_of_[c]), bytes);
            std::memcpy(value.row(c), row(kept_of_[c]) + row_words_, bytes);
        }
}

void KeptRows::store(const TileCells& cells, const BitMatrix& known, const BitMatrix& value) {
    const size_t bytes = row_words_ * sizeof(Word);
    // Taking a frame back may have freed its hash table.
    if (numbers_.size() == 0) numbers_.clear();
    for (size_t level = 0; level < cells.levels(); ++level)
        for (uint32_t c = cells.begin(level); c < cells.begin(level + 1); ++c) {
            uint32_t kept = kept_of_[c];
            if (kept == kNoCell) {
                kept = numbers_.number(cells.cell(c), uint32_t(level));
                rows_.resize(2 * row_words_ * numbers_.size());
            } else {
                // Bits are only added, so that equal masks mean equal rows
                if (std::memcmp(row(kept), known.row(c), bytes) == 0) continue;
                // Only rows of finished frames need a copy; new ones are cut off at the end.
                if (kept < committed_) {
                    changed_.push_back(kept);
                    before_.insert(before_.end(), row(kept), row(kept) + 2 * row_words_);
                }
            }
            std::memcpy(row(kept), known.row(c), bytes);
            std::memcpy(row(kept) + row_words_, value.row(c), bytes);
        }
}

void KeptRows::commit() {
    committed_ = numbers_.size();
    changed_ = {};
    before_ = {};
}

void KeptRows::roll_back() {
    if (committed_ == 0) {  // frees its memory, too
        numbers_ = {};
        rows_ = {};
    }
    // Rows of finished frames get their contents back, the first of several changes last; all others vanish
    // by truncation.
    for (size_t i = changed_.size(); i-- > 0;)
        std::memcpy(row(changed_[i]), before_.data() + i * 2 * row_words_, 2 * row_words_ * sizeof(Word));
    numbers_.truncate(committed_);
    rows_.resize(2 * row_words_ * committed_);
    changed_.clear();
    before_.clear();
}

KeptRows::State KeptRows::state() const {
    State s{digest_, row_words_, {}, {}};
    // Only finished frames: a state never contains half a frame.
    for (size_t i = 0; i < committed_; ++i) {
        const Cell& c = numbers_[i];
        s.cells.insert(s.cells.end(), {c.bin, c.slot, c.x, c.y, c.z, int64_t(numbers_.tag(i))});
    }
    s.rows.assign(rows_.begin(), rows_.begin() + ptrdiff_t(2 * row_words_ * committed_));
    return s;
}

void KeptRows::restore(const State& s) {
    const size_t n = s.cells.size() / kCellNumbers;
    // Files are not trusted: sizes must fit together before anything is copied. 2^20 words per row are 64
    // million lights.
    if (s.cells.size() % kCellNumbers || s.row_words % kRowAlignmentWords || s.row_words > 1 << 20 ||
        s.rows.size() != 2 * s.row_words * n)
        throw std::invalid_argument("kept rows must have six numbers per cell and two rows");
    clear();
    digest_ = s.digest;
    row_words_ = s.row_words;
    for (size_t i = 0; i < n; ++i) {
        const int64_t* v = s.cells.data() + i * kCellNumbers;
        // Equal cells would get the same number.
        if (numbers_.number({int32_t(v[0]), int32_t(v[1]), v[2], v[3], v[4]}, uint32_t(v[5])) != i)
            throw std::invalid_argument("kept rows must name each cell once");
    }
    rows_ = s.rows;
    committed_ = n;
}

void AqvcRows::clear() {
    tiles_.clear();
    begin_room();
}

void AqvcRows::begin_room() {
    with_room_.clear();
    first_left_out_.reset();
    left_out_.assign(tiles_.size(), false);
    bytes_with_room_ = tiles_not_kept_ = 0;
}

void AqvcRows::begin_frame(size_t tiles) {
    // Another number of tiles is another picture, whose rows say nothing here.
    if (tiles != tiles_.size()) tiles_.clear();
    tiles_.resize(tiles);
    for (Tile& tile : tiles_)
        for (KeptRows& rows : tile) rows.roll_back();
    begin_room();
}

uint64_t AqvcRows::bytes_of(const Tile& tile) {
    uint64_t n = 0;
    for (const KeptRows& rows : tile) n += rows.bytes();
    return n;
}

void AqvcRows::end_tile(size_t tile) {
    const std::lock_guard lock(mutex_);
    const Tile& rows = tiles_.at(tile);
    const bool is_new =
        std::none_of(rows.begin(), rows.end(), [](const KeptRows& r) { return r.has_committed(); });
    // The smallest come first, so the most tiles have room; equal ones in the order of tiles.
    const Ended ended{is_new, bytes_of(rows), tile};
    // A tile that comes after the first without room has none either.
    if (first_left_out_ && *first_left_out_ < ended) return leave_out(ended);
    with_room_.insert(ended);
    bytes_with_room_ += ended.bytes;
    // The last one goes: with those before it that are still to end, it exceeds the room all the more
    while (bytes_with_room_ > max_bytes_) {
        first_left_out_ = *with_room_.rbegin();
        with_room_.erase(*first_left_out_);
        bytes_with_room_ -= first_left_out_->bytes;
        leave_out(*first_left_out_);
    }
}

/// Takes back what a tile stored in this frame.
void AqvcRows::leave_out(const Ended& ended) {
    left_out_[ended.tile] = true;
    tiles_not_kept_ += ended.bytes > 0;
    for (KeptRows& rows : tiles_[ended.tile]) rows.roll_back();
}

void AqvcRows::commit() {
    for (size_t i = 0; i < tiles_.size(); ++i)
        // Without room a tile keeps no rows at all, those of earlier frames included.
        if (left_out_[i])
            tiles_[i] = {};
        else
            for (KeptRows& rows : tiles_[i]) rows.commit();
    ++frames_;
}

uint64_t AqvcRows::cells() const {
    uint64_t n = 0;
    for (size_t i = 0; i < tiles_.size(); ++i)
        for (const KeptRows& rows : tiles_[i]) n += left_out_[i] ? 0 : rows.cells();
    return n;
}

uint64_t AqvcRows::bytes() const {
    uint64_t n = 0;
    for (size_t i = 0; i < tiles_.size(); ++i) n += left_out_[i] ? 0 : bytes_of(tiles_[i]);
    return n;
}

void AqvcRows::begin_restore(size_t tiles, uint64_t frames) {
    tiles_.clear();
    tiles_.resize(tiles);
    begin_room();
    frames_ = frames;
}

}  // namespace viscache
