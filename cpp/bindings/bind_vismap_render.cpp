// Visibility maps for the environment light of frames.
#include "bind_rows.h"
#include "frame_maps.h"
#include "pixel_maps.h"

namespace viscache::bindings {

/// α: one of the ways to choose it, or a number.
template <>
struct PythonValue<AlphaChoice> {
    // The first word that fits a value is the one that is shown: "one" is the number 1.
    static constexpr std::array<std::pair<const char*, AlphaChoice>, 4> kWords{
        {{"previous_pass", {AlphaMode::kPreviousPass, 1}},
         {"loo", {AlphaMode::kLeaveOneOut, 1}},
         {"one", {AlphaMode::kFixed, 1}},
         {"zero", {AlphaMode::kFixed, 0}}}};

    static py::object read(const Range&, const AlphaChoice& alpha) {
        for (const auto& [word, choice] : kWords)
            if (choice.mode == alpha.mode && choice.value == alpha.value) return py::str(word);
        return py::float_(alpha.value);
    }
    static AlphaChoice write(const char* parameter, const Range&, const py::object& given) {
        if (py::isinstance<py::str>(given)) {
            for (const auto& [word, choice] : kWords)
                if (given.equal(py::str(word))) return choice;
        } else if (!py::isinstance<py::bool_>(given) && PyNumber_Check(given.ptr())) {
            // True is the number 1 in Python, and no α.
            const double value = py::float_(given);
            if (std::isfinite(value)) return {AlphaMode::kFixed, value};
        }
        throw py::value_error(std::string(parameter) + " must be one of " + words() + " or a finite number" +
                              got(given));
    }
    static std::string kind(const Range&) { return "{" + words() + "} or float"; }

private:
    static std::string words() {
        std::string all;
        for (const auto& [word, choice] : kWords)
            all += (all.empty() ? "\"" : ", \"") + std::string(word) + "\"";
        return all;
    }
};

void bind_vismap_render(py::module_& m) {
    py::class_<VisMapSettings> settings(m, "VisMapSettings", "See viscache.VisMaps.");
    bind_rows(settings, kVisMapRows);
    py::class_<FrameMaps>(m, "FrameMaps", "Visibility maps for the environment light of one frame.");
    m.def(
        "cache_maps",
        [](VisMapSettings settings, MapCache& cache, const FrameSettings& frame, const FloatArray& d_max,
           const FloatArray& footprint, bool replace, bool count_misses, uint32_t cache_frame) {
            settings.replace = replace;
            // The reader refers to both arrays, so they travel with it.
            FrameMaps made{
                {pixel_maps(cache, frame, d_max, footprint), settings}, {}, py::make_tuple(d_max, footprint)};
            // 0 records: errors are not counted
            if (count_misses) made.maps.source.records = cache.size();
            // Called when the frame is whole, with the lock.
            made.take_tally = [&cache, cache_frame](const RecordTally& tally) {
                add_tally(cache, tally, cache_frame);
            };
            return made;
        },
        py::arg("settings"), py::arg("cache"), py::arg("frame"), py::arg("d_max"), py::arg("footprint"),
        py::kw_only(), py::arg("replace") = false, py::arg("count_misses") = false,
        py::arg("cache_frame") = 0, py::keep_alive<0, 2>(),
        "The maps of a cache, which must not change while the frame is rendered. d_max and footprint belong "
        "to the centres of the pixels, (H·W,).");
}

}  // namespace viscache::bindings
