// The Python module viscache._core.
#include <pybind11/pybind11.h>

#include "gil.h"

namespace py = pybind11;

namespace viscache::bindings {
void bind_aqvc(py::module_& m);
void bind_ask(py::module_& m);
void bind_bsp(py::module_& m);
void bind_correlation_pairs(py::module_& m);
void bind_correlation_rows(py::module_& m);
void bind_description(py::module_& m);
void bind_frames(py::module_& m);
void bind_eye_paths(py::module_& m);
void bind_kept_table(py::module_& m);
void bind_light_and_reflection(py::module_& m);
void bind_loaders(py::module_& m);
void bind_math(py::module_& m);
void bind_nee_plus_plus(py::module_& m);
void bind_python_oracle(py::module_& m);
void bind_relighting(py::module_& m);
void bind_render(py::module_& m);
void bind_sampling(py::module_& m);
void bind_scene(py::module_& m);
void bind_scene_info(py::module_& m);
void bind_sky(py::module_& m);
void bind_sources(py::module_& m);
void bind_shafts(py::module_& m);
void bind_taps(py::module_& m);
void bind_vismap_estimate(py::module_& m);
void bind_vismap_cache(py::module_& m);
void bind_vismap_cache_maps(py::module_& m);
void bind_vismap_points(py::module_& m);
void bind_vismap_product(py::module_& m);
void bind_vismap_render(py::module_& m);
void bind_vlf_aligned(py::module_& m);
void bind_vlf_directions(py::module_& m);
void bind_vlf_dynamic(py::module_& m);
void bind_vlf_field(py::module_& m);
void bind_vlf_parts(py::module_& m);
}  // namespace viscache::bindings

PYBIND11_MODULE(_core, m) {
    using namespace viscache::bindings;
    // Types come before what uses them as a base, or as the default value of an argument: pybind11 looks them
    // up when a function is bound.
    m.doc() = "C++ core of viscache. Use the package viscache instead of this module.";
    bind_aqvc(m);
    bind_correlation_pairs(m);
    bind_description(m);
    bind_light_and_reflection(m);
    bind_loaders(m);
    bind_math(m);
    bind_sampling(m);
    bind_sky(m);
    bind_scene(m);
    bind_scene_info(m);
    bind_bsp(m);
    bind_render(m);
    bind_kept_table(m);
    bind_nee_plus_plus(m);
    bind_eye_paths(m);
    bind_vismap_product(m);
    bind_vismap_estimate(m);
    bind_vismap_cache_maps(m);
    bind_vismap_points(m);
    bind_vismap_cache(m);
    bind_relighting(m);
    bind_vismap_render(m);
    bind_vlf_directions(m);
    bind_vlf_field(m);
    bind_vlf_aligned(m);
    bind_vlf_dynamic(m);
    bind_vlf_parts(m);
    bind_sources(m);
    bind_shafts(m);
    bind_correlation_rows(m);
    bind_frames(m);
    bind_ask(m);
    bind_taps(m);
    bind_python_oracle(m);
    // Last: the hook is of no use if binding fails.
    stop_calls_at_exit();
}
