// Parameters of the quantized cache, bound row by row from their table.

#include <map>

#include "bind_rows.h"
#include "real_numbers.h"
#include "viscache/aqvc/parameters.h"

namespace viscache::bindings {

void bind_aqvc_keys(py::module_& a);
void bind_aqvc_levels(py::module_& a);

namespace {

/// Number of the light group with this name. The error names the parameter.
size_t group_named(const char* parameter, const std::string& name) {
    for (size_t g = 0; g < size_t(kLightGroups); ++g)
        if (name == kLightGroupNames[g]) return g;
    throw py::value_error(std::string(parameter) + " must be of light groups, got " + name);
}

}  // namespace

// Values by light group: mappings of the groups that have their own.
template <>
struct PythonValue<std::array<double, kLightGroups>> {
    using Values = std::array<double, kLightGroups>;

    static py::object read(const Range&, const Values& values) {
        py::dict own;
        // 0 stands for "as the others", so only groups with a value of their own appear.
        for (size_t g = 0; g < values.size(); ++g)
            if (values[g] > 0) own[kLightGroupNames[g]] = values[g];
        return own;
    }
    static Values write(const char* parameter, const Range&, const py::object& given) {
        Values values{};
        for (const auto& [group, c_e] : py::dict(given).cast<std::map<std::string, double>>())
            values[group_named(parameter, group)] = c_e;
        return values;
    }
    static std::string kind(const Range&) { return "mapping of light group to float > 0"; }
};

/// One choice for all light groups, or a mapping of groups; the others have "auto".
template <>
struct PythonValue<RefinementByGroup> {
    static py::object read(const Range&, const RefinementByGroup& values) {
        const auto word = [](Refinement r) { return py::str(kNames<Refinement>[size_t(r)]); };
        // The shortest form that reads back as the same
        if (std::ranges::count(values, values[0]) == kLightGroups) return word(values[0]);
        py::dict own;
        for (size_t g = 0; g < values.size(); ++g)
            if (values[g] != Refinement::kAuto) own[kLightGroupNames[g]] = word(values[g]);
        return own;
    }
    static RefinementByGroup write(const char* parameter, const Range&, const py::object& given) {
        RefinementByGroup values{};
        if (py::isinstance<py::str>(given))
            values.fill(named<Refinement>(parameter, py::str(given)));
        else
            for (const auto& [group, name] : py::dict(given).cast<std::map<std::string, std::string>>())
                values[group_named(parameter, group)] = named<Refinement>(parameter, name);
        return values;
    }
    static std::string kind(const Range&) {
        return PythonValue<Refinement>::kind({}) + " or mapping of light group to these";
    }
};

/// A set of light groups: their names in the order of the groups, or "auto".
template <>
struct PythonValue<std::optional<LightGroupSet>> {
    static py::object read(const Range&, const std::optional<LightGroupSet>& groups) {
        if (!groups) return py::str("auto");
        py::list names;
        for (size_t g = 0; g < groups->size(); ++g)
            if (groups->test(g)) names.append(kLightGroupNames[g]);
        return py::tuple(names);
    }
    static std::optional<LightGroupSet> write(const char* parameter, const Range&, const py::object& given) {
        if (py::isinstance<py::str>(given) && given.cast<std::string>() == "auto") return std::nullopt;
        // A string is a sequence of letters, which must not be taken for names of groups.
        if (py::isinstance<py::str>(given))
            throw py::value_error(std::string(parameter) +
                                  " must be \"auto\" or a set of light groups, got " +
                                  given.cast<std::string>());
        LightGroupSet groups;
        for (const py::handle name : given) groups.set(group_named(parameter, name.cast<std::string>()));
        return groups;
    }
    static std::string kind(const Range&) { return "set of light groups or \"auto\""; }
};

void bind_aqvc(py::module_& m) {
    py::module_ a = m.def_submodule("aqvc", "Quantized visibility cache (AQVC).");
    py::class_<AqvcParameters> c(a, "AqvcParameters",
                                 "Parameters of the quantized cache; see viscache.Aqvc.");
    bind_rows(c, kAqvcRows);
    c.def(
        "level_list",
        [](const AqvcParameters& p, int group, int spp, double lift) {
            return level_list(p, group, spp, lift);
        },
        py::arg("group"), py::kw_only(), py::arg("spp") = 1, py::arg("lift") = 1.0,
        "C_E of every level of a light group, coarse to fine.");
    bind_aqvc_keys(a);
    bind_aqvc_levels(a);
}

}  // namespace viscache::bindings
