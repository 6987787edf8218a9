// Eye points of a frame as arrays.
#include "arrays.h"
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
}

}  // namespace viscache::bindings
