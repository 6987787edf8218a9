// aqvc: which tiles keep their rows.
#include <algorithm>

#include "check.h"
#include "viscache/aqvc/kept_rows.h"

namespace viscache::test::kept_rows_tests {
namespace {

const std::vector<size_t> kCells{300, 200, 0, 400, 100, 900, 1};

/// Rows of a finished frame, with so many cells per tile.
void restore(AqvcRows& rows) {
    rows.begin_restore(kCells.size(), 1);
    for (size_t tile = 0; tile < kCells.size(); ++tile) {
        KeptRows::State s{1, kRowAlignmentWords, {}, {}};
        for (size_t i = 0; i < kCells[tile]; ++i) s.cells.insert(s.cells.end(), {0, 0, int64_t(i), 0, 0, 0});
        s.rows.resize(2 * s.row_words * kCells[tile]);
        rows.restore(tile, 0, s);
    }
}

uint64_t bytes_per_cell() {
    AqvcRows rows(0);
    restore(rows);
    return rows.bytes() / rows.cells();
}

struct Kept {
    uint64_t cells, tiles_left_out;
    bool operator==(const Kept&) const = default;
};

/// What a frame keeps whose tiles end in this order, with room for so many cells.
Kept frame(uint64_t room, const std::vector<size_t>& order) {
    AqvcRows rows(room * bytes_per_cell());
    restore(rows);
    rows.begin_frame(kCells.size());
    for (const size_t tile : order) rows.end_tile(tile);
    const uint64_t before = rows.cells();
    rows.commit();
    check_equal(rows.cells(), before, "cells after the commit");
    return {rows.cells(), rows.tiles_not_kept()};
}

void the_smallest_tiles_keep_their_rows_in_whatever_order_they_end() {
    // Sorted: 0, 1, 100, 200, 300, 400, 900
    const std::vector<std::pair<uint64_t, Kept>> cases{
        {5000, {1901, 0}}, {1901, {1901, 0}}, {1900, {1001, 1}}, {1001, {1001, 1}}, {1000, {601, 2}},
        {600, {301, 3}},   {300, {101, 4}},   {100, {1, 5}},     {1, {1, 5}},       {0, {0, 6}}};
    std::vector<size_t> order(kCells.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    do {
        for (const auto& [room, expected] : cases) {
            const Kept got = frame(room, order);
            check_equal(got.cells, expected.cells, "cells with room for " + std::to_string(room));
            check_equal(got.tiles_left_out, expected.tiles_left_out, "tiles without room");
        }
    } while (order[0] == 0 && std::next_permutation(order.begin(), order.end()));
    for (int turns = 0; turns < 200; ++turns) {
        std::rotate(order.begin(), order.begin() + 3, order.end());
        std::swap(order[size_t(turns) % order.size()], order[0]);
        for (const auto& [room, expected] : cases)
            check(frame(room, order) == expected, "another order with room for " + std::to_string(room));
    }
}

void a_frame_that_does_not_finish_takes_no_rows_of_earlier_ones() {
    AqvcRows rows(400 * bytes_per_cell());
    restore(rows);
    rows.begin_frame(kCells.size());
    for (size_t tile = 0; tile < 4; ++tile) rows.end_tile(tile);
    check_equal(rows.tiles_not_kept(), uint64_t{2}, "tiles without room before the interrupt");
    rows.begin_frame(kCells.size());
    check_equal(rows.cells(), uint64_t{1901}, "cells after the interrupt");
    check_equal(rows.tiles_not_kept(), uint64_t{0}, "tiles without room of a new frame");
    for (size_t tile = 0; tile < kCells.size(); ++tile) rows.end_tile(tile);
    rows.commit();
    check_equal(rows.cells(), uint64_t{301}, "cells of the finished frame");
}

const Suite suite{
    {"kept rows: the smallest tiles keep their rows in whatever order they end",
     the_smallest_tiles_keep_their_rows_in_whatever_order_they_end},
    {"kept rows: a frame that does not finish takes no rows of earlier ones",
     a_frame_that_does_not_finish_takes_no_rows_of_earlier_ones},
};

}  // namespace
}  // namespace viscache::test::kept_rows_tests
