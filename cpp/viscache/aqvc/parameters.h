#pragma once
// Parameters of the quantized cache (Popov, Georgiev, Slusallek, Dachsbacher 2013, here "AQVC"), one row
// each.
//
// The rows are read by AqvcParameters::validate, the bindings, kept tables (AqvcTable) and the help of
// viscache.Aqvc and viscache.PaperForm.
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "viscache/visibility/oracle.h"
#include "viscache/visibility/parameter_row.h"

namespace viscache {

enum class NormalMode { kRound, kFloor, kOctahedral, kSingle };
enum class EnvironmentRule { kDerived, kPrinted };
enum class CellDensity { kLight, kMixture };
enum class VplKey { kPoint, kSurface };
enum class Refinement { kAuto, kOn, kOff };
enum class HashScheme { kScheme2, kScheme1, kScheme1Mixed };
enum class PixelOrder { kHaltonMorton, kScanline, kRandom };
enum class Form { kWaves, kPairs };
enum class Storage { kTable, kExact, kShared, kPaperTiles };

template <>
inline constexpr std::array kNames<NormalMode>{"round", "floor", "octahedral", "single"};
template <>
inline constexpr std::array kNames<EnvironmentRule>{"derived", "printed"};
template <>
inline constexpr std::array kNames<CellDensity>{"light", "mixture"};
template <>
inline constexpr std::array kNames<VplKey>{"point", "surface"};
template <>
inline constexpr std::array kNames<Refinement>{"auto", "on", "off"};
template <>
inline constexpr std::array kNames<HashScheme>{"scheme2", "scheme1", "scheme1_mixed"};
template <>
inline constexpr std::array kNames<PixelOrder>{"hm", "scanline", "random"};
template <>
inline constexpr std::array kNames<Form>{"waves", "pairs"};
template <>
inline constexpr std::array kNames<Storage>{"table", "exact", "shared", "paper_tiles"};

using RefinementByGroup = std::array<Refinement, kLightGroups>;

/// Meaning and range of each parameter, and whether keys depend on it: see kAqvcRows.
struct AqvcParameters {
    double c_e = 12;
    std::array<double, kLightGroups> c_e_groups{};  ///< c_e where <= 0
    double c_l = 1;
    int c_n = 8;
    double c_z = 4;
    double c_r = 1.2;
    bool scale_free = false;
    uint32_t grid_seed = 0;
    RefinementByGroup refinement{};               ///< auto
    std::optional<LightGroupSet> exact_groups{};  ///< empty: auto
    double level_step = 4;
    double c_finest = 4;  ///< 0: the levels of the paper
    bool by_contribution = false;
    double bright = 0;
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
    EnvironmentRule env_rule = EnvironmentRule::kDerived;
    CellDensity cell_density = CellDensity::kMixture;
    VplKey vpl_key = VplKey::kPoint;

    // A group may have its own C_E; others take that of the frame.
    double group_c_e(int group) const {
        const double own = c_e_groups[size_t(group)];
        return own > 0 ? own : c_e;
    }
    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
};

// clang-format off
/// Everything about the parameters except their defaults.
inline constexpr std::tuple kAqvcRows{
    row("c_e", &AqvcParameters::c_e, kPlain, {.low = 0, .above = true},
        "C_E: a cluster spans about C_E × C_E eye samples. A larger C_E traces fewer rays and has a larger "
        "error."),
    row("c_e_groups", &AqvcParameters::c_e_groups, kPlain,
        "C_E of single light groups: point, directional, area, environment, vpl, ambient. `Bdpt` adds "
        "connection (between two surfaces) and camera."),
    row("c_l", &AqvcParameters::c_l, kKeyed, {.low = 1e-3, .high = 1e3},
        "C_L: the far end of a cluster spans about C_L × C_L light samples (Eq. 7 and 9) if it is a "
        "surface or the sky. The paper uses 1. A value below 1 makes light cells finer, for errors of the "
        "sky or of area lights that do not fall with C_E. No effect with "
        "`Bdpt`, where C_E holds for both ends (Eq. 6)."),
    row("c_n", &AqvcParameters::c_n, kKeyed, {.low = 1, .high = 64, .by_side = true},
        "C_N: number of normal bins per axis (Eq. 4)."),
    row("c_z", &AqvcParameters::c_z, kKeyed, {.low = 0.01, .high = 1024},
        "C_Z: cells are thinner along the normal by this factor. The paper uses 8."),
    row("c_r", &AqvcParameters::c_r, kKeyed, {.low = 1.001, .high = 16},
        "C_R: ratio between neighbouring resolutions of the ladder (Eq. 8). `Bdpt` uses 2 unless a value "
        "is given."),
    row("scale_free", &AqvcParameters::scale_free, kKeyed | kPaper,
        "Cells are C_R^k units of length wide and start at the origin. Otherwise they divide the bounding "
        "sphere of the scene. Scale-free cells stay the same when the scene grows or moves. `keep` turns "
        "this on unless a value is given."),
    row("grid_seed", &AqvcParameters::grid_seed, kKeyed | kPaper, {.low = 0},
        "Seed of the shift of the grids and of the random processing order."),
    row("refinement", &AqvcParameters::refinement, kPlain,
        "Alg. 2: if a cell disagrees with a neighbour, its queries are repeated with smaller cells. "
        "\"auto\" is on for the groups point, directional and vpl unless C_E² <= spp and C_E <= c_finest. A "
        "mapping has the names of `c_e_groups`; other groups have \"auto\". `Bdpt` uses \"off\" unless a value "
        "is given."),
    row("exact_groups", &AqvcParameters::exact_groups, kPlain,
        "Light groups whose queries all get a ray, as with `Exact`. \"auto\": samples of area lights and of "
        "the sky where they are each eye point's own, and groups of at most 8 lights that all share "
        "(32 with `use=\"correct\"`). The form \"pairs\" and `Bdpt` have no such group by default."),
    row("level_step", &AqvcParameters::level_step, kPlain, {.low = 1.1},
        "Ratio between the C_E of one refinement level and that of the next. The first level, C_E itself, "
        "may lie nearer to the second."),
    row("c_finest", &AqvcParameters::c_finest, kPlain,
        {.low = 0, .above = true, .open = 0, .open_word = "log2"},
        "C_E of the finest refinement level. Levels go up from it by level_step as far as they are below "
        "C_E, which is the first level. \"log2\": C_E, C_E/level_step, …, as in the paper max(1, ceil(log2 "
        "C_E)) of them."),
    row("by_contribution", &AqvcParameters::by_contribution, kPlain,
        "C_E of each connection depends on its unoccluded contribution f: C_E·(mean f / f)^(1/2.5), at "
        "most 2·C_E. Needs refinement and the form \"waves\"; without effect elsewhere."),
    row("bright", &AqvcParameters::bright, kPlain, {.low = 0},
        "Connections with shared lights whose unoccluded contribution is above `bright` times the mean of "
        "their eye point get a ray of their own. Few connections carry much of the squared error. 0: none. "
        "Needs the form \"waves\"; without effect elsewhere."),
    row("table_bytes", &AqvcParameters::table_bytes, kPlain, {.low = 4, .high = 0x1p33, .by_side = true},
        "Size of the table of one tile. With `Bdpt` the size of the table of the frame, 256 MiB unless a "
        "value is given. Bit rows for samples of single pixels take up to 16 times this size; further "
        "samples use the table."),
    row("form", &AqvcParameters::form, kPaper,
        "How groups of shared lights are processed: in waves, level by level, or one query at a time "
        "through the table (Alg. 2). Samples of single pixels use bit rows by light cell, or the table "
        "with \"pairs\"."),
    row("storage", &AqvcParameters::storage, kPaper,
        "The lossy table of Sec. 4.1, or a map of full keys. With `Bdpt` all threads share one table, and "
        "new values are stored between rounds of work: the values are the same for any number of threads. "
        "\"shared\" (only with `Bdpt`): threads read and write at once, and which segment of a cluster is "
        "traced depends on timing. \"paper_tiles\" (not with `Bdpt`): as on the CPU in the paper, each "
        "thread processes fixed tiles of 32² pixels and keeps its table for all of them; the bytes depend "
        "on the number of threads."),
    row("batch", &AqvcParameters::batch, kPaper, {.low = 0},
        "Number of eye points that are processed together. 0: 1024. 1: one query at a time."),
    row("queue", &AqvcParameters::queue, kPaper, {.low = 0, .high = 1024, .even = true},
        "Length of the queue of postponed rays (Sec. 4.4), which replaces batches. A warp of half as many "
        "queries looks up its values at once. When the queue is more than half full, its first half is "
        "traced. 0: no queue. The paper uses 64."),
    row("c_w", &AqvcParameters::c_w, kPaper, {.low = 1, .high = 1024},
        "C_W: a warp with at least this many missing rays traces them at once."),
    row("order", &AqvcParameters::order, kPaper,
        "Processing order of the form \"pairs\": Halton–Morton (Sec. 4.3), or orders for comparison."),
    row("c_pg", &AqvcParameters::c_pg, kPaper, {.low = 1.1},
        "C_PG: growth factor of the segments of the order."),
    row("hash", &AqvcParameters::hash, kKeyed | kPaper,
        "Hash of the table (Eq. 10). Scheme 1 has collisions for point lights and is kept to show them."),
    row("digest_bits", &AqvcParameters::digest_bits, kKeyed | kPaper, {.low = 1, .high = 31},
        "Number of digest bits beside the visibility bit."),
    row("normal_mode", &AqvcParameters::normal_mode, kKeyed | kPaper,
        "Bins of normals: \"round\" to the nearest point of a lattice on a cube; \"floor\", as in the "
        "paper; \"octahedral\", about as many bins on the octahedral map; \"single\", one grid for all "
        "normals, which lets light through thin walls."),
    row("grid_offset", &AqvcParameters::grid_offset, kKeyed | kPaper,
        "Shift the grids by irrational amounts, so that no plane lies on a cell face."),
    row("tangent_neighbours", &AqvcParameters::tangent_neighbours, kPaper,
        "Neighbour cells follow the tangent plane instead of keeping v_z."),
    row("env_rule", &AqvcParameters::env_rule, kKeyed | kPaper,
        "Eq. 9 with 4π on the right side, or as printed."),
    row("cell_density", &AqvcParameters::cell_density, kKeyed | kPaper,
        "Density that sets the light cells for samples of single pixels. \"mixture\": of all sampling "
        "techniques; it differs between pixels if the BRDF is also sampled. \"light\": of light sampling "
        "only, so all pixels have the same cells, with fewer rays and a larger error."),
    row("vpl_key", &AqvcParameters::vpl_key, kKeyed | kPaper,
        "One column per VPL, or VPLs quantized as surface points."),
};
// clang-format on

inline void AqvcParameters::validate() const {
    check_rows(kAqvcRows, *this);
    for (double v : c_e_groups) detail::require(std::isfinite(v), "c_e_groups must be finite", v);
}

/// True if Alg. 2 refines the connections of this light group at `spp` samples per pixel. Auto: groups of
/// lights that all pixels share, unless clusters are smaller than a pixel (AQVC Sec. 3.6) and than those of
/// the finest level.
// Differs (A48): AQVC does not refine clusters that are smaller than a pixel. With 64 samples, C_E 8 would
// then err twice as much as C_E 9.
inline bool refines(const AqvcParameters& p, int group, int spp) {
    const Refinement chosen = p.refinement[size_t(group)];
    if (chosen != Refinement::kAuto) return chosen == Refinement::kOn;
    const auto g = LightGroup(group);
    const bool shared = g == LightGroup::kPoint || g == LightGroup::kDirectional || g == LightGroup::kVpl;
    const double c_e = p.group_c_e(group);
    // A cluster of C_E² eye samples lies inside a pixel if C_E² <= spp.
    return shared && ((p.c_finest > 0 && c_e > p.c_finest) || c_e * c_e > spp);
}

/// The parameters themselves, when they are valid.
inline const AqvcParameters& checked(const AqvcParameters& p) {
    p.validate();
    return p;
}

/// Shared lights of a group that are not worth a cache. With corrections it is more, because each of few
/// lights is a large part of the light of its eye points, and so its answers are checked often.
constexpr size_t kFewLights = 8, kFewCorrected = 32;

/// True if exact rays answer the queries between eye points and the `shared` lights of this group. Auto:
/// groups of few lights, because cells cost more than so few rays; and a small part of all lights that the
/// frame's eye points share, because lamps among virtual lights cause half of the error (docs/aqvc.md has
/// figures of both). `few`: kFewLights, or kFewCorrected where a share of the answers is traced as well.
inline bool answers_exactly(const AqvcParameters& p, int group, size_t shared, size_t shared_in_frame,
                            size_t few = kFewLights) {
    if (p.exact_groups) return p.exact_groups->test(size_t(group));
    // At most a sixteenth of all shared lights
    constexpr size_t kSmallPart = 16;
    return p.form == Form::kWaves && (shared <= few || shared * kSmallPart <= shared_in_frame);
}

/// The same for far ends that are each eye point's own. Auto: samples of area lights and skies. They hardly
/// repeat, so the cache saves little time and leaves squares.
inline bool answers_own_exactly(const AqvcParameters& p, int group) {
    if (p.exact_groups) return p.exact_groups->test(size_t(group));
    const auto g = LightGroup(group);
    return p.form == Form::kWaves && (g == LightGroup::kArea || g == LightGroup::kEnvironment);
}

/// C_E of every level from coarse to fine, at most kMaxLevels. The first is lift·C_E. The others are
/// c_finest and its products with powers of level_step, as far as they lie below the first. So a larger C_E
/// only puts coarser levels in front: its cells trace fewer rays and err more, and neither turns back.
// Differs (A12): AQVC halves C_E down to 1–2 eye samples. The default stops at 4 with steps of 4, which
// traces fewer rays for a larger error. c_finest 0 with level_step 2 gives the list of the paper, which gains
// a level at each power of 2.
inline std::vector<double> level_list(const AqvcParameters& p, int group, int spp, double lift = 1) {
    const double first = lift * p.group_c_e(group);
    std::vector<double> levels = {first};
    if (!refines(p, group, spp)) return levels;
    const size_t limit = size_t(kMaxLevels);
    if (p.c_finest <= 0) {
        // As many levels as max(1, ceil(log2 C_E)); with level_step 2, C_E is halved each time.
        for (double power = 2; power < first && levels.size() < limit; power *= 2)
            levels.push_back(levels.back() / p.level_step);
    } else {
        std::vector<double> from_fine;
        // From fine to coarse, so that adding a coarser level changes no finer one.
        for (double c = p.c_finest; c < first && from_fine.size() + 1 < limit; c *= p.level_step)
            from_fine.push_back(c);
        levels.insert(levels.end(), from_fine.rbegin(), from_fine.rend());
    }
    return levels;
}

}  // namespace viscache
