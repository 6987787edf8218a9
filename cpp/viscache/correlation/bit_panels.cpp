#include "viscache/correlation/bit_panels.h"

namespace viscache {

BitPanels::BitPanels(const RowSource& source, size_t words, std::span<const uint32_t> order, bool find_dead,
                     int threads, Control& control)
    : words_((words + kUnitWords - 1) / kUnitWords * kUnitWords),
      live_words_(words_for(words_ / kUnitWords)) {
    const size_t panels = order.size() / kPanelRows;
    bits_.reset(panels, words_ * kPanelRows * kWordBits);
    // Units past the last word are never counted
    std::vector<Word> all(live_words_);
    // Rows are padded to whole units; all of these exist, whether a bit is set or not.
    for (size_t u = 0; u < words_ / kUnitWords; ++u) set_bit(all.data(), u);
    for (std::vector<Word>* live : {&live_quads_, &live_panels_}) {
        const size_t rows = live == &live_panels_ ? panels : panels * (kPanelRows / kQuadRows);
        live->assign(rows * live_words_, 0);
        if (!find_dead)
            for (size_t i = 0; i < live->size(); ++i) (*live)[i] = all[i % live_words_];
    }
    std::vector<std::vector<Word>> scratch(size_t(resolve_threads(threads)));
    parallel_for(panels, threads, [&](size_t p, int worker) {
        control.check();
        std::vector<Word>& rows = scratch[size_t(worker)];
        rows.assign(kPanelRows * words_, 0);
        // First row by row, as the source writes them; then word by word across the panel.
        pack(source, order.subspan(p * kPanelRows, kPanelRows), p, rows.data());
        if (find_dead) mark_live(p, rows.data());
    });
}

///
///     rows                         panel
///     point 0    a0 a1 a2 ...      a0 b0 c0 ... p0     word 0 of 16 points: two vectors of 512 bits
///     point 1    b0 b1 b2 ...      a1 b1 c1 ... p1     word 1
///
/// A word of one row, in all lanes, meets the same word of 8 columns without any shuffle.
void BitPanels::pack(const RowSource& source, std::span<const uint32_t> points, size_t p, Word* rows) {
    for (size_t r = 0; r < kPanelRows; ++r)
        if (points[r] != kNoPoint) source(points[r], rows + r * words_);
    Word* out = bits_.row(p);
    for (size_t k = 0; k < words_; ++k)
        for (size_t r = 0; r < kPanelRows; ++r) out[k * kPanelRows + r] = rows[r * words_ + k];
}

/// A point sees nothing below its horizon. Panels of similar normals have whole units of zeros there.
void BitPanels::mark_live(size_t p, const Word* rows) {
    for (size_t r = 0; r < kPanelRows; ++r) {
        const size_t quad = (p * kPanelRows + r) / kQuadRows;
        for (size_t k = 0; k < words_; ++k) {
            if (!rows[r * words_ + k]) continue;
            set_bit(live_quads_.data() + quad * live_words_, k / kUnitWords);
            set_bit(live_panels_.data() + p * live_words_, k / kUnitWords);
        }
    }
}

}  // namespace viscache
