#pragma once
// Light × reflection × approximate visibility: the integral J of the control variate, the moments of W = Ṽ
// under the density of product sampling, and Ṽ for each cell.
#include "viscache/vismap/blended_maps.h"
#include "viscache/vismap/product_tree.h"

namespace viscache {

/// Sums over the cells of the maps, in double; P is the integral of L·B̃ over a cell.
struct MapIntegrals {
    double j = 0;                      ///< Σ P Ṽ of luminances
    double w2 = 0;                     ///< Σ P Ṽ²
    std::array<double, 3> j_colour{};  ///< Σ P Ṽ of every channel: J
    std::array<double, 3> dilated{};   ///< Σ P Ṽ^k of the dilated maps
};

/// Ṽ and its dilations over the cells at one point, along the Morton curve.
struct CellTables {
    std::vector<double> visible;
    std::array<std::vector<double>, 3> dilated;
};

/// Processes all cells, eight at a time; the cost does not depend on the content of the maps. Dilated maps
/// are used only with `with_dilated`. Without maps, all results are zero.
MapIntegrals integrate_maps(const ProductTree& tree, const BlendedMaps& maps, bool with_dilated,
                            CellTables& cells);
MapIntegrals integrate_maps(const ProductTree& tree, const BlendedMaps& maps, bool with_dilated,
                            CellTables& cells, Isa isa);

/// J and Σ P Ṽ² of luminances by the walk of Sec. 5.3 through the quadtrees of all records at once. A record
/// that is completely free or blocked in a node needs no further descent.
struct WalkIntegrals {
    double j = 0, w2 = 0;
    size_t nodes = 0;  ///< number of visited nodes
};
WalkIntegrals walk_maps(const ProductTree& tree, const BlendedMaps& maps);

}  // namespace viscache
