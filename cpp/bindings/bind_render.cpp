// Settings and cameras of frames.
#include <pybind11/native_enum.h>

#include <tuple>

#include "arrays.h"
#include "checked_rows.h"
#include "real_numbers.h"
#include "viscache/render/settings.h"
#include "viscache/render/vpl.h"
#include "viscache/scene/check.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/exact.h"

namespace viscache::bindings {

namespace {

/// Every field of a camera, in the order of its declaration.
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
    check_camera(camera);
    return camera;
}

}  // namespace

void bind_render(py::module_& m) {
    py::native_enum<PMode>(m, "PMode", "enum.Enum", "Where the density of an eye point comes from.")
        .value("LAST_VERTEX", PMode::kLastVertex)
        .value("FOOTPRINT", PMode::kFootprint)
        .finalize();
    py::native_enum<LightChoice>(m, "LightChoice", "enum.Enum", "How one of several area lights is chosen.")
        .value("CONTRIBUTION", LightChoice::kContribution)
        .value("POWER", LightChoice::kPower)
        .finalize();
    py::native_enum<EnvironmentSampling>(m, "EnvironmentSampling", "enum.Enum",
                                         "How the environment is sampled.")
        .value("MIS", EnvironmentSampling::kMis)
        .value("PRODUCT", EnvironmentSampling::kProduct)
        .value("SHARED", EnvironmentSampling::kShared)
        .finalize();
    py::native_enum<AmbientEngine>(m, "AmbientEngine", "enum.Enum",
                                   "The engine that traces shared directions.")
        .value("AUTO", AmbientEngine::kAuto)
        .value("BATCH", AmbientEngine::kBatch)
        .value("EMBREE", AmbientEngine::kEmbree)
        .value("FIELD", AmbientEngine::kField)
        .finalize();
    py::native_enum<PointSet>(m, "PointSet", "enum.Enum", "Point sets on the unit square.")
        .value("INDEPENDENT", PointSet::kIndependent)
        .value("ZERO_TWO", PointSet::kZeroTwo)
        .finalize();
    py::native_enum<PacketOrder>(m, "PacketOrder", "enum.Enum", "Which exact shadow rays share a packet.")
        .value("BY_LIGHT", PacketOrder::kByLight)
        .value("BY_PIXEL", PacketOrder::kByPixel)
        .finalize();

    py::class_<IntegratorSettings>(m, "IntegratorSettings")
        .def(py::init<>())
        .def_readwrite("direct", &IntegratorSettings::direct)
        .def_readwrite("ambient", &IntegratorSettings::ambient)
        .def_readwrite("n_vpls", &IntegratorSettings::n_vpls)
        .def_readwrite("max_depth", &IntegratorSettings::max_depth)
        .def_readwrite("shade_after_specular", &IntegratorSettings::shade_after_specular)
        .def_readwrite("n_area", &IntegratorSettings::n_area)
        .def_readwrite("light_choice", &IntegratorSettings::light_choice)
        .def_readwrite("n_environment", &IntegratorSettings::n_environment)
        .def_readwrite("n_brdf", &IntegratorSettings::n_brdf)
        .def_readwrite("environment", &IntegratorSettings::environment)
        .def_readwrite("passes", &IntegratorSettings::passes)
        .def_readwrite("points", &IntegratorSettings::points)
        .def_readwrite("centred", &IntegratorSettings::centred)
        .def_readwrite("n_ambient", &IntegratorSettings::n_ambient)
        .def_readwrite("ambient_cosine", &IntegratorSettings::ambient_cosine)
        .def_readwrite("ambient_max_distance", &IntegratorSettings::ambient_max_distance)
        .def_readwrite("ambient_aligned", &IntegratorSettings::ambient_aligned)
        .def_readwrite("ambient_engine", &IntegratorSettings::ambient_engine)
        .def(
            "set_vpls",
            [](IntegratorSettings& s, const FloatArray& positions, const FloatArray& normals,
               const FloatArray& flux) {
                const auto p = usable(positions, "positions"), n = units(normals, "normals"),
                           f = usable(flux, "flux");
                if (n.size() != p.size() || f.size() != p.size())
                    throw py::value_error("positions, normals and flux must have equal numbers of rows");
                auto vpls = std::make_shared<std::vector<Vpl>>();
                for (size_t i = 0; i < p.size(); ++i) vpls->push_back({p[i], n[i], f[i]});
                s.vpls = vpls;
            },
            py::arg("positions"), py::arg("normals"), py::arg("flux"),
            "Set the virtual point lights of the caller.")
        .def_readwrite("vpl_max_depth", &IntegratorSettings::vpl_max_depth)
        .def_readwrite("vpl_candidates", &IntegratorSettings::vpl_candidates)
        .def_readwrite("vpl_eye_points", &IntegratorSettings::vpl_eye_points)
        .def_readwrite("vpl_bound", &IntegratorSettings::vpl_bound)
        .def_readwrite("interleave", &IntegratorSettings::interleave)
        .def_readwrite("pick", &IntegratorSettings::pick)
        .def_readwrite("p_mode", &IntegratorSettings::p_mode)
        .def_readwrite("cosmin", &IntegratorSettings::cosmin);
    py::class_<FrameSettings>(m, "FrameSettings")
        .def(py::init<>())
        .def_readwrite("width", &FrameSettings::width)
        .def_readwrite("height", &FrameSettings::height)
        .def_readwrite("spp", &FrameSettings::spp)
        .def_readwrite("seed", &FrameSettings::seed)
        .def_readwrite("first_sample", &FrameSettings::first_sample)
        .def_readwrite("threads", &FrameSettings::threads)
        .def_readwrite("part", &FrameSettings::part)
        .def_readwrite("parts", &FrameSettings::parts)
        .def_readwrite("audit_pixels", &FrameSettings::audit_pixels)
        .def_readwrite("audit_share", &FrameSettings::audit_share)
        .def_readwrite("audit_above", &FrameSettings::audit_above);
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
