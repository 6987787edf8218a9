// Parameters of the quantized cache, bound row by row from their table.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <map>

#include "viscache/aqvc/parameters.h"

namespace py = pybind11;

namespace viscache::bindings {

void bind_aqvc_keys(py::module_& a, py::module_& t);
void bind_aqvc_levels(py::module_& a);
void bind_aqvc_run(py::module_& t);
void bind_aqvc_samples(py::module_& t);

namespace {

using Class = py::class_<AqvcParameters>;
template <class Value>
using Row = ParameterRow<AqvcParameters, Value>;
template <class Value>
using ByGroup = std::array<Value, kLightGroups>;

/// The enumerator with this name.
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

// Python reads and writes numbers as numbers and enumerations as names. A parameter per light group is a
// mapping that holds only the groups with a value of their own.
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

/// The allowed values of a parameter, as text for Python's help.
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
          "Name, kind, keyed, paper and doc of every row of the C++ table of parameters.");
    py::module_ t = m.def_submodule("_testing");
    bind_aqvc_keys(a, t);
    bind_aqvc_levels(a);
    bind_aqvc_run(t);
    bind_aqvc_samples(t);
}

}  // namespace viscache::bindings
