#pragma once
// Parameters of the quantized cache (Popov, Georgiev, Slusallek, Dachsbacher 2013, here "AQVC"), one row
// each.
//
// What reads the rows: AqvcParameters::validate, the binding, the tables kept over frames (AqvcTable) and the
// help of viscache.Aqvc and viscache.PaperForm.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "viscache/visibility/counters.h"
#include "viscache/visibility/parameter_row.h"

namespace viscache {

enum class NormalMode { kRound, kFloor, kOctahedral, kSingle };
enum class ResolutionRule { kEq7, kEq6 };
enum class EnvironmentRule { kDerived, kPrinted };
enum class CellDensity { kLight, kMixture };
enum class VplKey { kPoint, kSurface };
enum class Refinement { kAuto, kOn, kOff };
enum class LevelRule { kFinest, kLog2 };
enum class HashScheme { kScheme2, kScheme1, kScheme1Mixed };
enum class PixelOrder { kHaltonMorton, kScanline, kRandom };
enum class Form { kWaves, kPairs };
enum class Storage { kTable, kExact, kShared, kPaperTiles };

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

/// What each is, its range, and whether keys depend on it: kAqvcRows.
struct AqvcParameters {
    double c_e = 12;
    std::array<double, kLightGroups> c_e_groups{};  ///< <= 0: c_e
    double c_l = 1;
    int c_n = 8;
    double c_z = 4;
    double c_r = 1.2;
    bool scale_free = false;
    uint32_t grid_seed = 0;
    Refinement refinement = Refinement::kAuto;
    std::array<std::optional<Refinement>, kLightGroups> refinement_groups{};
    double level_step = 4;
    double c_finest = 4;
    bool by_contribution = false;
    uint64_t table_bytes = uint64_t{4} << 20;
    Form form = Form::kWaves;
    Storage storage = Storage::kTable;
    int batch = 0;
    int queue = 0;
    int c_w = 31;
    PixelOrder order = PixelOrder::kHaltonMorton;
    double c_pg = 3.7;
    HashScheme hash = HashScheme::kScheme2;
    int digest_bits = 31;
    NormalMode normal_mode = NormalMode::kRound;
    bool grid_offset = true;
    bool tangent_neighbours = true;
    ResolutionRule res_rule = ResolutionRule::kEq7;
    EnvironmentRule env_rule = EnvironmentRule::kDerived;
    CellDensity cell_density = CellDensity::kMixture;
    VplKey vpl_key = VplKey::kPoint;
    LevelRule level_rule = LevelRule::kFinest;

    double group_c_e(int group) const {
        const double own = c_e_groups[size_t(group)];
        return own > 0 ? own : c_e;
    }
    /// Throws std::invalid_argument that says what must hold and what was given.
    void validate() const;
};

// clang-format off
/// Everything that is said of the parameters, but their defaults.
inline constexpr std::tuple kAqvcRows{
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

inline void AqvcParameters::validate() const {
    check_rows(kAqvcRows, *this);
    for (double v : c_e_groups) detail::require(std::isfinite(v), "c_e_groups must be finite", v);
}

/// True if Alg. 2 refines the connections of this light group at `spp` samples per pixel. Auto: lights shared
/// by all pixels, unless clusters are smaller than a pixel anyway (AQVC Sec. 3.6).
inline bool refines(const AqvcParameters& p, int group, int spp) {
    const Refinement chosen = p.refinement_groups[size_t(group)].value_or(p.refinement);
    if (chosen != Refinement::kAuto) return chosen == Refinement::kOn;
    const auto g = LightGroup(group);
    const bool shared = g == LightGroup::kPoint || g == LightGroup::kDirectional || g == LightGroup::kVpl;
    const double c_e = p.group_c_e(group);
    return shared && c_e * c_e > spp;
}

/// C_E of every level, coarse to fine: c₀ = lift·C_E, then c / level_step down to c_finest. At most
/// kMaxLevels.
// Differs: AQVC halves C_E down to 1–2 eye samples; the default stops at 4 in steps of 4, which costs 1.7
// times fewer rays for 15 % more error. LevelRule::kLog2 with level_step 2 is the paper's list.
inline std::vector<double> level_list(const AqvcParameters& p, int group, int spp, double lift = 1) {
    std::vector<double> levels = {lift * p.group_c_e(group)};
    if (!refines(p, group, spp)) return levels;
    const size_t limit = size_t(kMaxLevels);
    if (p.level_rule == LevelRule::kLog2) {
        for (double power = 2; power < levels[0] && levels.size() < limit; power *= 2)
            levels.push_back(levels.back() / p.level_step);
    } else {
        while (levels.back() >= 2 * p.c_finest && levels.size() < limit)
            levels.push_back(std::max(p.c_finest, levels.back() / p.level_step));
    }
    return levels;
}

}  // namespace viscache
