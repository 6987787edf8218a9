// The clear sky and its sun.
#include "described.h"
#include "viscache/scene/sky.h"

namespace viscache::bindings {

namespace {

SkySettings settings_from(Float3 to_sun, float turbidity, Float3 albedo) {
    // Users may give any length.
    return {.to_sun = normalize(vec3(to_sun)), .turbidity = turbidity, .albedo = vec3(albedo)};
}

}  // namespace

void bind_sky(py::module_& m) {
    m.def(
        "sky_image",
        [](Float3 to_sun, float turbidity, Float3 albedo, int width) {
            return pixels_of(ClearSky(settings_from(to_sun, turbidity, albedo)).image(width));
        },
        py::arg("to_sun"), py::arg("turbidity"), py::arg("albedo"), py::arg("width"),
        "Lat-long image (width / 2, width, 3) of the clear sky without its sun; y points up.");
    m.def(
        "sky_radiance",
        [](Float3 to_sun, float turbidity, Float3 albedo, const FloatArray& directions) {
            const ClearSky sky(settings_from(to_sun, turbidity, albedo));
            std::vector<Vec3> out;
            // Directions of any length
            for (const Vec3 d : vec3s(directions, "directions")) out.push_back(sky.radiance(normalize(d)));
            return from_vec3s(out);
        },
        py::arg("to_sun"), py::arg("turbidity"), py::arg("albedo"), py::arg("directions"),
        "Radiance of the clear sky from directions (N, 3); y points up.");
    m.def(
        "sun_irradiance",
        [](Float3 to_sun, float turbidity) {
            return array3(ClearSky(settings_from(to_sun, turbidity, {0, 0, 0})).sun_irradiance());
        },
        py::arg("to_sun"), py::arg("turbidity"), "Irradiance of the sun on a surface that faces it.");
    m.def(
        "sun_direction",
        [](int year, int month, int day, double hour, double timezone, double latitude, double longitude) {
            return array3(sun_direction({year, month, day, hour, timezone, latitude, longitude}));
        },
        py::kw_only(), py::arg("year"), py::arg("month"), py::arg("day"), py::arg("hour"),
        py::arg("timezone"), py::arg("latitude"), py::arg("longitude"),
        "Direction to the sun: east, up, north.");
}

}  // namespace viscache::bindings
