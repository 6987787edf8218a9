// Sources of oracles.

#include "arrays.h"
#include "bind_rows.h"
#include "real_numbers.h"
#include "viscache/aqvc/aqvc_source.h"
#include "viscache/oracles/correct_settings.h"
#include "viscache/oracles/exact_source.h"
#include "viscache/oracles/kept_voxels.h"
#include "viscache/oracles/residual_source.h"
#include "viscache/oracles/roulette_source.h"
#include "viscache/oracles/shadow_map_source.h"
#include "viscache/oracles/unoccluded_source.h"
#include "viscache/vlf/aligned_source.h"

namespace viscache::bindings {

namespace {

std::optional<Coherence> flag_of(std::optional<bool> coherent) {
    if (!coherent) return std::nullopt;
    return *coherent ? Coherence::kCoherent : Coherence::kIncoherent;
}

// Sources refer to the scene and the caster; number 1 is the source itself, and arguments count from 2.
using KeepScene = py::keep_alive<1, 2>;
using KeepCaster = py::keep_alive<1, 3>;
const py::arg kScene("scene"), kCaster("caster");

void bind_exact_sources(py::module_& m) {
    py::class_<ExactSource, OracleSource>(m, "ExactSource", "See viscache.Exact.")
        .def(py::init([](const Scene&, const RayCaster& c, std::optional<PacketOrder> order,
                         std::optional<bool> coherent) {
                 return std::make_unique<ExactSource>(c, order, flag_of(coherent));
             }),
             kScene, kCaster, py::kw_only(), py::arg("order") = py::none(), py::arg("coherent") = py::none(),
             KeepScene(), KeepCaster());
    py::class_<UnoccludedSource, OracleSource>(m, "UnoccludedSource", "See viscache.Unoccluded.")
        .def(py::init<>());
    py::class_<AlignedSource, OracleSource>(m, "AlignedSource",
                                            "Exact rays. A batch may trace shared directions.")
        .def(py::init([](const Scene&, const RayCaster& c, const AlignedBatch& batch, bool choose,
                         std::optional<PacketOrder> order, std::optional<bool> coherent) {
                 return std::make_unique<AlignedSource>(c, batch, choose, order, flag_of(coherent));
             }),
             kScene, kCaster, py::arg("batch"), py::kw_only(), py::arg("choose"),
             py::arg("order") = py::none(), py::arg("coherent") = py::none(), KeepScene(), KeepCaster(),
             py::keep_alive<1, 4>());
}

void bind_aqvc_sources(py::module_& m) {
    py::class_<AqvcSource, OracleSource>(m, "AqvcSource", "See viscache.Aqvc.")
        .def(py::init([](const Scene& s, const RayCaster& c, const AqvcParameters& p, int spp,
                         std::optional<OracleSource*> exact) {
                 // None: groups that need exact rays get them from the cache's own caster.
                 return std::make_unique<AqvcSource>(s, c, p, spp, exact.value_or(nullptr));
             }),
             kScene, kCaster, py::arg("parameters"), py::kw_only(), py::arg("spp"),
             py::arg("exact") = py::none(), KeepScene(), KeepCaster(), py::keep_alive<1, 6>());
    py::class_<FrameTableSource, OracleSource>(
        m, "FrameTableSource", "A quantized cache with one table per frame; see viscache.Bdpt.")
        .def(py::init<const Scene&, const RayCaster&, const AqvcParameters&, int>(), kScene, kCaster,
             py::arg("parameters"), py::kw_only(), py::arg("spp"), KeepScene(), KeepCaster());
    py::class_<KeptTableSource, OracleSource>(m, "KeptTableSource", "See viscache.AqvcTable.")
        .def(py::init([](const Scene& s, const RayCaster& c, const AqvcParameters& p, KeptTable& table,
                         int spp, double check, bool repair) {
                 return std::make_unique<KeptTableSource>(s, c, p, spp, table, KeptChecks{check, repair});
             }),
             kScene, kCaster, py::arg("parameters"), py::arg("table"), py::kw_only(), py::arg("spp"),
             py::arg("check"), py::arg("repair"), KeepScene(), KeepCaster(), py::keep_alive<1, 5>());
    py::class_<AqvcRowsSource, OracleSource>(m, "AqvcRowsSource", "See viscache.AqvcRows.")
        .def(py::init([](const Scene& s, const RayCaster& c, const AqvcParameters& p, AqvcRows& rows, int spp,
                         std::optional<OracleSource*> exact) {
                 return std::make_unique<AqvcRowsSource>(s, c, p, spp, rows, exact.value_or(nullptr));
             }),
             kScene, kCaster, py::arg("parameters"), py::arg("rows"), py::kw_only(), py::arg("spp"),
             py::arg("exact") = py::none(), KeepScene(), KeepCaster(), py::keep_alive<1, 5>(),
             py::keep_alive<1, 7>());
}

void bind_baseline_sources(py::module_& m) {
    py::class_<ShadowMapSettings> maps(m, "ShadowMapSettings", "See viscache.ShadowMap.");
    bind_rows(maps, kShadowMapRows);
    py::class_<ShadowMapSource, OracleSource>(m, "ShadowMapSource", "See viscache.ShadowMap.")
        .def(py::init<const Scene&, const RayCaster&, const ShadowMapSettings&>(), kScene, kCaster,
             py::arg("settings"), KeepScene(), KeepCaster());
    py::class_<RouletteSource, OracleSource>(m, "RouletteSource", "See viscache.NeePlusPlus.")
        .def(py::init([](const Scene& s, const RayCaster& c, const NeePlusPlusSettings& p, uint64_t seed,
                         bool weighted, std::optional<KeptVoxels*> keep) {
                 return std::make_unique<RouletteSource>(
                     s, c, p,
                     RouletteOptions{.seed = seed, .weighted = weighted, .keep = keep.value_or(nullptr)});
             }),
             kScene, kCaster, py::arg("settings"), py::kw_only(), py::arg("seed"), py::arg("weighted") = true,
             py::arg("keep") = py::none(), KeepScene(), KeepCaster(), py::keep_alive<1, 7>())
        .def_static(
            "correct",
            [](const Scene& s, const RayCaster& c, const NeePlusPlusSettings& p, std::optional<double> share,
               double certain, uint64_t seed, uint64_t lasting_seed, bool weighted,
               std::optional<KeptVoxels*> keep) {
                RouletteOptions options{.seed = seed, .keep = keep.value_or(nullptr)};
                options.correct = MeanSettings{share, certain, seed, lasting_seed, weighted};
                return std::make_unique<RouletteSource>(s, c, p, options);
            },
            "The means of voxels as a control variate.", kScene, kCaster, py::arg("settings"), py::kw_only(),
            py::arg("share") = py::none(), py::arg("certain"), py::arg("seed"), py::arg("lasting_seed") = 0,
            // A function without an object: 0 is what it returns, and arguments count from 1.
            py::arg("weighted") = true, py::arg("keep") = py::none(), py::keep_alive<0, 1>(),
            py::keep_alive<0, 2>(), py::keep_alive<0, 9>());
}

void bind_correct_source(py::module_& m) {
    py::class_<CorrectSettings> correct(m, "CorrectSettings", "See viscache.Correct.");
    bind_rows(correct, kCorrectRows);
    py::class_<ResidualSource, OracleSource>(m, "ResidualSource", "See viscache.Correct.")
        .def(py::init([](const Scene&, const RayCaster& c, OracleSource& inner, std::optional<double> share,
                         double certain, uint64_t seed, uint64_t lasting_seed, const ClassOctaves& octaves,
                         bool weighted) {
                 ResidualSettings settings;
                 settings.share = share;
                 settings.certain = certain;
                 settings.octaves = octaves;
                 settings.seed = seed;
                 settings.lasting_seed = lasting_seed;
                 settings.weighted = weighted;
                 return std::make_unique<ResidualSource>(c, inner, settings);
             }),
             kScene, kCaster, py::arg("inner"), py::kw_only(), py::arg("share"),
             py::arg("certain") = 1.0 / 64, py::arg("seed"), py::arg("lasting_seed") = 0,
             py::arg("octaves") = plain_octaves(), py::arg("weighted") = true, KeepScene(), KeepCaster(),
             py::keep_alive<1, 4>());
}

}  // namespace

void bind_sources(py::module_& m) {
    py::class_<OracleSource>(m, "OracleSource", "Makes the oracles of one frame.");
    bind_exact_sources(m);
    bind_aqvc_sources(m);
    bind_baseline_sources(m);
    bind_correct_source(m);
}

}  // namespace viscache::bindings
