// Visibility maps for the environment light of frames.
#include "frame_maps.h"
#include "pixel_maps.h"

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

}  // namespace

void bind_vismap_render(py::module_& m) {
    py::class_<VisMapSettings>(m, "VisMapSettings", "See viscache.VisMaps.")
        .def(py::init(&settings_of), py::kw_only(), py::arg("alpha"), py::arg("alpha_value"),
             py::arg("pilot_alpha"), py::arg("sampling"), py::arg("eta"), py::arg("replace"),
             py::arg("points"));
    py::class_<FrameMaps>(m, "FrameMaps", "Visibility maps for the environment light of one frame.");
    m.def(
        "cache_maps",
        [](const VisMapSettings& settings, MapCache& cache, const FrameSettings& frame,
           const FloatArray& d_max, const FloatArray& footprint, bool count_misses, uint32_t cache_frame) {
            FrameMaps made{
                {pixel_maps(cache, frame, d_max, footprint), settings}, {}, py::make_tuple(d_max, footprint)};
            if (count_misses) made.maps.source.records = cache.size();
            made.take_tally = [&cache, cache_frame](const RecordTally& tally) {
                add_tally(cache, tally, cache_frame);
            };
            return made;
        },
        py::arg("settings"), py::arg("cache"), py::arg("frame"), py::arg("d_max"), py::arg("footprint"),
        py::kw_only(), py::arg("count_misses") = false, py::arg("cache_frame") = 0, py::keep_alive<0, 2>(),
        "The maps of a cache, which must not change while the frame is rendered. d_max and footprint belong "
        "to the centres of the pixels, (H·W,).");
}

}  // namespace viscache::bindings
