// The visibility-map cache: insertion, look-up, temporal removal, ambient occlusion.

#include "bind_rows.h"
#include "cache_points.h"
#include "interrupt.h"
#include "real_numbers.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vismap/ambient.h"
#include "viscache/vismap/insertion.h"
#include "viscache/vismap/temporal.h"

namespace viscache::bindings {

namespace {

using ByteArray = py::array_t<uint8_t, py::array::c_style | py::array::forcecast>;

py::dict insert(MapCache& cache, const Scene& scene, const RayCaster& caster, const Points& points,
                uint32_t frame, int threads, const py::object& progress) {
    // Only ambient occlusion traces distances: they cost nearest hits instead of any hits.
    const RecordTracer tracer(caster, scene.offset_extent(), cache.pattern(),
                              cache.parameters().criterion == Criterion::kAmbient);
    InsertionStats s = run_interruptible(
        [&](Control& control) { return insert_where_needed(cache, tracer, points, frame, threads, control); },
        progress);
    return py::dict(py::arg("points") = s.points, py::arg("unusable") = s.unusable,
                    py::arg("passes") = s.passes, py::arg("lookups") = s.lookups,
                    py::arg("inserted") = s.inserted(), py::arg("no_candidate") = s.no_candidate,
                    py::arg("weight") = s.weight, py::arg("difference") = s.difference,
                    py::arg("suppressed") = s.suppressed, py::arg("duplicates") = s.duplicates,
                    py::arg("refused") = s.refused, py::arg("rays") = s.rays);
}

py::dict bootstrap_cache(MapCache& cache, const Scene& scene, const RayCaster& caster, const Points& points,
                         uint32_t frame, int threads) {
    const RecordTracer tracer(caster, scene.offset_extent(), cache.pattern(),
                              cache.parameters().criterion == Criterion::kAmbient);
    BootstrapStatistics s = run_interruptible(
        [&](Control& control) { return bootstrap(cache, tracer, points, frame, threads, control); });
    py::dict d;
    d["difference"] = column<float>(s.difference.size(), [&](size_t i) { return s.difference[i]; });
    d["tested"] = column<float>(s.tested.size(), [&](size_t i) { return s.tested[i]; });
    d["unusable"] = s.unusable;
    d["duplicates"] = s.duplicates;
    d["rays"] = s.rays;
    return d;
}

py::dict select_points(const MapCache& cache, const Points& points, int threads) {
    // Arrays are made with the interpreter's lock; threads then write rows of their own
    const auto n = py::ssize_t(points.size()), best = py::ssize_t(cache.parameters().n_best);
    py::array_t<int64_t> ids({n, best});
    py::array_t<float> beta({n, best}), tested(n), nearest(n), difference(n);
    py::array_t<uint8_t> verdict(n);
    py::array_t<int32_t> candidates(n);
    int64_t* id = ids.mutable_data();
    float *share = beta.mutable_data(), *t = tested.mutable_data(), *near = nearest.mutable_data(),
          *delta = difference.mutable_data();
    uint8_t* v = verdict.mutable_data();
    int32_t* c = candidates.mutable_data();
    // The pointers above were taken with the lock.
    run_interruptible([&](Control& control) {
        // Places without a record
        std::fill_n(id, n * best, -1);
        std::fill_n(share, n * best, 0.f);
        parallel_for((points.size() + 63) / 64, threads, [&](size_t chunk, int) {
            control.check();
            // Neighbours within a chunk share their list.
            NeighbourList around;
            for (size_t i = chunk * 64; i < std::min(points.size(), chunk * 64 + 64); ++i) {
                const Selection s = points[i].usable() ? cache.select(points[i], around) : Selection{};
                const BlendedMaps maps = cache.blend(s);
                for (int k = 0; k < maps.count; ++k) {
                    id[i * size_t(best) + size_t(k)] = s.best[size_t(k)].id;
                    share[i * size_t(best) + size_t(k)] = maps.beta[k];
                }
                t[i] = s.tested;
                near[i] = s.nearest;
                c[i] = s.candidates;
                // What the insertion would decide, for figures of its test
                delta[i] = cache.mean_difference(s);
                v[i] = points[i].usable() ? uint8_t(cache.judge(points[i], s)) : uint8_t(Verdict::kServed);
            }
        });
    });
    return py::dict(py::arg("ids") = ids, py::arg("beta") = beta, py::arg("tested") = tested,
                    py::arg("nearest") = nearest, py::arg("candidates") = candidates,
                    py::arg("difference") = difference, py::arg("verdict") = verdict);
}

py::dict records_dict(const MapCache& cache) {
    const RecordPool& r = cache.records();
    // Copies: records may move when others are removed.
    const size_t n = r.size(), words = map_words(r.m());
    py::array_t<Word> bits({n, words});
    for (uint32_t i = 0; i < n; ++i) std::memcpy(bits.mutable_data(i, 0), r.bits(i), words * sizeof(Word));
    const auto head = [&](size_t i) -> const RecordHead& { return r.head(uint32_t(i)); };
    py::dict d;
    d["positions"] = vectors(n, [&](size_t i) { return head(i).position; });
    d["normals"] = vectors(n, [&](size_t i) { return head(i).normal; });
    d["bits"] = bits;
    d["rays"] = column<uint32_t>(n, [&](size_t i) { return head(i).rays; });
    d["misses"] = column<uint32_t>(n, [&](size_t i) { return head(i).misses; });
    d["last_used"] = column<uint32_t>(n, [&](size_t i) { return head(i).last_used; });
    d["ambient"] = column<float>(n, [&](size_t i) { return r.ambient(uint32_t(i)).visibility; });
    d["nearest_hit"] = column<float>(n, [&](size_t i) { return r.ambient(uint32_t(i)).nearest_hit; });
    return d;
}

void add_records(MapCache& cache, const FloatArray& positions, const FloatArray& normals,
                 const WordArray& bits, const UintArray& rays, const UintArray& misses,
                 const UintArray& last_used, const FloatArray& ambient, const FloatArray& nearest_hit) {
    const Vec3 *p = rows3(positions, "positions"), *n = rows3(normals, "normals");
    require_rows(bits, py::ssize_t(map_words(cache.parameters().m)), "bits");
    const py::ssize_t count = positions.shape(0);
    const std::pair<const char*, const py::array*> columns[] = {
        {"rays", &rays},       {"misses", &misses},           {"last_used", &last_used},
        {"ambient", &ambient}, {"nearest_hit", &nearest_hit}, {"normals", &normals},
        {"bits", &bits}};
    // Sizes, values and room are checked before the first record is added: all of them, or none.
    for (const auto& [name, a] : columns)
        if (a->ndim() < 1 || a->shape(0) != count)
            throw py::value_error(std::string(name) + " must have one row per position, " +
                                  std::to_string(count) + ", got " + shape_text(*a));
    // The same check as for query points, with numbers that pass for what records lack
    for (py::ssize_t i = 0; i < count; ++i) check_point({p[i], n[i], 1, 0}, size_t(i));
    if (cache.size() + size_t(count) > cache.parameters().max_records)
        throw py::value_error("the cache must hold at most max_records records, " +
                              std::to_string(cache.parameters().max_records) + ", got " +
                              std::to_string(cache.size() + size_t(count)));
    for (py::ssize_t i = 0; i < count; ++i)
        cache.add({p[i], n[i], rays.at(i), misses.at(i), last_used.at(i)}, bits.data(i, 0),
                  {ambient.at(i), nearest_hit.at(i)});
}

void tally(MapCache& cache, const UintArray& rays, const UintArray& misses, const ByteArray& used,
           uint32_t frame) {
    RecordTally t(cache.size());
    for (const auto& [name, a] :
         {std::pair<const char*, const py::array*>{"rays", &rays}, {"misses", &misses}, {"used", &used}})
        if (a->ndim() != 1 || size_t(a->shape(0)) != cache.size())
            throw py::value_error(std::string(name) + " must have one entry per record, " +
                                  std::to_string(cache.size()) + ", got " + shape_text(*a));
    for (size_t i = 0; i < cache.size(); ++i) {
        const auto k = py::ssize_t(i);
        // A rate above 1 would remove a record that is right
        if (misses.at(k) > rays.at(k))
            throw py::value_error("misses must be at most rays, row " + std::to_string(i) + " has " +
                                  std::to_string(misses.at(k)) + " of " + std::to_string(rays.at(k)));
        // Counts of whole rays; frames count in parts of one.
        t.rays[i] = rays.at(k) * RecordTally::kRay;
        t.misses[i] = misses.at(k) * RecordTally::kRay;
        t.used[i] = used.at(k) != 0;
    }
    add_tally(cache, t, frame);
}

py::dict remove(MapCache& cache, uint32_t frame) {
    const RemovalStats s = remove_records(cache, frame);
    return py::dict(py::arg("wrong") = s.wrong, py::arg("unused") = s.unused, py::arg("rays") = s.rays,
                    py::arg("misses") = s.misses);
}

py::tuple shade_points(const MapCache& cache, const Points& points, float width, bool weighted, int threads) {
    if (!(width > 0 && width <= 1e6f))
        throw py::value_error("width must be in (0, 1e6], got " + std::to_string(width));
    const auto n = py::ssize_t(points.size());
    py::array_t<float> visibility(n), jump(n);
    py::array_t<int32_t> records(n);
    float *a = visibility.mutable_data(), *j = jump.mutable_data();
    int32_t* r = records.mutable_data();
    run_interruptible([&](Control& control) {
        parallel_for((points.size() + 255) / 256, threads, [&](size_t chunk, int) {
            control.check();
            // Neighbours within a chunk share their list.
            NeighbourList around;
            for (size_t i = chunk * 256; i < std::min(points.size(), chunk * 256 + 256); ++i) {
                AmbientShade s;
                if (points[i].usable()) s = shade_ambient(cache, points[i], {width, weighted}, around);
                a[i] = s.visibility;
                j[i] = s.jump;
                r[i] = s.records;
            }
        });
    });
    return py::make_tuple(visibility, records, jump);
}

}  // namespace

void bind_vismap_cache(py::module_& m) {
    py::module_ v = m.def_submodule("vismap", "The visibility-map cache (VisMap).");
    py::class_<MapCacheParameters> parameters(v, "MapCacheParameters",
                                              "Parameters of the cache; see viscache.MapSettings.");
    bind_rows(parameters, kMapRows);
    py::class_<MapCache>(v, "MapCache", "Records and their tree; see viscache.VisibilityMapCache.")
        .def(py::init<const MapCacheParameters&>(), py::arg("parameters"))
        .def("__len__", &MapCache::size)
        .def_property_readonly(
            // A copy: the cache may go before the array.
            "pattern", [](const MapCache& c) { return from_vec3s({c.pattern().begin(), c.pattern().end()}); })
        .def_property_readonly("rebuilds", [](const MapCache& c) { return c.tree().rebuilds(); })
        .def_property_readonly("depth", [](const MapCache& c) { return c.tree().depth(); })
        .def_property_readonly("oversized_leaves",
                               [](const MapCache& c) { return c.tree().oversized_leaves(); })
        .def_property_readonly("extra_bytes_per_record",
                               [](const MapCache& c) { return c.records().extra_bytes_per_record(); })
        .def("set_thresholds", &MapCache::set_thresholds, py::arg("w_min"), py::arg("delta_max"))
        .def("bootstrap", &bootstrap_cache, py::arg("scene"), py::arg("caster"), py::arg("points"),
             py::arg("frame") = 0, py::arg("threads") = 0,
             "Insert a record at every point; gives what the records predict of each other.")
        .def("insert", &insert, py::arg("scene"), py::arg("caster"), py::arg("points"), py::kw_only(),
             py::arg("frame") = 0, py::arg("threads") = 0, py::arg("progress") = py::none(),
             "Insert records where they are needed; gives counts.")
        .def("select", &select_points, py::arg("points"), py::arg("threads") = 0,
             "Records that are blended at every point: ids (N, n_best) or −1, their weights beta, and the "
             "values of the insertion test.")
        .def("records", &records_dict, "Copies of all stored records, one row each.")
        .def("add_records", &add_records, py::arg("positions"), py::arg("normals"), py::arg("bits"),
             py::arg("rays"), py::arg("misses"), py::arg("last_used"), py::arg("ambient"),
             py::arg("nearest_hit"), "Insert records that were traced before.")
        .def(
            "mark_used",
            [](MapCache& cache, const Points& points, uint32_t frame, int threads) {
                run_interruptible(
                    [&](Control& control) { mark_used(cache, points, frame, threads, control); });
            },
            py::arg("points"), py::arg("frame"), py::arg("threads") = 0,
            "Mark the records that are blended at the points as used in the frame.")
        .def("tally", &tally, py::arg("rays"), py::arg("misses"), py::arg("used"), py::arg("frame"))
        .def("remove", &remove, py::arg("frame"), "Removes records as the parameters say; counts.")
        .def("reset_tallies", &reset_tallies)
        .def("shade_ambient", &shade_points, py::arg("points"), py::arg("width"), py::arg("weighted"),
             py::arg("threads") = 0, "Ambient visibility, records averaged, jump, each (N,).");
}

}  // namespace viscache::bindings
