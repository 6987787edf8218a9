#pragma once
// One row per parameter of a method: name, member, range and meaning. Checks, bindings and the help use the
// rows.
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>

namespace viscache {

namespace detail {
template <class Value>
void require(bool holds, const std::string& what, Value given) {
    if (!holds) throw std::invalid_argument(what + ", got " + std::to_string(given));
}
}  // namespace detail

/// Names of the values of an enumeration, in the order of its enumerators.
template <class Enum>
inline constexpr std::array<const char*, 0> kNames{};

/// The values that a number can have. Of an enumeration only `high` counts: its last enumerator allowed.
struct Range {
    static constexpr double kAny = std::numeric_limits<double>::infinity();
    double low = -kAny, high = kAny;
    bool above = false;  ///< `low` is excluded
    bool even = false;
    bool by_side = false;             ///< errors state only the limit that was exceeded
    std::optional<double> open = {};  ///< stands for "chosen by the program"; usually outside of the range
    const char* open_word = "auto";   ///< what Python writes for it; nullptr: None

    bool holds(double v) const {
        const bool past_low = above ? v > low : v >= low;
        return past_low && v <= high && std::abs(v) < kAny && !(even && std::fmod(v, 2) != 0);
    }
    /// The range as text for errors and the help: "in [1, 64]", "> 0".
    std::string text() const {
        if (low > -kAny && high < kAny)
            return std::string(even ? "even and in " : "in ") + (above ? "(" : "[") + number(low) + ", " +
                   number(high) + "]";
        if (low > -kAny) return (above ? "> " : ">= ") + number(low);
        return "";
    }
    /// The condition that v violates. For real numbers without an upper limit it includes "and finite".
    std::string text_for(double v, bool real) const {
        if (by_side) return v < low ? ">= " + number(low) : "<= " + number(high);
        return text() + (real && !(high < kAny) ? " and finite" : "");
    }
    /// The shortest text of a number; large powers of two as 2^k.
    static std::string number(double v) {
        if (v >= 0x1p20 && v < 0x1p63 && std::has_single_bit(uint64_t(v)))
            return "2^" + std::to_string(std::countr_zero(uint64_t(v)));
        std::array<char, 32> text{};
        const bool whole = v == std::floor(v) && std::abs(v) < 1e15;
        const auto format = whole ? std::chars_format::fixed : std::chars_format::general;
        return {text.data(), std::to_chars(text.data(), text.data() + text.size(), v, format).ptr};
    }
};

/// Further properties of a parameter. kKeyed: the cells for one C_E, the keys, or the values stored under
/// them depend on it. kPaper: it exists only for the form of the paper (viscache.PaperForm).
enum ParameterUse : unsigned { kPlain = 0, kKeyed = 1, kPaper = 2 };

template <class Struct, class Value>
struct ParameterRow {
    const char* name;
    Value Struct::* member;
    unsigned use;
    Range range;
    const char* doc;

    /// Throws std::invalid_argument if the number is neither in range nor open. Does nothing for values that
    /// are not numbers.
    void check(const Struct& parameters) const {
        if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
            const Value value = parameters.*member;
            if (range.open && double(value) == *range.open) return;
            detail::require(range.holds(double(value)), must(double(value)), value);
        }
    }
    /// The error message for a number that is refused.
    std::string must(double value) const {
        return std::string(name) + " must be " + range.text_for(value, std::is_floating_point_v<Value>);
    }
};

template <class Struct, class Value>
constexpr ParameterRow<Struct, Value> row(const char* name, Value Struct::* member, unsigned use, Range range,
                                          const char* doc) {
    return {name, member, use, range, doc};
}
template <class Struct, class Value>
constexpr ParameterRow<Struct, Value> row(const char* name, Value Struct::* member, unsigned use,
                                          const char* doc) {
    return {name, member, use, {}, doc};
}
template <class Struct, class Value>
constexpr ParameterRow<Struct, Value> row(const char* name, Value Struct::* member, Range range,
                                          const char* doc) {
    return {name, member, kPlain, range, doc};
}
template <class Struct, class Value>
constexpr ParameterRow<Struct, Value> row(const char* name, Value Struct::* member, const char* doc) {
    return {name, member, kPlain, {}, doc};
}

/// Calls `visit` with every row of a table.
template <class... Rows, class Visit>
constexpr void for_each_row(const std::tuple<Rows...>& table, Visit visit) {
    std::apply([&](const auto&... rows) { (visit(rows), ...); }, table);
}

/// Throws std::invalid_argument unless every number is in the range of its row.
template <class... Rows, class Struct>
void check_rows(const std::tuple<Rows...>& table, const Struct& parameters) {
    for_each_row(table, [&](const auto& row) { row.check(parameters); });
}

}  // namespace viscache
