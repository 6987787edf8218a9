// Eye points and audited pixels of a frame as arrays.
#include "arrays.h"
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
            {
                py::gil_scoped_release release;
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
        [](uint32_t width, uint32_t height, size_t n, uint64_t seed, uint64_t first_sample) {
            const auto drawn = draw_audit_pixels(width, height, n, seed, first_sample);
            py::array_t<uint32_t> out({py::ssize_t(drawn.size()), py::ssize_t(5)});
            auto rows = out.mutable_unchecked<2>();
            for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
                const AuditPixel& p = drawn[size_t(i)];
                const uint32_t values[5] = {p.x, p.y, p.stratum, p.pixels, p.drawn};
                for (py::ssize_t k = 0; k < 5; ++k) rows(i, k) = values[k];
            }
            return out;
        },
        py::arg("width"), py::arg("height"), py::arg("n"), py::arg("seed"), py::arg("first_sample") = 0,
        "Pixels of an audit (n, 5): x, y, stratum, pixels of the stratum, pixels drawn of it.");
}

}  // namespace viscache::bindings
