// Frames whose eye points share the directions of their ambient occlusion.
#include <pybind11/stl.h>

#include "arrays.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "viscache/render/frame.h"
#include "viscache/visibility/exact.h"
#include "viscache/vlf/aligned_oracle.h"
#include "viscache/vlf/directions.h"

namespace viscache::bindings {

namespace {

const char* name_of(AlignedEngine engine) {
    switch (engine) {
        case AlignedEngine::kBatch: return "batch";
        case AlignedEngine::kEmbree: return "embree";
        case AlignedEngine::kField: return "field";
    }
    return "";
}

py::dict render_aligned(const Scene& scene, const EmbreeCaster& caster, const Camera& camera,
                        const IntegratorSettings& integrator, const FrameSettings& frame,
                        const std::vector<const AlignedBatch*>& batch,
                        const std::vector<const VisibilityField*>& field, const py::object& progress) {
    if (!integrator.ambient || !integrator.ambient_aligned)
        throw py::value_error("the integrator must ask for shared directions");
    if (integrator.n_ambient < 0 || !is_direction_count(uint64_t(integrator.n_ambient)))
        throw py::value_error("n_ambient must be a number of directions, got " +
                              std::to_string(integrator.n_ambient));
    if ((integrator.ambient_engine == AmbientEngine::kField) != (field.size() == 1))
        throw py::value_error("a field must be given if and only if the integrator asks for it");
    FrameResult result;
    const AlignedEngines engines{batch.empty() ? nullptr : batch.front(), caster,
                                 field.empty() ? nullptr : field.front()};
    run_interruptible(
        [&](Control& control) {
            result = render_frame(
                scene, caster, camera, integrator, frame,
                [&] { return std::make_unique<ExactOracle>(caster, scene.offset_extent()); }, control,
                nullptr, &engines);
        },
        progress);
    py::dict d = frame_dict(result), timings = d["timings"], engine;
    timings["aligned_s"] = result.aligned_s;
    const EngineChoice choice = result.aligned.value_or(EngineChoice{});
    engine["name"] = name_of(choice.engine);
    engine["batch_ns"] = choice.batch_ns, engine["embree_ns"] = choice.embree_ns;
    d["engine"] = engine;
    return d;
}

/// The exact frame whose shared directions may go through the batch.
py::dict render_shared(const Scene& scene, const RayCaster& caster, const Camera& camera,
                       const IntegratorSettings& integrator, const FrameSettings& frame,
                       const AlignedBatch& batch, bool choose, std::optional<PacketOrder> order,
                       std::optional<bool> coherent, const py::object& progress) {
    std::optional<Coherence> flag;
    if (coherent) flag = *coherent ? Coherence::kCoherent : Coherence::kIncoherent;
    FrameResult result;
    const auto oracle = [&] {
        const ExactOracle exact(caster, scene.offset_extent(), order, flag);
        return std::make_unique<AlignedOracle>(batch, exact, choose);
    };
    run_interruptible(
        [&](Control& control) {
            result = render_frame(scene, caster, camera, integrator, frame, oracle, control);
        },
        progress);
    const Counters& c = result.counters;
    py::dict d = frame_dict(result), engine;
    const double share = c.predicted_rays ? 1 / double(c.predicted_rays) : 0;
    engine["name"] = c.batch_rays == c.direction_rays ? "batch"
                     : c.batch_rays                   ? "batch and embree"
                                                      : "embree";
    engine["direction_rays"] = c.direction_rays, engine["batch_rays"] = c.batch_rays;
    engine["batch_ns"] = c.batch_ns * share, engine["embree_ns"] = c.embree_ns * share;
    d["engine"] = engine;
    return d;
}

}  // namespace

void bind_render_aligned(py::module_& m) {
    m.def("render_aligned", &render_aligned, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("batch"), py::kw_only(),
          py::arg("field") = py::tuple(), py::arg("progress") = py::none(),
          "Ambient occlusion along shared directions; `batch` and `field` are one or none.");
    m.def("render_shared", &render_shared, py::arg("scene"), py::arg("caster"), py::arg("camera"),
          py::arg("integrator"), py::arg("frame"), py::arg("batch"), py::kw_only(), py::arg("choose"),
          py::arg("order") = py::none(), py::arg("coherent") = py::none(), py::arg("progress") = py::none(),
          "An exact frame whose shared directions go through the batch, or, with `choose`, through the "
          "engine that is cheaper for each tile.");
    m.def(
        "free_share",
        [](uint32_t n_directions, const FloatArray& normals,
           const py::array_t<uint64_t, py::array::c_style | py::array::forcecast>& rows) {
            const DirectionCells cells(directions_of(n_directions));
            const size_t words = words_for(cells.count);
            const std::span<const Vec3> n(rows3(normals, "normals"), size_t(normals.shape(0)));
            if (rows.ndim() != 2 || size_t(rows.shape(0)) != n.size() || size_t(rows.shape(1)) != words)
                throw py::value_error("rows must have shape (" + std::to_string(n.size()) + ", " +
                                      std::to_string(words) + "), got " + shape_text(rows));
            py::array_t<float> out(normals.shape(0));
            for (size_t i = 0; i < n.size(); ++i)
                out.mutable_data()[i] = free_share(cells, n[i], {rows.data() + i * words, words});
            return out;
        },
        py::arg("n_directions"), py::arg("normals"), py::arg("rows"),
        "Cosine-weighted shares of the hemisphere that rows of bits call free, (N,).");
}

}  // namespace viscache::bindings
