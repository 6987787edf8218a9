#pragma once
// Light groups that all eye points share, and sums over them.
//
// A row of bits says which lights need a query (`wanted_row`) and which are visible (`sum_row`). One function
// adds contributions under a mask, in one order (16 running sums, then a fixed tree), for every oracle and
// every instruction set. Two oracles that give the same bits therefore give the same pixels.
#include <vector>

#include "viscache/scene/bsdf.h"
#include "viscache/scene/spot_cone.h"
#include "viscache/visibility/counters.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

struct SharedLights {
    FarEnds ends;
    std::vector<float> r, g,
        b;                        ///< intensity, irradiance or reflected flux density; padded with zeros
    std::vector<SpotCone> cones;  ///< of points, one per column; empty without a spot light
    /// Of directions whose light samples of sharp lobes bring as well: number of these samples of an eye
    /// point over the density of the column's set; padded. Empty: there are none.
    std::vector<float> lobe_ratio;
    float bound2 = 0;       ///< for VPLs: added to d² in the geometry term; 0 = unbounded
    bool punctual = false;  ///< the lights have no extent, so that no reflected ray meets them
    float mean_light = 0;   ///< set_mean_light; 0: not known
    bool empty() const { return ends.count == 0; }
    bool has_lobes() const { return !lobe_ratio.empty(); }

    /// Adds a column. Shadow rays stop at `end`; `value` is the RGB factor of the contributions.
    void add(Vec3 position, Vec3 normal, Vec3 end, Rgb value, float density);
    /// Gives the last column a cone.
    void set_cone(const SpotCone& cone);
    /// Pads all arrays to whole rows. Call it once after the last `add`.
    void pad();
};

/// The eye point of a connection.
struct EyeShade {
    Vec3 position, ng, ns;
};

/// Factors of the columns' cones towards `position`, padded; nullptr if no column has a cone. The row is
/// valid until the next call on this thread.
const float* cone_row(const SharedLights& lights, Vec3 position);

/// Unoccluded geometry factor g of every column: cosθ/d² times the cone's factor (point), cosθ (direction),
/// cosθ·cosθ'/(d² + bound²) (VPL). Sets the bits of `row`, zeroed on entry, of the columns in `range` where
/// 0 < g < ∞ and the value is not black. Returns the number of columns with g = ∞, which are dropped and
/// counted as non-finite.
uint64_t wanted_row(const SharedLights& lights, const EyeShade& eye, ColumnRange range, Word* row);

/// Unoccluded contribution g·(r + g + b) of the columns in `range`; 0 where it is infinite. `row` has one
/// float per column, padded; those of other columns may hold anything. Returns the mean of the positive ones.
float contribution_row(const SharedLights& lights, const EyeShade& eye, ColumnRange range,
                       std::vector<float>& row);

/// Sets in rows[i] the bits of the columns whose entry in `row`, a contribution_row, is at most bounds[i].
void at_most_rows(std::span<const float> row, std::span<const float> bounds, std::span<Word* const> rows);

/// Sum of the entries of a contribution_row under a mask, in the order of `sum_row`.
float masked_sum(std::span<const float> row, const Word* mask);

/// Σ g_k · value_k over the set bits.
Rgb sum_row(const SharedLights& lights, const EyeShade& eye, const Word* row);

}  // namespace viscache
