#pragma once
// Light groups whose members are shared by all eye points, and the sums over them.
//
// A row of bits says which lights are asked for (`wanted_row`) and which are seen (`sum_row`). One function
// adds contributions under a mask, in one order (16 running sums, then a fixed tree), for every oracle and
// every ISA: two oracles that give the same bits give the same pixels.
#include <vector>

#include "viscache/scene/bsdf.h"
#include "viscache/visibility/counters.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

struct SharedLights {
    FarEnds ends;
    std::vector<float> r, g,
        b;             ///< intensity, irradiance, or reflected flux density of a VPL; padded with zeros
    float bound2 = 0;  ///< VPLs: added to d² in the geometry term; 0 = unbounded
    bool empty() const { return ends.count == 0; }

    /// Adds a column. `end` is where shadow rays stop, `value` the RGB factor of its contributions.
    void add(Vec3 position, Vec3 normal, Vec3 end, Rgb value, float density);
    /// Pads all arrays to whole rows; call once after the last `add`.
    void pad();
};

/// One eye point's side of a connection.
struct EyeShade {
    Vec3 position, ng, ns;
};

/// Geometry factor g of every column, unoccluded: point cosθ/d², direction cosθ, VPL cosθ·cosθ'/(d² +
/// bound²). Sets the bits of `row` where 0 < g < ∞; returns the number of columns with g = ∞ (dropped,
/// counted as non-finite).
uint64_t wanted_row(const SharedLights& lights, const EyeShade& eye, Word* row);

/// Row i gets the bits of the columns whose unoccluded contribution g·(r + g + b) is at most shares[i] times
/// the mean of the positive ones. `scratch` holds a float per column.
void at_most_rows(const SharedLights& lights, const EyeShade& eye, std::span<const float> shares,
                  std::span<Word* const> rows, std::vector<float>& scratch);

/// Σ g_k · value_k over the set bits.
Rgb sum_row(const SharedLights& lights, const EyeShade& eye, const Word* row);

}  // namespace viscache
