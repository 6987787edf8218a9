// Settings of bidirectional path tracing.
#include <pybind11/native_enum.h>
#include <pybind11/pybind11.h>

#include "viscache/render/bdpt_settings.h"

namespace viscache::bindings {

namespace py = pybind11;

void bind_bdpt(py::module_& m) {
    py::native_enum<CameraConnections>(m, "CameraConnections", "enum.Enum",
                                       "Light paths that are connected to the camera.")
        .value("BYPASS", CameraConnections::kBypass)
        .value("KEYED", CameraConnections::kKeyed)
        .value("OFF", CameraConnections::kOff)
        .finalize();
    py::class_<BdptSettings>(m, "BdptSettings")
        .def(py::init<>())
        .def_readwrite("max_depth", &BdptSettings::max_depth)
        .def_readwrite("camera_connections", &BdptSettings::camera_connections)
        .def_readwrite("cosmin", &BdptSettings::cosmin);
}

}  // namespace viscache::bindings
