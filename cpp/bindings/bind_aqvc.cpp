// Parameters of the quantized cache, by their table.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <map>

#include "viscache/aqvc/parameters.h"

namespace py = pybind11;

namespace viscache::bindings {

void bind_aqvc_keys(py::module_& m);
void bind_aqvc_levels(py::module_& m);
void bind_aqvc_run(py::module_& m);
void bind_aqvc_samples(py::module_& m);

namespace {

using Class = py::class_<AqvcParameters>;
template <class Value>
using Row = ParameterRow<AqvcParameters, Value>;
template <class Value>
using ByGroup = std::array<Value, kLightGroups>;

/// The member of a closed set that has this name.
template <class Enum>
Enum named(const char* parameter, const std::string& name) {
    std::string all;
    for (size_t i = 0; i < kNames<Enum>.size(); ++i) {
        if (name == kNames<Enum>[i]) return Enum(i);
        all += (i ? ", " : "") + std::string(kNames<Enum>[i]);
    }
    throw py::value_error(std::string(parameter) + " must be one of " + all + ", got " + name);
}

size_t group_named(const char* parameter, const std::string& name) {
    for (size_t g = 0; g < size_t(kLightGroups); ++g)
        if (name == kLightGroupNames[g]) return g;
    throw py::value_error(std::string(parameter) + " must be of light groups, got " + name);
}

// How a parameter is read and written: numbers as they are, closed sets by name, those by light group as
// mappings of the groups that have their own.
template <class Value>
void bind_row(Class& c, const Row<Value>& row) {
    if constexpr (std::is_enum_v<Value>)
        c.def_property(
            row.name, [row](const AqvcParameters& p) { return kNames<Value>[size_t(p.*row.member)]; },
            [row](AqvcParameters& p, const std::string& name) {
                p.*row.member = named<Value>(row.name, name);
            });
    else
        c.def_readwrite(row.name, row.member);
}

void bind_row(Class& c, const Row<ByGroup<double>>& row) {
    c.def_property(
        row.name,
        [row](const AqvcParameters& p) {
            std::map<std::string, double> own;
            for (size_t g = 0; g < size_t(kLightGroups); ++g)
                if ((p.*row.member)[g] > 0) own[kLightGroupNames[g]] = (p.*row.member)[g];
            return own;
        },
        [row](AqvcParameters& p, const std::map<std::string, double>& own) {
            p.*row.member = {};
            for (const auto& [group, c_e] : own) (p.*row.member)[group_named(row.name, group)] = c_e;
        });
}

void bind_row(Class& c, const Row<ByGroup<std::optional<Refinement>>>& row) {
    c.def_property(
        row.name,
        [row](const AqvcParameters& p) {
            std::map<std::string, std::string> own;
            for (size_t g = 0; g < size_t(kLightGroups); ++g)
                if (const auto& chosen = (p.*row.member)[g])
                    own[kLightGroupNames[g]] = kNames<Refinement>[size_t(*chosen)];
            return own;
        },
        [row](AqvcParameters& p, const std::map<std::string, std::string>& own) {
            p.*row.member = {};
            for (const auto& [group, name] : own)
                (p.*row.member)[group_named(row.name, group)] = named<Refinement>(row.name, name);
        });
}

AqvcParameters from_keywords(const py::kwargs& keywords) {
    AqvcParameters p;
    py::object self = py::cast(&p, py::return_value_policy::reference);
    for (auto [name, value] : keywords) {
        bool known = false;
        for_each_row(kAqvcRows, [&](const auto& row) { known |= py::cast<std::string>(name) == row.name; });
        if (!known) throw py::value_error("AqvcParameters has no parameter " + py::cast<std::string>(name));
        py::setattr(self, name, value);
    }
    p.validate();
    return p;
}

/// What a parameter may be, as Python's help says it.
template <class Value>
std::string kind_of(const Row<Value>& row) {
    if constexpr (std::is_enum_v<Value>) {
        std::string all;
        for (const char* name : kNames<Value>)
            all += (all.empty() ? "\"" : ", \"") + std::string(name) + "\"";
        return "{" + all + "}";
    } else if constexpr (std::same_as<Value, ByGroup<double>>) {
        return "mapping of light group to float > 0";
    } else if constexpr (std::same_as<Value, ByGroup<std::optional<Refinement>>>) {
        return "mapping of light group to {\"auto\", \"on\", \"off\"}";
    } else if constexpr (std::same_as<Value, bool>) {
        return "bool";
    } else {
        const std::string range = row.range.text();
        return (std::is_floating_point_v<Value> ? "float" : "int") + (range.empty() ? range : " " + range);
    }
}

py::list parameter_rows() {
    using namespace py::literals;
    py::list rows;
    for_each_row(kAqvcRows, [&](const auto& row) {
        rows.append(py::dict("name"_a = row.name, "kind"_a = kind_of(row), "keyed"_a = bool(row.use & kKeyed),
                             "paper"_a = bool(row.use & kPaper), "doc"_a = row.doc));
    });
    return rows;
}

}  // namespace

void bind_aqvc(py::module_& m) {
    py::module_ a = m.def_submodule("aqvc", "Quantized visibility cache (AQVC).");
    Class c(a, "AqvcParameters", "Parameters of the quantized cache; see viscache.Aqvc.");
    c.def(py::init(&from_keywords));
    for_each_row(kAqvcRows, [&](const auto& row) { bind_row(c, row); });
    c.def("validate", &AqvcParameters::validate);
    c.def(
        "level_list",
        [](const AqvcParameters& p, int group, int spp, double lift) {
            return level_list(p, group, spp, lift);
        },
        py::arg("group"), py::kw_only(), py::arg("spp") = 1, py::arg("lift") = 1.0,
        "C_E of every level of a light group, coarse to fine.");
    a.def("parameter_rows", &parameter_rows,
          "Name, kind, keyed, paper and doc of every parameter, as the C++ table has them.");
    bind_aqvc_keys(a);
    bind_aqvc_levels(a);
    bind_aqvc_run(a);
    bind_aqvc_samples(a);
}

}  // namespace viscache::bindings
