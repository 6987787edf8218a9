#pragma once
// One row per parameter of the quantized cache: its name, range and meaning, and whether keys depend on it.
//
// What reads the rows: the checks of AqvcParameters::validate, the binding, the tables kept over frames
// (AqvcTable) and the help of viscache.Aqvc and viscache.PaperForm. Defaults are those of AqvcParameters.
#include <array>
#include <bit>
#include <charconv>
#include <concepts>
#include <limits>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>

#include "viscache/aqvc/parameters.h"

namespace viscache {

/// Names of a closed set, in the order of its enumerators.
template <class Enum>
inline constexpr std::array<const char*, 0> kNames{};
template <>
inline constexpr std::array kNames<NormalMode>{"round", "floor", "octahedral", "single"};
template <>
inline constexpr std::array kNames<ResolutionRule>{"eq7", "eq6"};
template <>
inline constexpr std::array kNames<EnvironmentRule>{"derived", "printed"};
template <>
inline constexpr std::array kNames<CellDensity>{"light", "mixture"};
template <>
inline constexpr std::array kNames<VplKey>{"point", "surface"};
template <>
inline constexpr std::array kNames<Refinement>{"auto", "on", "off"};
template <>
inline constexpr std::array kNames<LevelRule>{"finest", "log2"};
template <>
inline constexpr std::array kNames<HashScheme>{"scheme2", "scheme1", "scheme1_mixed"};
template <>
inline constexpr std::array kNames<PixelOrder>{"hm", "scanline", "random"};
template <>
inline constexpr std::array kNames<Form>{"waves", "pairs"};
template <>
inline constexpr std::array kNames<Storage>{"table", "exact", "shared", "paper_tiles"};

/// What a number may be.
struct Range {
    static constexpr double kAny = std::numeric_limits<double>::infinity();
    double low = -kAny, high = kAny;
    bool above = false;  ///< low itself is not in it
    bool even = false;
    bool by_side = false;  ///< errors name the end that was passed alone

    bool holds(double v) const {
        const bool past_low = above ? v > low : v >= low;
        return past_low && v <= high && std::abs(v) < kAny && !(even && std::fmod(v, 2) != 0);
    }
    /// "in [1, 64]", "> 0": as errors and the help say it.
    std::string text() const {
        if (low > -kAny && high < kAny)
            return (even ? "even and in [" : "in [") + number(low) + ", " + number(high) + "]";
        if (low > -kAny) return (above ? "> " : ">= ") + number(low);
        return "";
    }
    /// What must hold of v, which does not fit.
    std::string text_for(double v) const {
        if (!by_side) return text();
        return v < low ? ">= " + number(low) : "<= " + number(high);
    }
    /// The shortest text of a number; large powers of two as 2^k.
    static std::string number(double v) {
        if (v >= 0x1p20 && v < 0x1p63 && std::has_single_bit(uint64_t(v)))
            return "2^" + std::to_string(std::countr_zero(uint64_t(v)));
        std::array<char, 32> text{};
        return {text.data(), std::to_chars(text.data(), text.data() + text.size(), v).ptr};
    }
};

/// Of a row: the cells that one C_E gives, or keys, or what is kept under them, depend on the parameter; it
/// belongs to viscache.PaperForm.
enum ParameterUse : unsigned { kPlain = 0, kKeyed = 1, kPaper = 2 };

template <class Value>
struct ParameterRow {
    const char* name;
    Value AqvcParameters::* member;
    Range range;
    unsigned use;
    const char* doc;
};

template <class Value>
constexpr ParameterRow<Value> row(const char* name, Value AqvcParameters::* member, unsigned use, Range range,
                                  const char* doc) {
    return {name, member, range, use, doc};
}
template <class Value>
constexpr ParameterRow<Value> row(const char* name, Value AqvcParameters::* member, unsigned use,
                                  const char* doc) {
    return {name, member, {}, use, doc};
}

// clang-format off
inline constexpr std::tuple kParameterRows{
    row("c_e", &AqvcParameters::c_e, kPlain, {.low = 0, .above = true},
        "C_E: a cluster spans about C_E × C_E eye samples. The error knob."),
    row("c_e_groups", &AqvcParameters::c_e_groups, kPlain,
        "C_E of single light groups: point, directional, area, environment, vpl, ambient; of `Bdpt` also "
        "connection (two surfaces) and camera."),
    row("c_l", &AqvcParameters::c_l, kKeyed, {.low = 1e-3, .high = 1e3},
        "C_L: a cluster spans about C_L × C_L light samples at its far end (Eq. 7 and 9), where that is a "
        "surface or the sky; 1 in the paper. Below 1: finer light cells, for an error of the sky or of area "
        "lights that C_E does not bring down. Not with res_rule \"eq6\", whose C_E is that of both ends."),
    row("c_n", &AqvcParameters::c_n, kKeyed, {.low = 1, .high = 64, .by_side = true},
        "C_N: normal bins per axis (Eq. 4)."),
    row("c_z", &AqvcParameters::c_z, kKeyed, {.low = 0.01, .high = 1024},
        "C_Z: cells are this much thinner along the normal. The paper: 8."),
    row("c_r", &AqvcParameters::c_r, kKeyed, {.low = 1.001, .high = 16},
        "C_R: ratio of the ladder of resolutions (Eq. 8). With `Bdpt` 2 unless given."),
    row("scale_free", &AqvcParameters::scale_free, kKeyed,
        "Cells are C_R^k units of length wide and count from the origin, instead of dividing the scene's "
        "bounding sphere: they stay the same when the scene grows or moves. With `keep` true unless given."),
    row("grid_seed", &AqvcParameters::grid_seed, kKeyed, {.low = 0},
        "Another shift of the grids per number, and another random order."),
    row("refinement", &AqvcParameters::refinement, kPlain,
        "Alg. 2: cells that disagree with a neighbour are asked again, smaller. \"auto\": for point, "
        "directional and VPL groups unless C_E² <= spp; with `Bdpt` off unless given."),
    row("refinement_groups", &AqvcParameters::refinement_groups, kPlain,
        "The same for single light groups, named as in `c_e_groups`."),
    row("level_step", &AqvcParameters::level_step, kPlain, {.low = 1.1},
        "Ratio of C_E from one level of refinement to the next."),
    row("c_finest", &AqvcParameters::c_finest, kPlain, {.low = 0, .above = true},
        "C_E of the finest level of refinement."),
    row("by_contribution", &AqvcParameters::by_contribution, kPlain,
        "C_E of each connection by what it would carry unoccluded, f: C_E·(mean f / f)^(1/2.5), from 2·C_E "
        "down. Only where refinement is on and in the form \"waves\"; others ignore it."),
    row("table_bytes", &AqvcParameters::table_bytes, kPlain, {.low = 4, .high = 0x1p33, .by_side = true},
        "Size of the table: of one tile; with `Bdpt` of the frame, 256 MiB unless given. Bit rows of samples "
        "of each pixel's own take up to 16 times that before the table steps in."),
    row("form", &AqvcParameters::form, kPaper,
        "How groups of shared lights run: level waves, or one query at a time through the table (Alg. 2). "
        "Samples of each pixel's own go through rows of bits by light cell, or with \"pairs\" through the "
        "table."),
    row("storage", &AqvcParameters::storage, kPaper,
        "The lossy table of Sec. 4.1, or a map of full keys. With `Bdpt` all threads share one, which takes "
        "up what was traced between rounds of work: the same values for any number of threads. \"shared\", "
        "with `Bdpt` alone: threads read and write it at once; which of a cluster's segments is traced is "
        "chance. \"paper_tiles\", without `Bdpt`: tiles of 32² pixels dealt out to the threads, each of which "
        "keeps its table over all of its own, as the paper does on the CPU; the same bytes for the same "
        "number of threads alone."),
    row("batch", &AqvcParameters::batch, kPaper, {.low = 0},
        "Eye points that are processed together; 0: 1024, 1: one query at a time."),
    row("queue", &AqvcParameters::queue, kPaper, {.low = 0, .high = 1024, .even = true},
        "Of the table, instead of batches: length of the queue of postponed rays (Sec. 4.4). Half as many "
        "queries look up their values at a time, a warp; when more than half of it is taken, its first half "
        "is traced. 0: no queue; the paper: 64."),
    row("c_w", &AqvcParameters::c_w, kPaper, {.low = 1, .high = 1024},
        "C_W: where at least so many rays of a warp are missing, they are traced at once."),
    row("order", &AqvcParameters::order, kPaper,
        "Processing order of the form \"pairs\": Halton–Morton (Sec. 4.3) or comparisons."),
    row("c_pg", &AqvcParameters::c_pg, kPaper, {.low = 1.1},
        "C_PG: growth of the order's segments."),
    row("hash", &AqvcParameters::hash, kKeyed | kPaper,
        "Hash of the table (Eq. 10). Scheme 1 collides on point lights; kept to show that."),
    row("digest_bits", &AqvcParameters::digest_bits, kKeyed | kPaper, {.low = 1, .high = 31},
        "Bits of the digest beside the visibility bit."),
    row("normal_mode", &AqvcParameters::normal_mode, kKeyed | kPaper,
        "Bins of normals: to the nearest on a cube's lattice, or down (the paper); about as many on the "
        "octahedral map; or one grid for all normals, which lets light through thin walls."),
    row("grid_offset", &AqvcParameters::grid_offset, kKeyed | kPaper,
        "Shift the grids by irrational amounts, so that no plane lies on a cell face."),
    row("tangent_neighbours", &AqvcParameters::tangent_neighbours, kPaper,
        "Neighbour cells follow the tangent plane instead of keeping v_z."),
    row("res_rule", &AqvcParameters::res_rule, kKeyed | kPaper,
        "Cells of connections of two surfaces: Eq. 7, or Eq. 6; with `Bdpt` Eq. 6 unless given."),
    row("env_rule", &AqvcParameters::env_rule, kKeyed | kPaper,
        "Eq. 9 with 4π on the right side, or as printed."),
    row("cell_density", &AqvcParameters::cell_density, kKeyed | kPaper,
        "Density that the light cells of samples of each pixel's own follow: of all techniques together, "
        "which differs between pixels where the BRDF is sampled too, or of light sampling alone, so that all "
        "pixels have the same cells: fewer rays, more error."),
    row("vpl_key", &AqvcParameters::vpl_key, kKeyed | kPaper,
        "One column per VPL, or VPLs quantised as surface points."),
    row("level_rule", &AqvcParameters::level_rule, kPaper,
        "Levels C_E, C_E/level_step … down to c_finest, or max(1, ceil(log2 C_E)) of them."),
};
// clang-format on

template <class Visit>
constexpr void for_each_parameter(Visit visit) {
    std::apply([&](const auto&... rows) { (visit(rows), ...); }, kParameterRows);
}

/// Throws std::invalid_argument unless the value is in the row's range.
template <class Row, class Value>
void check_parameter(const Row& row, const Value& value) {
    const std::string must = std::string(row.name) + " must be ";
    if constexpr (std::same_as<Value, std::array<double, kLightGroups>>) {
        for (double v : value) detail::require(std::isfinite(v), must + "finite", v);
    } else if constexpr (std::is_arithmetic_v<Value> && !std::same_as<Value, bool>) {
        const bool of_reals = std::is_floating_point_v<Value> && !(row.range.high < Range::kAny);
        detail::require(row.range.holds(double(value)),
                        must + row.range.text_for(double(value)) + (of_reals ? " and finite" : ""), value);
    }
}

}  // namespace viscache
