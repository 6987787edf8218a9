// Cells of 16 eye points at a time equal single ones, in every variant of the kernel.
#include <random>

#include "check.h"
#include "viscache/aqvc/place_cells.h"

namespace viscache::test::place_cells_tests {
namespace {

/// Points on slopes in all directions; some have no normal, are not finite or are far away.
EyeBlock points(float scale) {
    EyeBlock eyes;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> number(-1, 1);
    for (int i = 0; i < 1003; ++i) {
        const Vec3 n = normalize(Vec3{number(random), number(random), number(random)});
        eyes.position.push_back(Vec3{number(random), number(random), number(random)} * scale);
        eyes.normal.push_back(i % 50 == 7 ? Vec3{} : n);
        eyes.origin.push_back(eyes.position.back());
        const float density = std::exp(12 * number(random)) / (scale * scale);
        eyes.density.push_back(i % 90 == 3 ? kInfinity : i % 90 == 5 ? 0 : density);
        if (i % 70 == 9) eyes.position.back().x = kInfinity;
    }
    return eyes;
}

void compare(float scale, float radius, double c_e) {
    const CellGrid grid(AqvcParameters{}, {0.1f, 0.2f, 0.3f}, radius);
    const EyeBlock eyes = points(scale);
    TileAnchors tile;
    tile.make(eyes, grid);
    for (const Isa isa : {Isa::kPortable, Isa::kAvx2, Isa::kAvx512}) {
        if (isa > best_isa()) continue;
        CellPlacer placer;
        placer.begin(tile);
        PlacedLevel placed;
        ClampCounts clamps, singly;
        placer.place(c_e, placed, clamps, isa);
        for (size_t i = 0; i < tile.size(); ++i) {
            if (!tile.usable[i]) continue;
            const PlacedCell want = tile.cell(i, c_e, singly);
            check_equal(placed.slot[i], want.cell.slot, "rung");
            check_equal(placed.x[i], double(want.cell.x), "x");
            check_equal(placed.y[i], double(want.cell.y), "y");
            check_equal(placed.z[i], double(want.cell.z), "z");
            check_equal(placed.distance2[i], distance2_to_center(want), "distance to the centre");
        }
        check_equal(clamps.low, singly.low, "resolutions below 1");
        check_equal(clamps.high, singly.high, "resolutions beyond 32 bits");
        check_equal(clamps.nan, singly.nan, "resolutions that are no number");
    }
}

const Suite suite{
    {"cells of sixteen eye points equal those of one at a time",
     [] {
         for (const double c_e : {1e-9, 0.01, 1.0, 12.0, 1e6}) {
             compare(1, 2, c_e);
             compare(1e-4f, 3e-4f, c_e);
             compare(1e5f, 2e5f, c_e);
             compare(1, 1e9f, c_e);
         }
     }},
};

}  // namespace
}  // namespace viscache::test::place_cells_tests
