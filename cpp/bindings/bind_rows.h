#pragma once
// Binds a struct of parameters by the table of its rows: attributes, keywords, ranges and help.
#include <pybind11/pybind11.h>

#include <string>
#include <type_traits>

#include "viscache/visibility/parameter_row.h"

namespace viscache::bindings {

namespace py = pybind11;

/// A value of any type; stubs say typing.Any.
class AnyValue : public py::object {
    PYBIND11_OBJECT_DEFAULT(AnyValue, py::object, PyObject_Type)
    using py::object::object;
};

}  // namespace viscache::bindings

template <>
struct pybind11::detail::handle_type_name<viscache::bindings::AnyValue> {
    static constexpr auto name = const_name("typing.Any");
};

namespace viscache::bindings {

inline std::string got(const py::handle& given) { return ", got " + std::string(py::repr(given)); }

/// The first names of a closed set, up to the enumerator `last`.
/// Some parameters take only a part of the set: the range of their row ends at the last one that they take.
template <class Enum>
std::span<const char* const> names_up_to(double last) {
    return std::span(kNames<Enum>).first(size_t(std::min(last + 1, double(kNames<Enum>.size()))));
}

/// The member of a closed set that has this name.
template <class Enum>
Enum named(const char* parameter, const std::string& name, double last = Range::kAny) {
    std::string all;
    const auto names = names_up_to<Enum>(last);
    for (size_t i = 0; i < names.size(); ++i) {
        if (name == names[i]) return Enum(i);
        all += (i ? ", " : "") + std::string(names[i]);
    }
    throw py::value_error(std::string(parameter) + " must be one of " + all + ", got " + name);
}

/// How a value of a row is read, written and described in Python. Numbers: as they are, or the word of the
/// open value. Numbers out of range are refused.
template <class Value>
struct PythonValue {
    static py::object read(const Range& range, Value value) {
        if (!range.open || double(value) != *range.open) return py::cast(value);
        return range.open_word ? py::object(py::str(range.open_word)) : py::none();
    }
    static Value write(const char* parameter, const Range& range, const py::object& given) {
        if (range.open && is_open(range, given)) return Value(*range.open);
        const std::string name = std::string(parameter) + " must be ";
        const char* kind = std::is_floating_point_v<Value> ? "a number" : "a whole number";
        // In Python, True is the number 1; as a parameter it is a mistake.
        if (py::isinstance<py::bool_>(given) || py::isinstance<py::str>(given))
            throw py::value_error(name + kind + got(given));
        double number = 0;
        // As a double first: a number of any size can then be compared with the range, and the error can say
        // what must hold.
        try {
            number = given.cast<double>();
        } catch (const py::cast_error&) {
            throw py::value_error(name + kind + got(given));
        }
        if (!range.holds(number))
            throw py::value_error(name + range.text_for(number, std::is_floating_point_v<Value>) +
                                  got(given));
        try {
            // Into the type itself, which refuses fractions for whole numbers and what exceeds its bits.
            return given.cast<Value>();
        } catch (const py::cast_error&) {
            if (number != std::floor(number)) throw py::value_error(name + kind + got(given));
            throw py::value_error(name + "in [" + Range::number(range.low) + ", 2^" +
                                  std::to_string(std::numeric_limits<Value>::digits) + ")" + got(given));
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
        // Open without a word of its own: None
        if (!range.open_word) return given.is_none();
        return py::isinstance<py::str>(given) && given.cast<std::string>() == range.open_word;
    }
};

template <>
struct PythonValue<bool> {
    static py::object read(const Range&, bool value) { return py::bool_(value); }
    static bool write(const char* parameter, const Range&, const py::object& given) {
        try {
            return given.cast<bool>();
        } catch (const py::cast_error&) {
            throw py::value_error(std::string(parameter) + " must be true or false" + got(given));
        }
    }
    static std::string kind(const Range&) { return "bool"; }
};

/// Closed sets: by name.
template <class Enum>
    requires std::is_enum_v<Enum>
struct PythonValue<Enum> {
    static py::object read(const Range&, Enum value) { return py::str(kNames<Enum>[size_t(value)]); }
    static Enum write(const char* parameter, const Range& range, const py::object& given) {
        return named<Enum>(parameter, py::str(given), range.high);
    }
    static std::string kind(const Range& range) {
        std::string all;
        for (const char* name : names_up_to<Enum>(range.high))
            all += (all.empty() ? "\"" : ", \"") + std::string(name) + "\"";
        return "{" + all + "}";
    }
};

template <class Row, class Struct>
using ValueOf = std::remove_cvref_t<decltype(std::declval<Struct>().*std::declval<Row>().member)>;

/// Sets the parameter of this name; false if there is none.
// Tables are tuples of different types: the row is found by comparing names, not by an index.
template <class Struct, class Table>
bool set_value(Struct& s, const Table& table, const std::string& name, const py::object& given) {
    bool known = false;
    for_each_row(table, [&]<class Row>(const Row& row) {
        if (name != row.name) return;
        known = true;
        s.*row.member = PythonValue<ValueOf<Row, Struct>>::write(row.name, row.range, given);
    });
    return known;
}

/// Name, kind, range, uses and doc of every row.
template <class Struct, class Table>
py::list row_dicts(const Table& table) {
    using namespace py::literals;
    py::list rows;
    for_each_row(table, [&]<class Row>(const Row& row) {
        rows.append(py::dict(
            "name"_a = row.name, "kind"_a = PythonValue<ValueOf<Row, Struct>>::kind(row.range),
            "low"_a = row.range.low, "high"_a = row.range.high, "above"_a = row.range.above,
            "keyed"_a = bool(row.use & kKeyed), "paper"_a = bool(row.use & kPaper), "doc"_a = row.doc));
    });
    return rows;
}

/// Constructor by keywords, one attribute per row and `parameter_rows`. Rows have no bindings of their own,
/// so that a new one needs no other change.
// The table lives as long as the program, so the functions refer to it.
template <class Struct, class... Options, class Table>
void bind_rows(py::class_<Struct, Options...>& c, const Table& table) {
    const std::string unknown = std::string(py::str(c.attr("__name__"))) + " has no parameter ";
    c.def(py::init([&table, unknown](const py::kwargs& keywords) {
        Struct made;
        // In the order in which they are given: the first wrong one raises.
        for (auto [key, value] : keywords)
            if (const std::string name = py::str(key);
                !set_value(made, table, name, py::reinterpret_borrow<py::object>(value)))
                throw py::value_error(unknown + name);
        // Ranges hold for each row; rules between rows are checked when all are set.
        made.validate();
        return made;
    }));
    // Instead of Python's own, which would take a misspelt name for a new attribute.
    c.def("__setattr__", [&table, unknown](Struct& s, const std::string& name, const AnyValue& value) {
        if (!set_value(s, table, name, value)) throw py::attribute_error(unknown + name);
    });
    // Called for names that nothing else has.
    c.def("__getattr__", [&table, unknown](const Struct& s, const std::string& name) {
        AnyValue found;
        bool known = false;
        for_each_row(table, [&]<class Row>(const Row& row) {
            if (name != row.name) return;
            known = true;
            found = py::object(PythonValue<ValueOf<Row, Struct>>::read(row.range, s.*row.member));
        });
        if (!known) throw py::attribute_error(unknown + name);
        return found;
    });
    c.def_static(
        "parameter_rows", [&table] { return row_dicts<Struct>(table); },
        "Name, kind, range, uses and doc of every parameter, as the C++ table has them.");
}

}  // namespace viscache::bindings
