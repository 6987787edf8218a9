// Settings of shadow maps.
#include <pybind11/pybind11.h>

#include "viscache/visibility/shadow_map.h"

namespace py = pybind11;

namespace viscache::bindings {

void bind_shadow_map(py::module_& m) {
    py::class_<ShadowMapSettings>(m, "ShadowMapSettings", "See viscache.ShadowMap.")
        .def(py::init<>())
        .def_readwrite("resolution", &ShadowMapSettings::resolution)
        .def_readwrite("bias", &ShadowMapSettings::bias)
        .def_readwrite("slope_bias", &ShadowMapSettings::slope_bias)
        .def_readwrite("vpls", &ShadowMapSettings::vpls)
        .def_readwrite("max_bytes", &ShadowMapSettings::max_bytes)
        .def("validate", &ShadowMapSettings::validate);
}

}  // namespace viscache::bindings
