#pragma once
// The inner loops over the cells of blended maps. One variant per instruction set; all give the same bits.
#include "viscache/math/isa.h"
#include "viscache/vismap/blended_maps.h"

namespace viscache {

/// Sums over cells: P Ṽ, P Ṽ², P_c Ṽ of the channels, P Ṽ^k of the dilated maps.
struct CellSums {
    double j, w2, colour[3], dilated[3];
};
/// Integrals of L·B̃ over the cells, along the Morton curve.
struct CellMasses {
    const double* luminance;
    const double* colour[3];
};

struct MapKernels {
    /// Fills visible[z] and, for k < `dilations`, dilated[k][z].
    CellSums (*expand)(const BlendedMaps& maps, int dilations, const CellMasses& masses, double* visible,
                       double* const* dilated);
    /// density[z] = floor + Σ share[k] · dilated[k][z]; returns Σ P Ṽ²/density.
    double (*shape)(size_t cells, double floor, const double* share, int dilations, const double* mass,
                    const double* visible, const double* const* dilated, double* density);
};

const MapKernels& map_kernels(Isa isa);

}  // namespace viscache
