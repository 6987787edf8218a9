// Parameters of the quantized cache.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>

#include "viscache/aqvc/parameters.h"

namespace py = pybind11;

namespace viscache::bindings {

void bind_aqvc_keys(py::module_& m);
void bind_aqvc_levels(py::module_& m);
void bind_aqvc_run(py::module_& m);
void bind_aqvc_samples(py::module_& m);

namespace {

constexpr std::array kRefinements{"auto", "on", "off"};

/// The member of a closed set that has this name.
template <class Enum, size_t N>
Enum named(const char* field, const std::array<const char*, N>& names, const std::string& name) {
    std::string all;
    for (size_t i = 0; i < N; ++i) {
        if (name == names[i]) return Enum(i);
        all += (i ? ", " : "") + std::string(names[i]);
    }
    throw py::value_error(std::string(field) + " must be one of " + all + ", got " + name);
}

/// A field of a closed set, read and written by name.
template <class Enum, size_t N>
void named_field(py::class_<AqvcParameters>& c, const char* field, Enum AqvcParameters::* member,
                 std::array<const char*, N> names) {
    c.def_property(
        field, [=](const AqvcParameters& p) { return names[size_t(p.*member)]; },
        [=](AqvcParameters& p, const std::string& name) { p.*member = named<Enum>(field, names, name); });
}

/// Refinement by light group: names, or None where the group follows `refinement`.
void bind_refinement_group(py::class_<AqvcParameters>& c) {
    using Names = std::array<std::optional<std::string>, kLightGroups>;
    c.def_property(
        "refinement_group",
        [](const AqvcParameters& p) {
            Names names;
            for (size_t g = 0; g < names.size(); ++g)
                if (p.refinement_group[g]) names[g] = kRefinements[size_t(*p.refinement_group[g])];
            return names;
        },
        [](AqvcParameters& p, const Names& names) {
            for (size_t g = 0; g < names.size(); ++g) {
                p.refinement_group[g].reset();
                if (names[g])
                    p.refinement_group[g] = named<Refinement>("refinement_group", kRefinements, *names[g]);
            }
        });
}

AqvcParameters from_keywords(const py::kwargs& keywords) {
    AqvcParameters p;
    py::object self = py::cast(&p, py::return_value_policy::reference);
    for (auto [name, value] : keywords) {
        if (!py::hasattr(self, name))
            throw py::value_error("AqvcParameters has no parameter " + py::cast<std::string>(name));
        py::setattr(self, name, value);
    }
    p.validate();
    return p;
}

}  // namespace

void bind_aqvc(py::module_& m) {
    py::module_ a = m.def_submodule("aqvc", "Quantized visibility cache (AQVC).");
    py::class_<AqvcParameters> c(a, "AqvcParameters",
                                 "Parameters of the quantized cache; see viscache.Aqvc.");
    c.def(py::init(&from_keywords));
    c.def_readwrite("c_e", &AqvcParameters::c_e);
    c.def_readwrite("c_e_group", &AqvcParameters::c_e_group);
    c.def_readwrite("c_l", &AqvcParameters::c_l);
    c.def_readwrite("c_n", &AqvcParameters::c_n);
    c.def_readwrite("c_z", &AqvcParameters::c_z);
    c.def_readwrite("c_r", &AqvcParameters::c_r);
    named_field(c, "normal_mode", &AqvcParameters::normal_mode,
                std::array{"round", "floor", "octahedral", "single"});
    c.def_readwrite("grid_offset", &AqvcParameters::grid_offset);
    c.def_readwrite("scale_free", &AqvcParameters::scale_free);
    c.def_readwrite("grid_seed", &AqvcParameters::grid_seed);
    c.def_readwrite("tangent_neighbours", &AqvcParameters::tangent_neighbours);
    named_field(c, "res_rule", &AqvcParameters::res_rule, std::array{"eq7", "eq6"});
    named_field(c, "env_rule", &AqvcParameters::env_rule, std::array{"derived", "printed"});
    c.def_readwrite("jitter", &AqvcParameters::jitter);
    named_field(c, "cell_density", &AqvcParameters::cell_density, std::array{"light", "mixture"});
    named_field(c, "vpl_key", &AqvcParameters::vpl_key, std::array{"point", "surface"});
    named_field(c, "refinement", &AqvcParameters::refinement, kRefinements);
    bind_refinement_group(c);
    c.def_readwrite("nil_refine", &AqvcParameters::nil_refine);
    named_field(c, "level_rule", &AqvcParameters::level_rule, std::array{"finest", "log2"});
    c.def_readwrite("level_step", &AqvcParameters::level_step);
    c.def_readwrite("c_finest", &AqvcParameters::c_finest);
    c.def_readwrite("max_levels", &AqvcParameters::max_levels);
    c.def_readwrite("by_contribution", &AqvcParameters::by_contribution);
    c.def_readwrite("contribution_power", &AqvcParameters::contribution_power);
    c.def_readwrite("contribution_lift", &AqvcParameters::contribution_lift);
    c.def_readwrite("contribution_slack", &AqvcParameters::contribution_slack);
    named_field(c, "hash", &AqvcParameters::hash, std::array{"scheme2", "scheme1", "scheme1_mixed"});
    c.def_readwrite("digest_bits", &AqvcParameters::digest_bits);
    c.def_readwrite("table_bytes", &AqvcParameters::table_bytes);
    named_field(c, "order", &AqvcParameters::order, std::array{"hm", "scanline", "random"});
    c.def_readwrite("c_pg", &AqvcParameters::c_pg);
    named_field(c, "form", &AqvcParameters::form, std::array{"waves", "rows", "pairs"});
    named_field(c, "storage", &AqvcParameters::storage,
                std::array{"table", "exact", "shared", "paper_tiles"});
    c.def_readwrite("batch", &AqvcParameters::batch);
    c.def_readwrite("queue", &AqvcParameters::queue);
    c.def_readwrite("c_w", &AqvcParameters::c_w);
    c.def("validate", &AqvcParameters::validate);
    c.def(
        "level_list",
        [](const AqvcParameters& p, int group, int spp, double lift) {
            return level_list(p, group, spp, lift);
        },
        py::arg("group"), py::kw_only(), py::arg("spp") = 1, py::arg("lift") = 1.0,
        "C_E of every level of a light group, coarse to fine.");
    bind_aqvc_keys(a);
    bind_aqvc_levels(a);
    bind_aqvc_run(a);
    bind_aqvc_samples(a);
}

}  // namespace viscache::bindings
