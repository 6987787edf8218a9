#include "viscache/visibility/visible_matrix.h"

#include <algorithm>
#include <bit>

#include "viscache/math/morton.h"
#include "viscache/visibility/segment_packets.h"

namespace viscache {

namespace {

constexpr size_t kPointsPerTile = 128, kLanes = 16;

/// The packet that is being filled: the lanes are points for one target. With fewer than 16 points, it also
/// holds the next targets.
class Filler {
public:
    Filler(const RayCaster& caster, std::span<Word> rows, size_t row_words, size_t word)
        : segments_(caster), rows_(rows), row_words_(row_words), word_(word) {}

    void add(uint32_t point, Vec3 from, int column, Vec3 to) {
        packet_.start(used_, from);
        packet_.aim(used_, to);
        point_[used_] = point;
        column_[used_] = column;
        if (++used_ == kLanes) flush();
    }
    void flush() {
        if (used_ == 0) return;
        const auto mask = uint16_t((1u << used_) - 1u);
        const uint32_t free = mask & ~uint32_t(segments_.occluded(mask, packet_));
        for (size_t i = 0; i < used_; ++i)
            rows_[point_[i] * row_words_ + word_] |= Word{free >> i & 1u} << column_[i];
        used_ = 0;
        packet_ = {};
    }

private:
    SegmentPackets segments_;
    std::span<Word> rows_;
    size_t row_words_, word_;
    RayPacket16 packet_{};
    uint32_t point_[kLanes];
    int column_[kLanes];
    size_t used_ = 0;
};

}  // namespace

void trace_matrix_tile(const RayCaster& caster, std::span<const Vec3> points, std::span<const uint32_t> some,
                       std::span<const Vec3> targets, size_t word, Word wanted, std::span<Word> rows) {
    Filler filler(caster, rows, words_for(targets.size()), word);
    for (Word rest = wanted; rest; rest &= rest - 1) {
        const int column = std::countr_zero(rest);
        const Vec3 to = targets[word * kWordBits + size_t(column)];
        for (const uint32_t i : some) filler.add(i, points[i], column, to);
    }
    filler.flush();
}

void visible_matrix(const RayCaster& caster, std::span<const Vec3> points, std::span<const Vec3> targets,
                    std::span<Word> rows, int threads, Control& control) {
    const size_t row_words = words_for(targets.size());
    const std::vector<uint32_t> along = morton_order(points);  // neighbours in space share packets
    const size_t tiles = (points.size() + kPointsPerTile - 1) / kPointsPerTile;
    control.total = tiles * row_words;
    // A work item is 128 points and one word of targets; its words belong to no other item
    parallel_for(tiles * row_words, threads, [&](size_t item, int) {
        control.check();
        const size_t first = item / row_words * kPointsPerTile, word = item % row_words;
        const auto some = std::span(along).subspan(first, std::min(kPointsPerTile, points.size() - first));
        for (const uint32_t i : some) rows[i * row_words + word] = 0;
        trace_matrix_tile(caster, points, some, targets, word, targets_of_word(targets.size(), word), rows);
        ++control.done;
    });
}

void visible_pairs(const RayCaster& caster, std::span<const Vec3> x, std::span<const Vec3> y,
                   std::span<bool> visible) {
    std::vector<Ray> rays(x.size());
    std::vector<uint8_t> blocked(x.size());
    for (size_t i = 0; i < x.size(); ++i) rays[i] = segment_between(x[i], y[i]);
    caster.occluded(rays, blocked);
    for (size_t i = 0; i < x.size(); ++i) visible[i] = !blocked[i];
}

}  // namespace viscache
