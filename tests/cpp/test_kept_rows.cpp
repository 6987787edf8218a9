// aqvc: which tiles keep their rows, and what a frame that is taken back leaves of them.
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

/// The rows of a tile with some eye points and three lights, and its cells at two levels.
struct OneTile {
    OneTile() : grid(AqvcParameters{}, {0, 0, 0}, 2) {
        for (int i = 0; i < 40; ++i) {
            eyes.position.push_back({0.04f * float(i) - 0.8f, 0, 0.01f * float(i)});
            eyes.normal.push_back({0, 1, 0});
            eyes.origin.push_back(eyes.position.back());
            eyes.density.push_back(2000);
        }
        for (const float at : {0.f, 1.f, 2.f})
            for (auto* v : {&lights.x, &lights.y, &lights.z, &lights.tx, &lights.ty, &lights.tz})
                v->push_back(at);
        lights.count = lights.x.size();
        anchors.make(eyes, grid);
        placer.begin(anchors);
        cells.make(anchors, placer, levels);
        wanted.reset(eyes.size(), lights.count);
        columns.prepare(lights, wanted, grid, AqvcParameters{}, anchors.usable, clamps);
        rows.begin(columns, levels);
        known.reset(cells.size(), lights.count);
        value.reset(cells.size(), lights.count);
        rows.load(cells, known, value);
    }
    /// One more light is known in all cells, and seen in every second of them.
    void learn(size_t light) {
        for (size_t c = 0; c < cells.size(); ++c) {
            known.set(c, light);
            if (c % 2) value.set(c, light);
        }
        rows.store(cells, known, value);
    }
    /// What the next frame would find.
    BitMatrix found(bool values) {
        BitMatrix a(cells.size(), lights.count), b(cells.size(), lights.count);
        rows.load(cells, a, b);
        return std::move(values ? b : a);
    }

    EyeBlock eyes;
    FarEnds lights;
    const std::vector<double> levels{16, 4};
    CellGrid grid;
    TileAnchors anchors;
    CellPlacer placer;
    TileCells cells;
    BitMatrix wanted, known, value;
    Columns columns;
    ClampCounts clamps;
    KeptRows rows;
};

void a_row_that_changed_twice_is_what_it_was_before_the_first_change() {
    OneTile tile;
    tile.learn(0);
    tile.rows.commit();
    const size_t cells = tile.rows.cells();
    check_equal(cells, tile.cells.size(), "cells of the finished frame");
    const uint64_t seen = count_bits(tile.found(true));
    // A frame that does not finish stores twice
    tile.rows.load(tile.cells, tile.known, tile.value);
    tile.learn(1);
    tile.learn(2);
    check_equal(count_bits(tile.found(false)), uint64_t{3 * cells}, "known bits within the frame");
    for (const char* which : {"taken back", "taken back twice"}) {
        tile.rows.roll_back();
        const BitMatrix known = tile.found(false);
        check_equal(count_bits(known), uint64_t{cells}, std::string("known bits ") + which);
        for (size_t c = 0; c < cells; ++c) check(known.get(c, 0), "the first light is known still");
        check_equal(count_bits(tile.found(true)), seen, std::string("seen bits ") + which);
        check_equal(tile.rows.cells(), cells, "cells");
    }
    // The next frame learns the same again and finishes
    tile.known.reset(cells, tile.lights.count);
    tile.value.reset(cells, tile.lights.count);
    tile.rows.load(tile.cells, tile.known, tile.value);
    tile.learn(2);
    tile.rows.commit();
    tile.rows.roll_back();
    check_equal(count_bits(tile.found(false)), uint64_t{2 * cells}, "known bits of the finished frame");
}

void the_first_frame_leaves_nothing_when_it_is_taken_back() {
    OneTile tile;
    tile.learn(0);
    tile.rows.roll_back();
    tile.rows.roll_back();
    check_equal(tile.rows.cells(), size_t{0}, "cells");
    tile.learn(1);
    check_equal(count_bits(tile.found(false)), uint64_t{2 * tile.cells.size()}, "known bits of a new frame");
}

const Suite suite{
    {"kept rows: the smallest tiles keep their rows in whatever order they end",
     the_smallest_tiles_keep_their_rows_in_whatever_order_they_end},
    {"kept rows: a frame that does not finish takes no rows of earlier ones",
     a_frame_that_does_not_finish_takes_no_rows_of_earlier_ones},
    {"kept rows: a row that changed twice is what it was before the first change",
     a_row_that_changed_twice_is_what_it_was_before_the_first_change},
    {"kept rows: the first frame leaves nothing when it is taken back",
     the_first_frame_leaves_nothing_when_it_is_taken_back},
};

}  // namespace
}  // namespace viscache::test::kept_rows_tests
