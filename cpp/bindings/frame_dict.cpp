// A finished frame as Python objects.
#include "frame_dict.h"
#include "real_numbers.h"

#include "arrays.h"

namespace viscache::bindings {

namespace {

/// Layers of one or three channels
template <class T>
py::array_t<float> image_of(const FrameResult& f, const std::vector<T>& values) {
    const py::ssize_t channels = py::ssize_t(sizeof(T) / sizeof(float));
    py::array_t<float> a({py::ssize_t(f.height), py::ssize_t(f.width), channels});
    std::memcpy(a.mutable_data(), values.data(), values.size() * sizeof(T));
    return a;
}

/// What an audit found, by light group: errors of its pixels (n, 3), and the sums of each tile's queries.
py::dict audit_dict(const FrameResult& f) {
    std::vector<double> weight;
    for (const AuditedPixel& pixel : f.audited_pixels) weight.push_back(pixel.weight);
    uint64_t rays = f.audit_rays;
    for (const AuditRecords& tile : f.audited_queries) rays += tile.rays;
    py::dict errors, queries;
    // Only groups that the frame has
    for (size_t g = 0; g < kLightGroups; ++g) {
        if (f.groups[g].empty()) continue;
        std::vector<Rgb> error;
        py::list sums;
        for (const AuditedPixel& pixel : f.audited_pixels) error.push_back(pixel.error[g]);
        for (const AuditRecords& tile : f.audited_queries) {
            const AuditedQueries& q = tile.queries[g];
            sums.append(py::make_tuple(q.exact, q.queries, q.certain, q.certain_wrong, q.sampled,
                                       q.sampled_wrong, q.certain_error, q.sampled_error, q.sampled_square,
                                       q.sampled_fourth));
        }
        errors[kLightGroupNames[g]] = from_vec3s(error);
        queries[kLightGroupNames[g]] = sums;
    }
    return py::dict(py::arg("rays") = rays,
                    py::arg("weight") = py::array_t<double>(py::ssize_t(weight.size()), weight.data()),
                    py::arg("errors") = errors, py::arg("queries") = queries);
}

/// Per light group with corrections by class: a dict per class, in the order of their numbers.
py::dict classes_of(const FrameResult& f) {
    py::dict of_groups;
    for (int g = 0; g < kLightGroups; ++g) {
        uint64_t queries = 0;
        // Class k: doubted or agreed, visible or blocked, and whether a neighbouring answer differs
        py::dict of_classes;
        for (size_t k = 0; k < kAnswerClasses; ++k) {
            const ClassCounters& c = f.counters.classes[size_t(g)][k];
            queries += c.queries;
            const std::string name = std::string(k & 4 ? "doubted " : "agreed ") +
                                     (k & 2 ? "visible" : "blocked") + (k & 1 ? ", neighbour differs" : "");
            of_classes[name.c_str()] =
                py::dict(py::arg("queries") = c.queries, py::arg("corrections") = c.checked,
                         py::arg("wrong") = c.wrong);
        }
        // Groups without queries by class were not corrected by class.
        if (queries) of_groups[kLightGroupNames[g]] = of_classes;
    }
    return of_groups;
}

py::dict counters_of(const FrameResult& f) {
    const Counters& c = f.counters;
    py::dict groups;
    for (int g = 0; g < kLightGroups; ++g)
        if (!f.groups[g].empty())
            groups[kLightGroupNames[g]] =
                py::dict(py::arg("queries") = c.groups[g].queries, py::arg("occluded") = c.groups[g].occluded,
                         py::arg("rays") = c.groups[g].rays);
    std::vector<uint64_t> levels(c.rays_per_level.begin(), c.rays_per_level.end());
    // Levels past the last one with rays did not exist.
    while (!levels.empty() && levels.back() == 0) levels.pop_back();
    py::dict d(py::arg("queries") = c.queries(), py::arg("occluded") = c.occluded(),
               py::arg("rays") = c.rays());
    // 0 says that there were no rays.
    d["ray_reduction"] = c.rays() ? double(c.queries()) / double(c.rays()) : 0.0;
    d["groups"] = groups;
    d["rays_per_level"] = levels;
    // A mean per sample, as users see pictures
    d["lost_throughput"] = c.lost_throughput / (double(f.width) * f.height * f.spp);
    for_each_counter([&]<class Value>(const CounterRow<Value>& row) {
        // Rows say when they are of interest: always, with product samples, or with a table of the frame.
        const bool shown = row.shown == Shown::kAlways ||
                           (row.shown == Shown::kProduct && c.product_points) ||
                           (row.shown == Shown::kFrameTable && c.table_occupied);
        if constexpr (std::is_arithmetic_v<Value>)
            if (shown) d[row.name] = c.*row.member;
    });
    if (c.table_occupied)
        d["occupancy"] = c.table_slots ? double(c.table_occupied) / double(c.table_slots) : 0.0;
    d["vpls"] = f.n_vpls;
    if (const py::dict classes = classes_of(f); !classes.empty()) d["share_by_class"] = classes;
    // What the pilot of a frame with maps has found
    if (f.forecast) {
        d["pilot_alpha"] = f.forecast->alpha;
        d["pilot_variance_ratio"] = f.forecast->variance_ratio;
        d["pilot_guided"] = f.forecast->guided;
    }
    return d;
}

const char* name_of(AlignedEngine engine) {
    switch (engine) {
        case AlignedEngine::kBatch: return "batch";
        case AlignedEngine::kEmbree: return "embree";
        case AlignedEngine::kField: return "field";
    }
    return "";
}

/// The engine that traced shared directions. Empty if there was no choice.
py::dict engine_of(const FrameResult& f) {
    py::dict d;
    // The source's own account of its engine comes first.
    for (const auto& [name, value] : f.source.engine)
        d[name.c_str()] = std::visit([](const auto& v) -> py::object { return py::cast(v); }, value);
    if (f.aligned) {
        d["name"] = name_of(f.aligned->engine);
        d["batch_ns"] = f.aligned->batch_ns;
        d["embree_ns"] = f.aligned->embree_ns;
    }
    return d;
}

}  // namespace

py::dict account_dict(const FrameResult& f) {
    py::dict timings, out, counters = counters_of(f);
    for (const auto& [name, value] : f.source.counters) counters[name.c_str()] = value;
    for (const auto& [name, value] : f.source.timings) timings[name.c_str()] = value;
    const py::dict engine = engine_of(f);
    if (!engine.empty()) out["engine"] = engine;
    out["counters"] = counters;
    out["timings"] = timings;
    return out;
}

py::dict frame_dict(const FrameResult& f) {
    // Timings of the frame join those of the source.
    py::dict layers, out = account_dict(f), timings = out["timings"];
    layers["color"] = image_of(f, f.color);
    layers["emitted"] = image_of(f, f.emitted);
    // Layers that only some frames have
    if (!f.seen_emitters.empty()) layers["seen_emitters"] = image_of(f, f.seen_emitters);
    for (int g = 0; g < kLightGroups; ++g)
        if (!f.groups[g].empty()) layers[kLightGroupNames[g]] = image_of(f, f.groups[g]);
    if (!f.variance.empty()) layers["variance"] = image_of(f, f.variance);
    if (!f.last_pass.empty()) layers["environment_last_pass"] = image_of(f, f.last_pass);
    layers["depth"] = image_of(f, f.depth);
    layers["normal"] = image_of(f, f.normal);
    layers["albedo"] = image_of(f, f.albedo);
    layers["coverage"] = image_of(f, f.coverage);
    timings["lights_s"] = f.lights_s;
    timings["tiles_s"] = f.tiles_s;
    timings["eye_paths_cpu_s"] = f.stages.eye_paths;
    timings["contributions_cpu_s"] = f.stages.contributions;
    timings["visibility_cpu_s"] = f.stages.visibility;
    timings["shading_cpu_s"] = f.stages.shading;
    if (f.counters.product_points) {
        timings["trees_cpu_s"] = f.product.trees;
        timings["maps_cpu_s"] = f.product.maps;
        timings["samples_cpu_s"] = f.product.samples;
        timings["pilot_s"] = f.pilot_s;
    }
    if (f.aligned) timings["aligned_s"] = f.aligned_s;
    out["layers"] = layers;
    // Only audited frames have the entry at all.
    if (!f.audited_pixels.empty() || !f.audited_queries.empty()) {
        out["audit"] = audit_dict(f);
        timings["audit_cpu_s"] = f.stages.audit;
    }
    // Parts of a frame: sums per tile, which must be added in the order of the tiles.
    if (!f.tile_sums.empty()) {
        py::list sums;
        for (const TileSums& tile : f.tile_sums)
            sums.append(py::dict(py::arg("lost_throughput") = tile.lost_throughput,
                                 py::arg("expected_false_hits") = tile.expected_false_hits));
        out["tile_sums"] = sums;
    }
    out["threads"] = f.threads;
    out["tile_edge_px"] = f.tile_edge_px;
    return out;
}

}  // namespace viscache::bindings
