// Settings and cameras of frames.
#include <pybind11/native_enum.h>

#include <tuple>

#include "arrays.h"
#include "bind_rows.h"
#include "checked_rows.h"
#include "real_numbers.h"
#include "viscache/oracles/exact.h"
#include "viscache/render/settings.h"
#include "viscache/render/vpl.h"
#include "viscache/scene/check.h"
#include "viscache/scene/scene.h"

namespace viscache::bindings {

namespace {

/// Every field of a camera, in the order of its declaration.
// Pickles hold this tuple: the two functions below must list the same fields.
using CameraState = std::tuple<std::string, std::array<float, 3>, std::array<float, 3>, std::array<float, 3>,
                               std::array<float, 3>, float, int, int, bool, float, float, float>;

CameraState camera_state(const Camera& c) {
    return {c.name,  array3(c.origin), array3(c.right),     array3(c.up),  array3(c.forward), c.fov_y_rad,
            c.width, c.height,         c.fov_is_horizontal, c.view_height, c.shift_x,         c.shift_y};
}

Camera camera_of(const CameraState& state) {
    const auto& [name, origin, right, up, forward, fov, width, height, horizontal, view_height, shift_x,
                 shift_y] = state;
    const Camera camera{name,  vec3(origin), vec3(right), vec3(up),    vec3(forward), fov,
                        width, height,       horizontal,  view_height, shift_x,       shift_y};
    // A pickle may come from anywhere.
    check_camera(camera);
    return camera;
}

}  // namespace

/// Lights of the caller's own: an object with positions, normals and flux, see viscache.Vpls.
template <>
struct PythonValue<std::shared_ptr<const std::vector<Vpl>>> {
    using Values = std::shared_ptr<const std::vector<Vpl>>;

    static py::object read(const Range&, const Values& vpls) {
        // The lights themselves stay in the object that was given.
        return vpls ? py::object(py::int_(vpls->size())) : py::none();
    }
    static Values write(const char*, const Range&, const py::object& given) {
        if (given.is_none()) return nullptr;
        const auto array = [&](const char* name) { return given.attr(name).cast<FloatArray>(); };
        const FloatArray positions = array("positions"), normals = array("normals"), flux = array("flux");
        // Checked as all arrays of positions and normals are
        const auto p = usable(positions, "positions"), n = units(normals, "normals"),
                   f = usable(flux, "flux");
        if (n.size() != p.size() || f.size() != p.size())
            throw py::value_error("positions, normals and flux must have equal numbers of rows");
        std::vector<Vpl> vpls;
        for (size_t i = 0; i < p.size(); ++i) vpls.push_back({p[i], n[i], f[i]});
        return std::make_shared<const std::vector<Vpl>>(std::move(vpls));
    }
    static std::string kind(const Range&) { return "Vpls, optional"; }
};

/// A number > 0, "auto", or None for no limit.
template <>
struct PythonValue<Reach> {
    static constexpr Range kRange{.low = 0, .above = true};

    static py::object read(const Range&, Reach reach) {
        if (reach.distance == Reach::kAuto) return py::str("auto");
        return reach.distance > 0 ? py::object(py::float_(reach.distance)) : py::none();
    }
    static Reach write(const char* parameter, const Range&, const py::object& given) {
        // 0 stands for no limit, and a Reach without a distance for "auto".
        if (given.is_none()) return {0};
        if (py::isinstance<py::str>(given) && std::string(py::str(given)) == "auto") return {};
        const bool number = py::isinstance<py::float_>(given) || py::isinstance<py::int_>(given);
        if (!number || !kRange.holds(given.cast<double>()))
            throw py::value_error(std::string(parameter) + " must be > 0, \"auto\", or None for no limit" +
                                  got(given));
        return {given.cast<double>()};
    }
    static std::string kind(const Range&) { return "float > 0, \"auto\" or None"; }
};

void bind_render(py::module_& m) {
    py::native_enum<PointSet>(m, "PointSet", "enum.Enum", "Point sets on the unit square.")
        .value("INDEPENDENT", PointSet::kIndependent)
        .value("ZERO_TWO", PointSet::kZeroTwo)
        .finalize();
    py::native_enum<PacketOrder>(m, "PacketOrder", "enum.Enum", "Which exact shadow rays share a packet.")
        .value("BY_LIGHT", PacketOrder::kByLight)
        .value("BY_PIXEL", PacketOrder::kByPixel)
        .finalize();

    py::class_<IntegratorSettings>(m, "IntegratorSettings", "Of integrators that shade eye points.");
    py::class_<DirectSettings, IntegratorSettings> direct(m, "DirectSettings", "See viscache.Direct.");
    bind_rows(direct, kDirectRows);
    py::class_<WhittedSettings, IntegratorSettings> whitted(m, "WhittedSettings", "See viscache.Whitted.");
    bind_rows(whitted, kWhittedRows);
    py::class_<AmbientSettings, IntegratorSettings> ambient(m, "AmbientSettings",
                                                            "See viscache.AmbientOcclusion.");
    bind_rows(ambient, kAmbientRows);
    py::class_<BdptSettings> bdpt(m, "BdptSettings", "See viscache.Bdpt.");
    bind_rows(bdpt, kBdptRows);
    py::class_<FrameSettings> frame(m, "FrameSettings", "Size, samples, seed and threads of a frame.");
    bind_rows(frame, kFrameRows);
    py::class_<Camera>(m, "Camera",
                       "A camera; made by `viscache.look_at`, `viscache.orthographic` or a scene file.")
        .def_readwrite("name", &Camera::name, "Its name in the scene file.")
        .def_readwrite("fov_rad", &Camera::fov_y_rad, "Full angle of view in radians.")
        .def_readwrite("fov_is_horizontal", &Camera::fov_is_horizontal,
                       "Whether `fov_rad` is the horizontal angle.")
        .def_readwrite("view_height", &Camera::view_height,
                       "Orthographic cameras: height of the picture in scene units, or its width where "
                       "`fov_is_horizontal`. 0: a pinhole.")
        .def_readwrite("shift_x", &Camera::shift_x,
                       "How far the picture's centre lies right of the axis, in widths of the picture.")
        .def_readwrite("shift_y", &Camera::shift_y,
                       "How far the picture's centre lies above the axis, in heights of the picture.")
        .def_readwrite("width", &Camera::width, "Pixels.")
        .def_readwrite("height", &Camera::height, "Pixels.")
        .def_property_readonly(
            "origin", [](const Camera& c) { return array3(c.origin); }, "Position in scene units.")
        .def_property_readonly(
            "forward", [](const Camera& c) { return array3(c.forward); }, "Viewing direction, a unit vector.")
        .def_property_readonly(
            "right", [](const Camera& c) { return array3(c.right); },
            "Unit vector to the right in the picture.")
        .def_property_readonly(
            "up", [](const Camera& c) { return array3(c.up); }, "Unit vector upwards in the picture.")
        .def(py::pickle(&camera_state, &camera_of));
    m.def("scene_cameras", [](const Scene& s) { return s.description().cameras; }, py::arg("scene"));
    m.def(
        "look_at",
        [](std::array<float, 3> origin, std::array<float, 3> target, std::array<float, 3> up, float fov_deg) {
            const Camera camera = look_at(vec3(origin), vec3(target), vec3(up), fov_deg * kPi / 180);
            check_camera(camera);
            return camera;
        },
        py::arg("origin"), py::arg("target"), py::arg("up"), py::arg("fov_deg"),
        "Pinhole camera at `origin` looking at `target`; `fov_deg` is the vertical angle of view.");
}

}  // namespace viscache::bindings
