// The Python module core.testing: equations and parts of structures that only tests call.
#include <pybind11/pybind11.h>

#include "gil.cpp"  // a module has its own list of its threads

namespace py = pybind11;

namespace viscache::bindings {
void bind_aqvc_equations(py::module_& t);
void bind_aqvc_run(py::module_& t);
void bind_aqvc_samples(py::module_& t);
void bind_light_choice(py::module_& t);
void bind_ray_batches(py::module_& t);
void bind_reflection(py::module_& t);
void bind_sampling(py::module_& t);
void bind_shadow_and_voxel_maps(py::module_& t);
void bind_triangles(py::module_& t);
void bind_vismap_cache_maps(py::module_& t);
void bind_vismap_equations(py::module_& t);
void bind_vismap_product(py::module_& t);
void bind_vlf(py::module_& t);
void bind_warp(py::module_& t);
}  // namespace viscache::bindings

PYBIND11_MODULE(testing, m) {
    using namespace viscache::bindings;
    m.doc() = "Equations and parts of structures of the C++ core that only tests call.";
    // Its classes (scenes, ray casters, settings) are arguments here
    py::module_::import("viscache._core");
    bind_aqvc_equations(m);
    bind_aqvc_run(m);
    bind_aqvc_samples(m);
    bind_light_choice(m);
    bind_ray_batches(m);
    bind_reflection(m);
    bind_sampling(m);
    bind_shadow_and_voxel_maps(m);
    bind_triangles(m);
    bind_vismap_cache_maps(m);
    bind_vismap_equations(m);
    bind_vismap_product(m);
    bind_vlf(m);
    bind_warp(m);
    stop_calls_at_exit();
}
