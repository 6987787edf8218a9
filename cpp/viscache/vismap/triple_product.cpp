#include "viscache/vismap/triple_product.h"

#include "viscache/vismap/map_kernels.h"
#include "viscache/vismap/record.h"

namespace viscache {

MapIntegrals integrate_maps(const ProductTree& tree, const BlendedMaps& maps, bool with_dilated,
                            CellTables& cells, Isa isa) {
    const size_t n = map_cells(maps.m);
    // Dilated maps serve the guided density only.
    const int dilations = with_dilated ? viscache::dilations(maps.m) : 0;
    cells.visible.resize(n);
    double* dilated[3]{};
    for (int k = 0; k < dilations; ++k) {
        cells.dilated[size_t(k)].resize(n);
        dilated[k] = cells.dilated[size_t(k)].data();
    }
    const CellMasses masses{
        tree.masses(maps.m).data(),
        {tree.cell_colours(0).data(), tree.cell_colours(1).data(), tree.cell_colours(2).data()}};
    const CellSums s = map_kernels(isa).expand(maps, dilations, masses, cells.visible.data(), dilated);
    return {s.j, s.w2, {s.colour[0], s.colour[1], s.colour[2]}, {s.dilated[0], s.dilated[1], s.dilated[2]}};
}

MapIntegrals integrate_maps(const ProductTree& tree, const BlendedMaps& maps, bool with_dilated,
                            CellTables& cells) {
    return integrate_maps(tree, maps, with_dilated, cells, active_isa());
}

namespace {

/// State of one walk. Records that are still undecided at a node are passed as a mask.
struct Walk {
    const ProductTree& tree;
    const BlendedMaps& maps;
    WalkIntegrals sums{};

    // Records that are free in the whole node have added their weight to v. A node without undecided records
    // is done: Ṽ is constant in it.
    void visit(int level, uint32_t node, unsigned undecided, double v) {
        const double p = tree.masses(level)[node];
        ++sums.nodes;
        // No light or no reflection here
        if (p == 0) return;
        unsigned partial = 0;
        for (int i = 0; i < maps.count; ++i) {
            if (!(undecided >> i & 1)) continue;
            const NodeCode code = node_code(maps.m, maps.bits[i], maps.hierarchy[i], level, node);
            // v is a copy: siblings do not see it.
            if (code == kFree) v += double(maps.beta[i]);
            if (code == kPartial) partial |= 1u << i;
        }
        if (partial == 0) {
            sums.j += p * v;
            sums.w2 += p * v * v;
            return;
        }
        for (uint32_t child = 4 * node; child < 4 * node + 4; ++child) visit(level + 1, child, partial, v);
    }
};

}  // namespace

WalkIntegrals walk_maps(const ProductTree& tree, const BlendedMaps& maps) {
    Walk walk{tree, maps};
    if (maps.count > 0) walk.visit(0, 0, (1u << maps.count) - 1, 0);
    return walk.sums;
}

}  // namespace viscache
