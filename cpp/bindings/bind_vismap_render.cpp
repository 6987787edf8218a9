// Rendering with visibility maps.
#include <pybind11/stl.h>

#include "bound_maps.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "pixel_maps.h"
#include "viscache/visibility/exact.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/temporal.h"

namespace viscache::bindings {

namespace {

VisMapSettings settings_of(AlphaMode alpha, double alpha_value, bool pilot_alpha, const std::string& sampling,
                           double eta, bool replace, PointSet points) {
    if (!(eta > 0 && eta <= 1)) throw py::value_error("eta must be in (0, 1], got " + std::to_string(eta));
    if (!std::isfinite(alpha_value)) throw py::value_error("alpha must be finite");
    if (alpha == AlphaMode::kLeaveOneOut && points != PointSet::kIndependent)
        throw py::value_error("alpha \"loo\" needs independent points");
    VisMapSettings s{
        .alpha = {alpha, alpha_value}, .pilot_alpha = pilot_alpha, .eta = eta, .replace = replace};
    if (sampling == "product" || eta == 1)
        s.sampling = DensityChoice::kProduct;
    else if (sampling == "guided")
        s.sampling = DensityChoice::kGuided;
    else if (sampling != "auto")
        throw py::value_error("sampling must be product, guided or auto, got " + sampling);
    return s;
}

FrameResult render_maps(const Scene& scene, const RayCaster& caster, const Camera& camera,
                        const IntegratorSettings& integrator, const FrameSettings& frame,
                        const EnvironmentMaps& maps, const py::object& progress) {
    if (!scene.environment())
        throw py::value_error("scene must have an environment light for visibility maps");
    if (integrator.environment != EnvironmentSampling::kProduct || integrator.n_environment < 1)
        throw py::value_error("integrator must sample the environment by its product, n_environment >= 1");
    FrameResult result;
    run_interruptible(
        [&](Control& control) {
            result = render_frame(
                scene, caster, camera, integrator, frame,
                [&] { return std::make_unique<ExactOracle>(caster, scene.offset_extent()); }, control, &maps);
        },
        progress);
    return result;
}

}  // namespace

void bind_vismap_render(py::module_& m) {
    py::class_<VisMapSettings>(m, "VisMapSettings", "See viscache.VisMaps.")
        .def(py::init(&settings_of), py::kw_only(), py::arg("alpha"), py::arg("alpha_value"),
             py::arg("pilot_alpha"), py::arg("sampling"), py::arg("eta"), py::arg("replace"),
             py::arg("points"));
    m.def(
        "render_vismap",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera,
           const IntegratorSettings& integrator, const FrameSettings& frame, const VisMapSettings& settings,
           MapCache& cache, const FloatArray& d_max, const FloatArray& footprint, bool count_misses,
           uint32_t cache_frame, const py::object& progress) {
            EnvironmentMaps maps{pixel_maps(cache, frame, d_max, footprint), settings};
            if (count_misses) maps.source.records = cache.size();
            const FrameResult result = render_maps(scene, caster, camera, integrator, frame, maps, progress);
            if (result.tally) add_tally(cache, *result.tally, cache_frame);
            return frame_dict(result);
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("integrator"), py::arg("frame"),
        py::arg("settings"), py::arg("cache"), py::arg("d_max"), py::arg("footprint"), py::kw_only(),
        py::arg("count_misses") = false, py::arg("cache_frame") = 0, py::arg("progress") = py::none(),
        "A frame whose environment is estimated with a cache, which must not change meanwhile; d_max and "
        "footprint are those of the pixels' centres, (H·W,).");
    m.def(
        "render_given_maps",
        [](const Scene& scene, const RayCaster& caster, const Camera& camera,
           const IntegratorSettings& integrator, const FrameSettings& frame, const VisMapSettings& settings,
           const BoolArray& bits, const FloatArray& beta, const std::vector<BoolArray>& dilated) {
            const BoundMaps given(bits, beta, dilated);
            if (!given.dilated()) throw py::value_error("dilated must be given");
            const EnvironmentMaps maps{
                {given.view.m, [&] { return [&](Vec3, Vec3, size_t) { return given.view; }; }, 0}, settings};
            return frame_dict(render_maps(scene, caster, camera, integrator, frame, maps, py::none()));
        },
        py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("integrator"), py::arg("frame"),
        py::arg("settings"), py::arg("maps"), py::arg("beta"), py::arg("dilated"),
        "The same with one blend of maps for all points, whatever they see (tests).");
}

}  // namespace viscache::bindings
