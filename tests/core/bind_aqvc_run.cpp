// The quantized cache over given eye points and lights without a renderer.
#include <numeric>

#include "analytic_caster.h"
#include "arrays.h"
#include "real_numbers.h"
#include "viscache/aqvc/quantized_cache.h"
#include "viscache/oracles/exact.h"
#include "viscache/visibility/given_contributions.h"

namespace viscache::bindings {
namespace {

using namespace py::literals;

EyeBlock eye_block(const py::dict& d, float extent) {
    EyeBlock eyes;
    eyes.position = vec3s(d["position"].cast<FloatArray>(), "position");
    eyes.normal = vec3s(d["normal"].cast<FloatArray>(), "normal");
    eyes.density = d["density"].cast<std::vector<float>>();
    if (d.contains("order_x")) {
        eyes.order_x = d["order_x"].cast<std::vector<uint32_t>>();
        eyes.order_y = d["order_y"].cast<std::vector<uint32_t>>();
        eyes.tile_width = d["tile_width"].cast<uint32_t>();
        eyes.tile_height = d["tile_height"].cast<uint32_t>();
    }
    if (eyes.normal.size() != eyes.size() || eyes.density.size() != eyes.size())
        throw py::value_error("position, normal and density must have equal lengths");
    for (size_t i = 0; i < eyes.size(); ++i)
        eyes.origin.push_back(spawn(eyes.position[i], eyes.normal[i], extent));
    return eyes;
}

FarEnds far_ends(const py::dict& d, float extent) {
    FarEnds l;
    l.semantic = Semantic(d["semantic"].cast<int>());
    l.group = d["group"].cast<int>();
    const auto far = vec3s(d["far"].cast<FloatArray>(), "far"),
               normal = vec3s(d["normal"].cast<FloatArray>(), "normal");
    l.density = d["density"].cast<std::vector<float>>();
    l.count = far.size();
    if (normal.size() != l.count || l.density.size() != l.count)
        throw py::value_error("far, normal and density must have equal lengths");
    for (auto* v : {&l.x, &l.y, &l.z, &l.nx, &l.ny, &l.nz, &l.tx, &l.ty, &l.tz, &l.density})
        v->resize((l.count + 511) / 512 * 512);
    for (size_t k = 0; k < l.count; ++k) {
        const Vec3 end = l.semantic == Semantic::kSurface ? spawn(far[k], normal[k], extent) : far[k];
        l.x[k] = far[k].x;
        l.y[k] = far[k].y;
        l.z[k] = far[k].z;
        l.nx[k] = normal[k].x;
        l.ny[k] = normal[k].y;
        l.nz[k] = normal[k].z;
        l.tx[k] = end.x;
        l.ty[k] = end.y;
        l.tz[k] = end.z;
    }
    return l;
}

py::dict counters_dict(const Counters& c) {
    py::list groups;
    for (const auto& g : c.groups)
        groups.append(py::dict("queries"_a = g.queries, "occluded"_a = g.occluded, "rays"_a = g.rays));
    py::dict d("groups"_a = groups, "queries"_a = c.queries(), "rays"_a = c.rays(), "lookups"_a = c.lookups,
               "hits"_a = c.hits, "neighbour_probes"_a = c.neighbour_probes,
               "nil_neighbours"_a = c.nil_neighbours, "evictions"_a = c.evictions, "bypassed"_a = c.bypassed,
               "boundary_queries"_a = c.boundary_queries, "cells"_a = c.cells,
               "expected_false_hits"_a = c.expected_false_hits);
    d["leftover_rays"] = c.leftover_rays;
    d["clamped_low"] = c.clamped_low;
    d["clamped_high"] = c.clamped_high;
    d["clamped_nan"] = c.clamped_nan;
    d["table_writes"] = c.table_writes;
    d["table_slots"] = c.table_slots;
    d["rays_per_level"] = std::vector<uint64_t>(c.rays_per_level.begin(), c.rays_per_level.end());
    return d;
}

/// A cache over one tile. Every call asks about this tile.
class TileRun {
public:
    TileRun(const AnalyticCaster& caster, const py::dict& eyes, const AqvcParameters& p, Float3 center,
            float radius, float extent, int spp)
        : caster_(caster),
          extent_(extent),
          eyes_(eye_block(eyes, extent)),
          cache_(caster_, ExactAnswers{std::make_unique<ExactOracle>(caster_)}, p, vec3(center), radius,
                 spp) {
        cache_.begin_tile(eyes_);
    }
    py::tuple block(const py::dict& lights, const BoolArray& wanted, bool exact,
                    const std::optional<FloatArray>& contribution) {
        const FarEnds far = far_ends(lights, extent_);
        if (wanted.ndim() != 2 || size_t(wanted.shape(0)) != eyes_.size() ||
            size_t(wanted.shape(1)) != far.count)
            throw py::value_error("wanted must have shape (eye points, lights), got " + shape_text(wanted));
        BitMatrix asked(eyes_.size(), far.count);
        for (size_t i = 0; i < eyes_.size(); ++i)
            for (size_t k = 0; k < far.count; ++k)
                if (wanted.at(i, k)) asked.set(i, k);
        Counters counters;
        std::vector<uint32_t> row(eyes_.size());
        std::iota(row.begin(), row.end(), 0u);
        std::optional<GivenContributions> given;
        if (contribution) {
            const FloatArray& f = *contribution;
            if (f.ndim() != 2 || size_t(f.shape(0)) != row.size() || size_t(f.shape(1)) != far.count)
                throw py::value_error("contribution must have shape (eye points, lights), got " +
                                      shape_text(f));
            given.emplace(f.data(), far.count, row);
        }
        const BlockAsk ask{eyes_, far, asked, given ? &*given : nullptr};
        BitMatrix traced;
        if (exact) exact_block(ask, traced);
        const BitMatrix& visible = exact ? traced : *cache_.block(ask, counters).bits;
        py::array_t<bool> out({eyes_.size(), far.count});
        for (size_t i = 0; i < eyes_.size(); ++i)
            for (size_t k = 0; k < far.count; ++k) out.mutable_at(i, k) = visible.get(i, k);
        return py::make_tuple(out, counters_dict(counters));
    }
    py::tuple pairs(const std::vector<uint32_t>& eye, int semantic, int group, const FloatArray& far,
                    const FloatArray& normal, const std::vector<float>& density, bool exact) {
        const auto y = vec3s(far, "far"), n = vec3s(normal, "normal");
        std::vector<ShadowQuery> queries;
        for (size_t i = 0; i < eye.size(); ++i) {
            if (eye[i] >= eyes_.size()) throw py::value_error("eye must be an eye point of the tile");
            const Vec3 end =
                Semantic(semantic) == Semantic::kSurface ? spawn(y.at(i), n.at(i), extent_) : y.at(i);
            queries.push_back(
                {eye[i], Semantic(semantic), uint8_t(group), y.at(i), n.at(i), end, density.at(i)});
        }
        Counters counters;
        Answer answer;
        if (!exact) answer = cache_.pairs({eyes_, queries}, counters);
        std::vector<bool> out;
        for (size_t i = 0; i < queries.size(); ++i) {
            uint8_t blocked = 0;
            const Ray ray = shadow_ray(eyes_, queries[i]);
            if (exact) caster_.occluded({&ray, 1}, {&blocked, 1});
            out.push_back(exact ? !blocked : answer.bits->get(0, i));
        }
        return py::make_tuple(out, counters_dict(counters));
    }
    /// Every sample belongs to one eye point. The samples of an eye point are adjacent.
    py::tuple samples(const std::vector<uint32_t>& eye, int semantic, int group, const FloatArray& far,
                      const FloatArray& normal, const std::vector<float>& density,
                      const std::vector<float>& light_density) {
        const auto y = vec3s(far, "far"), n = vec3s(normal, "normal");
        LocalSamples s;
        s.semantic = Semantic(semantic);
        s.group = group;
        for (size_t i = 0; i < eye.size(); ++i) {
            if (eye[i] >= eyes_.size()) throw py::value_error("eye must be an eye point of the tile");
            s.add(y.at(i), density.at(i), light_density.at(i));
            if (!s.is_direction()) {
                s.normal.push_back(n.at(i));
                s.ray_end.push_back(spawn(y[i], n[i], extent_));
            }
            if (i + 1 == eye.size() || eye[i + 1] != eye[i]) s.close(eye[i]);
        }
        Counters counters;
        const Answer answer = cache_.pairs({.eyes = eyes_, .samples = &s}, counters);
        std::vector<bool> out;
        for (size_t i = 0; i < s.size(); ++i) out.push_back(answer.bits->get(0, i));
        return py::make_tuple(out, counters_dict(counters));
    }
    /// Of samples of a light group, or of queries.
    py::tuple order(std::optional<int> group) {
        const PairOrder o = cache_.order(eyes_, group);
        return py::make_tuple(std::vector<uint32_t>(o.eye.begin(), o.eye.end()),
                              std::vector<uint32_t>(o.run_end.begin(), o.run_end.end()));
    }
    /// Clears the cache and starts the same tile again.
    void begin_tile() { cache_.begin_tile(eyes_); }

private:
    void exact_block(const BlockAsk& ask, BitMatrix& visible) {
        visible.reset(ask.wanted.rows(), ask.wanted.columns());
        for (uint32_t i = 0; i < eyes_.size(); ++i)
            for_each_bit(ask.wanted.row_span(i), [&](size_t k) {
                const Ray ray = shadow_ray(eyes_, i, ask.lights, k);
                uint8_t blocked = 0;
                caster_.occluded({&ray, 1}, {&blocked, 1});
                if (!blocked) visible.set(i, k);
            });
    }
    AnalyticCaster caster_;
    float extent_;
    EyeBlock eyes_;
    QuantizedCache cache_;
};

AnalyticCaster analytic_caster(const FloatArray& boxes, const FloatArray& spheres) {
    require_rows(boxes, 6, "boxes");
    require_rows(spheres, 4, "spheres");
    std::vector<AnalyticCaster::Box> b;
    std::vector<AnalyticCaster::Sphere> s;
    for (py::ssize_t i = 0; i < boxes.shape(0); ++i)
        b.push_back({{boxes.at(i, 0), boxes.at(i, 1), boxes.at(i, 2)},
                     {boxes.at(i, 3), boxes.at(i, 4), boxes.at(i, 5)}});
    for (py::ssize_t i = 0; i < spheres.shape(0); ++i)
        s.push_back({{spheres.at(i, 0), spheres.at(i, 1), spheres.at(i, 2)}, spheres.at(i, 3)});
    return {b, s};
}

}  // namespace

void bind_aqvc_run(py::module_& t) {
    py::class_<AnalyticCaster>(t, "AnalyticCaster", "Boxes (lo, hi) and spheres (centre, radius).")
        .def(py::init(&analytic_caster), py::arg("boxes"), py::arg("spheres"));
    py::class_<TileRun>(t, "TileRun", "The quantized cache over one tile of given eye points.")
        .def(py::init<const AnalyticCaster&, const py::dict&, const AqvcParameters&, Float3, float, float,
                      int>(),
             py::arg("caster"), py::arg("eyes"), py::arg("parameters"), py::kw_only(), py::arg("center"),
             py::arg("radius"), py::arg("extent"), py::arg("spp") = 1)
        .def("block", &TileRun::block, py::arg("lights"), py::arg("wanted"), py::kw_only(),
             py::arg("exact") = false, py::arg("contribution") = py::none())
        .def("pairs", &TileRun::pairs, py::arg("eye"), py::kw_only(), py::arg("semantic"), py::arg("group"),
             py::arg("far"), py::arg("normal"), py::arg("density"), py::arg("exact") = false)
        .def("samples", &TileRun::samples, py::arg("eye"), py::kw_only(), py::arg("semantic"),
             py::arg("group"), py::arg("far"), py::arg("normal"), py::arg("density"),
             py::arg("light_density"))
        .def("begin_tile", &TileRun::begin_tile)
        .def("order", &TileRun::order, py::arg("group") = py::none());
}

}  // namespace viscache::bindings
