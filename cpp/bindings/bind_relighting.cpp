// Relighting: images under new environments without new rays.

#include "arrays.h"
#include "interrupt.h"
#include "pixel_maps.h"
#include "real_numbers.h"
#include "viscache/render/relighting.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/environment_pyramid.h"
#include "viscache/vismap/record.h"

namespace viscache::bindings {

namespace {

std::unique_ptr<Relighting> trace(const Scene& scene, const RayCaster& caster, const Camera& camera,
                                  const FrameSettings& frame, const MapCache& cache, const FloatArray& d_max,
                                  const FloatArray& footprint, const py::object& progress) {
    // A camera is input like any other: its fields can be set to anything.
    check_camera(camera);
    WhittedSettings integrator;
    integrator.centred = true;  // J has no noise
    const MapSource maps = pixel_maps(cache, frame, d_max, footprint);
    const EyePathTracer tracer{scene, caster, FilmCamera(camera, frame.width, frame.height), integrator,
                               frame};
    return run_interruptible(
        [&](Control& control) { return std::make_unique<Relighting>(tracer, maps, control); }, progress);
}

py::array_t<double> image(const Relighting& r, const DoubleArray& light, int threads) {
    // One row per channel, cells in Z order
    const size_t cells = map_cells(r.map_level());
    if (light.ndim() != 2 || light.shape(0) != 3 || size_t(light.shape(1)) != cells)
        throw py::value_error("light must have shape (3, " + std::to_string(cells) + "), got " +
                              shape_text(light));
    CellLight given;
    for (size_t c = 0; c < 3; ++c)
        given.channel[c].assign(light.data(py::ssize_t(c), 0), light.data(py::ssize_t(c), 0) + cells);
    py::array_t<double> out({py::ssize_t(r.height()), py::ssize_t(r.width()), py::ssize_t(3)});
    auto* pixels = reinterpret_cast<std::array<double, 3>*>(out.mutable_data());
    // The lights are copied and the picture has its place: the sum needs no lock.
    const WithoutGil release;
    r.image(given, {pixels, size_t(r.width()) * size_t(r.height())}, threads);
    return out;
}

py::array_t<double> cell_light(const EnvironmentMap& map, int m) {
    if (m < kMinMapLog2 || m > kMaxMapLog2)
        throw py::value_error("m must be in [4, 7], got " + std::to_string(m));
    const EnvironmentPyramid pyramid(map);
    const size_t cells = map_cells(m);
    // The sums of the pyramid's level with the map's cells: radiance times solid angle already.
    py::array_t<double> out({py::ssize_t(3), py::ssize_t(cells)});
    for (int c = 0; c < 3; ++c) std::copy_n(pyramid.colour_sums(c, m), cells, out.mutable_data(c, 0));
    return out;
}

}  // namespace

void bind_relighting(py::module_& m) {
    py::module_ v = m.attr("vismap");
    v.def("cell_light", &cell_light, py::arg("map"), py::arg("m"),
          "Radiance × solid angle of the cells of a map, (3, 4^m), in Z order.");
    py::class_<Relighting>(v, "Relighting", "See viscache.Relighting.")
        .def_static(
            "trace", &trace, py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("frame"),
            py::arg("cache"), py::arg("d_max"), py::arg("footprint"), py::arg("progress") = py::none(),
            "Compute all that does not depend on the light. d_max and footprint belong to the centres of "
            "the pixels, (H·W,).")
        .def("image", &image, py::arg("light"), py::arg("threads") = 0,
             "J of every pixel (H, W, 3) under light (3, 4^m).")
        .def(
            "transfer",
            [](const Relighting& r, size_t pixel) {
                const auto cells = r.transfer(pixel);
                py::array_t<double> out({py::ssize_t(cells.size()), py::ssize_t(3)});
                std::memcpy(out.mutable_data(), cells.data(), cells.size() * sizeof cells[0]);
                return out;
            },
            py::arg("pixel"), "The factor of every cell's light in one pixel, (4^m, 3).")
        .def_property_readonly("nbytes", &Relighting::nbytes)
        .def_property_readonly("without_record", &Relighting::without_record)
        .def_property_readonly("camera_rays", [](const Relighting& r) { return r.counters().camera_rays; })
        .def_property_readonly("rays", [](const Relighting& r) { return r.counters().rays(); });
}

}  // namespace viscache::bindings
