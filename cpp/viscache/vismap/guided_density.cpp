#include "viscache/vismap/guided_density.h"

#include "viscache/vismap/map_kernels.h"

namespace viscache {

bool shape_density(const ProductTree& tree, const MapIntegrals& integrals, const CellTables& cells,
                   double eta, GuidedDensity& out) {
    const int m = tree.map_level(), count = dilations(m);
    const std::array<double, 3> a = density_shares(m);
    double share[3]{};
    const double* dilated[3]{};
    for (int k = 0; k < count; ++k) {
        // μ_k, the mean of Ṽ^k under product sampling. Dividing by it gives each term of D the mean one.
        const double mu = integrals.dilated[size_t(k)] / tree.total();
        // The records see almost none of the light: D would be η nearly everywhere and huge in a few cells.
        if (!(mu > kLeastSeen)) return false;
        share[k] = (1 - eta) * a[size_t(k)] / mu;
        dilated[k] = cells.dilated[size_t(k)].data();
    }
    out.d.resize(cells.visible.size());
    out.w2 = map_kernels(active_isa())
                 .shape(out.d.size(), eta, share, count, tree.masses(m).data(), cells.visible.data(), dilated,
                        out.d.data());
    return true;
}

}  // namespace viscache
