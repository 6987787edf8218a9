#pragma once
// Rows of bits in the layout of the pair kernel: panels of 16 points, interleaved word by word, with a mask
// of the units that contain set bits.
#include <functional>
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"

namespace viscache {

constexpr size_t kPanelRows = 16;
/// Number of rows of a panel that the kernel processes together.
constexpr size_t kQuadRows = 4;
/// Words per unit. A unit is counted, or skipped as dead, as a whole.
constexpr size_t kUnitWords = 2;
/// Words in a mask of live units; enough for `kMaxDirections`.
constexpr size_t kMaxLiveWords = 6;
/// Largest number of directions: its square fits into a signed 32-bit integer.
constexpr size_t kMaxDirections = 46340;
/// Represents a row of zeros in an order of points.
constexpr uint32_t kNoPoint = ~0u;

/// Writes the bits of a point into a row that contains zeros.
using RowSource = std::function<void(uint32_t point, Word* row)>;

/// Word k of the points of a panel is stored at panel[16·k] … panel[16·k + 15].
class BitPanels {
public:
    /// Builds the panels of the points in `order`, whose length is a multiple of 16. Rows have `words`
    /// words. Without `find_dead`, every unit counts as live.
    BitPanels(const RowSource& source, size_t words, std::span<const uint32_t> order, bool find_dead,
              int threads, Control& control);

    size_t panels() const { return bits_.rows(); }
    size_t live_words() const { return live_words_; }
    const Word* panel(size_t p) const { return bits_.row(p); }
    /// Mask of the units with a bit set in any of the rows 4·q … 4·q + 3.
    const Word* live_quad(size_t q) const { return live_quads_.data() + q * live_words_; }
    /// The same for the 16 rows of a panel.
    const Word* live_panel(size_t p) const { return live_panels_.data() + p * live_words_; }

private:
    void pack(const RowSource& source, std::span<const uint32_t> points, size_t p, Word* rows);
    void mark_live(size_t p, const Word* rows);

    BitMatrix bits_;
    size_t words_, live_words_;
    std::vector<Word> live_quads_, live_panels_;
};

}  // namespace viscache
