// Next Event Estimation++: its settings, and its voxel map kept between frames.

#include "arrays.h"
#include "bind_rows.h"
#include "viscache/oracles/kept_voxels.h"
#include "viscache/scene/scene.h"

namespace viscache::bindings {

namespace {

/// Places and counts (N,) of all pairs with tests.
// Most pairs of voxels are never tested, so only the others are listed.
py::tuple state_of(const KeptVoxels& kept) {
    std::vector<uint64_t> place;
    std::vector<uint32_t> tested, seen;
    if (const VoxelVisibility* map = kept.map())
        for (size_t i = 0; i < map->size(); ++i) {
            const VoxelVisibility::Counts& c = map->at(i);
            if (c.tested == 0) continue;
            place.push_back(i);
            tested.push_back(c.tested);
            seen.push_back(c.seen);
        }
    return py::make_tuple(py::array_t<uint64_t>(py::ssize_t(place.size()), place.data()),
                          py::array_t<uint32_t>(py::ssize_t(tested.size()), tested.data()),
                          py::array_t<uint32_t>(py::ssize_t(seen.size()), seen.data()));
}

using Numbers = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;

void restore(KeptVoxels& kept, const Scene& scene, const NeePlusPlusSettings& settings, uint64_t frames,
             const WordArray& place, const Numbers& tested, const Numbers& seen) {
    // The arrays come from a file.
    if (place.ndim() != 1 || tested.ndim() != 1 || seen.ndim() != 1 || place.size() != tested.size() ||
        place.size() != seen.size())
        throw std::invalid_argument("places and counts must be rows of the same length");
    kept.begin_restore(scene.bounds(), settings, frames);
    for (py::ssize_t i = 0; i < place.size(); ++i)
        kept.restore(size_t(place.at(i)), {tested.at(i), seen.at(i)});
}

}  // namespace

void bind_nee_plus_plus(py::module_& m) {
    py::class_<NeePlusPlusSettings> settings(m, "NeePlusPlusSettings", "See viscache.NeePlusPlus.");
    bind_rows(settings, kNeePlusPlusRows);
    py::class_<KeptVoxels>(m, "KeptVoxels", "See viscache.VoxelCounts.")
        .def(py::init<>())
        .def_property_readonly("frames", &KeptVoxels::frames)
        .def_property_readonly("bytes", &KeptVoxels::bytes)
        .def_property_readonly("pairs_tested", &KeptVoxels::pairs_tested)
        .def("commit", &KeptVoxels::commit)
        .def("roll_back", &KeptVoxels::roll_back)
        .def("state", &state_of, "Places, tests and unblocked tests (N,) of all pairs with tests.")
        .def("restore", &restore, py::arg("scene"), py::arg("settings"), py::arg("frames"), py::arg("place"),
             py::arg("tested"), py::arg("seen"), "Sets what `state` gave, in an object without frames.");
}

}  // namespace viscache::bindings
