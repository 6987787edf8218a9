// Eye points and audited pixels of a frame as arrays.
#include "arrays.h"
#include "gil.h"
#include "viscache/render/audit_pixels.h"
#include "viscache/render/eye_paths.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache::bindings {

void bind_eye_paths(py::module_& m) {
    m.def(
        "trace_eye_points",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera,
           const IntegratorSettings& integrator, const FrameSettings& frame) {
            check_camera(camera);
            EyeTile eyes;
            // The lock is free while the rays are traced; arrays are made with it.
            {
                // One tile as large as the picture
                const WithoutGil release;
                const EyePathTracer tracer{scene, caster, FilmCamera(camera, frame.width, frame.height),
                                           integrator, frame};
                Counters counters;
                tracer.trace({0, 0, frame.width, frame.height}, eyes, counters, Control{});
            }
            const EyeBlock& block = eyes.block;
            using namespace py::literals;
            return py::dict(
                "position"_a = from_vec3s(block.position), "normal"_a = from_vec3s(block.normal),
                "origin"_a = from_vec3s(block.origin), "throughput"_a = from_vec3s(eyes.throughput),
                "density"_a = py::array_t<float>(py::ssize_t(block.density.size()), block.density.data()),
                "pixel"_a = py::array_t<uint32_t>(py::ssize_t(eyes.pixel.size()), eyes.pixel.data()));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("integrator"), py::arg("frame"),
        "Eye points of a whole frame: position, normal, origin, throughput (N, 3), density and pixel (N,).");
    m.def(
        "draw_audit_pixels",
        [](const FloatArray& light, size_t n, uint64_t seed, uint64_t first_sample) {
            if (light.ndim() != 2) throw py::value_error("light must have shape (H, W)");
            const Tile all{0, 0, int(light.shape(1)), int(light.shape(0))};
            // The order in which audits draw: along a curve, so that strata are compact.
            const auto pixels = along_curve({&all, 1});
            const auto drawn = draw_audit_pixels(pixels, {light.data(), size_t(light.size())},
                                                 size_t(light.shape(1)), n, seed, first_sample);
            py::array_t<double> out({py::ssize_t(drawn.size()), py::ssize_t(3)});
            auto rows = out.mutable_unchecked<2>();
            for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
                const AuditPixel& p = drawn[size_t(i)];
                const double row[3] = {double(p.x), double(p.y), p.weight};
                for (py::ssize_t k = 0; k < 3; ++k) rows(i, k) = row[k];
            }
            return out;
        },
        py::arg("light"), py::arg("n"), py::arg("seed"), py::arg("first_sample") = 0,
        "Pixels of an audit (n, 3): x, y, weight; two of each stratum, one after the other. `light` (H, W): "
        "light without shadows.");
}

}  // namespace viscache::bindings
