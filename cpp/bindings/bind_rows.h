#pragma once
// Binds a struct of parameters by the table of its rows: attributes, keywords, ranges and help.
#include <pybind11/pybind11.h>

#include <concepts>
#include <string>
#include <type_traits>

#include "viscache/visibility/parameter_row.h"

namespace viscache::bindings {

namespace py = pybind11;

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

/// How a value of a row is read, written and described in Python. Numbers: as they are, or the word of the
/// open value. Numbers out of range are refused.
template <class Value>
struct PythonValue {
    using Given = py::object;

    static py::object read(const auto& row, Value value) {
        const Range& range = row.range;
        if (!range.open || double(value) != *range.open) return py::cast(value);
        return range.open_word ? py::object(py::str(range.open_word)) : py::none();
    }
    static Value write(const auto& row, const py::object& given) {
        const Range& range = row.range;
        if (range.open && is_open(range, given)) return Value(*range.open);
        const std::string got = ", got " + std::string(py::repr(given));
        double number = 0;
        try {
            number = given.cast<double>();
        } catch (const py::cast_error&) {
            throw py::value_error(std::string(row.name) + " must be a number" + got);
        }
        if (!range.holds(number)) throw py::value_error(row.must(number) + got);
        try {
            return given.cast<Value>();
        } catch (const py::cast_error&) {
            const bool whole = number == std::floor(number);
            throw py::value_error(
                std::string(row.name) + " must be " +
                (whole ? "< " + Range::number(std::ldexp(1.0, std::numeric_limits<Value>::digits))
                       : "a whole number") +
                got);
        }
    }
    static std::string kind(const Range& range) {
        std::string text = std::is_floating_point_v<Value> ? "float" : "int";
        if (const std::string ends = range.text(); !ends.empty()) text += " " + ends;
        if (range.open)
            text += range.open_word ? " or \"" + std::string(range.open_word) + "\"" : ", optional";
        return text;
    }

private:
    static bool is_open(const Range& range, const py::object& given) {
        if (!range.open_word) return given.is_none();
        return py::isinstance<py::str>(given) && given.cast<std::string>() == range.open_word;
    }
};

template <>
struct PythonValue<bool> {
    using Given = bool;

    static bool read(const auto&, bool value) { return value; }
    static bool write(const auto&, bool given) { return given; }
    static std::string kind(const Range&) { return "bool"; }
};

/// Closed sets: by name.
template <class Enum>
    requires std::is_enum_v<Enum>
struct PythonValue<Enum> {
    using Given = std::string;

    static const char* read(const auto&, Enum value) { return kNames<Enum>[size_t(value)]; }
    static Enum write(const auto& row, const std::string& given) { return named<Enum>(row.name, given); }
    static std::string kind(const Range&) {
        std::string all;
        for (const char* name : kNames<Enum>) all += (all.empty() ? "\"" : ", \"") + std::string(name) + "\"";
        return "{" + all + "}";
    }
};

template <class Struct, class Value>
void bind_row(py::class_<Struct>& c, const ParameterRow<Struct, Value>& row) {
    using Written = PythonValue<Value>;
    c.def_property(
        row.name, [row](const Struct& s) { return Written::read(row, s.*row.member); },
        [row](Struct& s, const typename Written::Given& given) {
            s.*row.member = Written::write(row, given);
        });
}

/// Name, kind, range, uses and doc of every row.
template <class Struct, class... Values>
py::list row_dicts(const std::tuple<ParameterRow<Struct, Values>...>& table) {
    using namespace py::literals;
    py::list rows;
    const auto add = [&]<class Value>(const ParameterRow<Struct, Value>& row) {
        rows.append(py::dict("name"_a = row.name, "kind"_a = PythonValue<Value>::kind(row.range),
                             "low"_a = row.range.low, "high"_a = row.range.high, "above"_a = row.range.above,
                             "keyed"_a = bool(row.use & kKeyed), "paper"_a = bool(row.use & kPaper),
                             "doc"_a = row.doc));
    };
    for_each_row(table, add);
    return rows;
}

/// Constructor by keywords, one attribute per row, `validate` and `parameter_rows`.
template <class Struct, class... Values>
void bind_rows(py::class_<Struct>& c, const std::tuple<ParameterRow<Struct, Values>...>& table) {
    c.def(py::init([&table](const py::kwargs& keywords) {
        Struct made;
        const py::object self = py::cast(&made, py::return_value_policy::reference);
        for (auto [name, value] : keywords) {
            const auto given = py::cast<std::string>(name);
            bool known = false;
            for_each_row(table, [&](const auto& row) { known |= given == row.name; });
            if (!known)
                throw py::value_error(std::string(py::str(py::type::of(self).attr("__name__"))) +
                                      " has no parameter " + given);
            py::setattr(self, name, value);
        }
        made.validate();
        return made;
    }));
    for_each_row(table, [&](const auto& row) { bind_row(c, row); });
    c.def("validate", &Struct::validate);
    c.def_static(
        "parameter_rows", [&table] { return row_dicts(table); },
        "Name, kind, range, uses and doc of every parameter, as the C++ table has them.");
}

}  // namespace viscache::bindings
