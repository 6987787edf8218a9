#pragma once
// Parameters of the visibility-map cache (Clarberg, Akenine-Möller 2008, here "VisMap"), one row each.
//
// What reads the rows: MapCacheParameters::validate, the binding, and the help of viscache.MapSettings.
#include <array>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "viscache/visibility/parameter_row.h"
#include "viscache/vismap/nearest_set.h"
#include "viscache/vismap/record.h"

namespace viscache {

/// Which weight is compared with w_min.
enum class WeightTest {
    kFull,        ///< w_g·ŵ, as blending uses it
    kNormalized,  ///< ŵ
    kRaw,         ///< w of Eq. 9
};
enum class SearchFilter {
    kDuring,  ///< the m nearest records with similar normals
    kAfter,   ///< of the m nearest records, those with similar normals
};
/// The purpose of records.
enum class Criterion {
    kVisibility,  ///< blending: weight and mean difference
    kAmbient,     ///< ambient occlusion: weight and the distance of the nearest hit
};
enum class InsertionMode {
    kBatch,   ///< the same records for any number of threads
    kLocked,  ///< as in the paper: threads take points in any order and share the tree through a lock
};
/// Which records are removed for errors at the end of a frame.
enum class Removal { kRate, kWilson, kWorst, kNone };

template <>
inline constexpr std::array kNames<WeightTest>{"full", "w_hat", "raw"};
template <>
inline constexpr std::array kNames<SearchFilter>{"during", "after"};
template <>
inline constexpr std::array kNames<Criterion>{"visibility", "ambient"};
template <>
inline constexpr std::array kNames<InsertionMode>{"batch", "locked"};
template <>
inline constexpr std::array kNames<Removal>{"rate", "wilson", "worst", "none"};

/// What each is, and its range: kMapRows.
struct MapCacheParameters {
    int m = 5;
    uint32_t n_startup = 1000;
    double d_max = 0.05;
    double theta_max_deg = 30;
    int n_best = 4;
    int m_nearest = 16;
    double lambda = 5;
    double w_min = -1;      ///< < 0: MapCache::set_thresholds
    double delta_max = -1;  ///< < 0: the same
    double r_min_px = 2;
    uint32_t max_records = 1u << 20;
    WeightTest weight_test = WeightTest::kFull;
    SearchFilter filter = SearchFilter::kDuring;
    Criterion criterion = Criterion::kVisibility;
    InsertionMode mode = InsertionMode::kBatch;
    uint32_t batch = 4096;
    bool repeat_passes = true;
    Removal removal = Removal::kRate;
    double eps_max = 0.05;
    uint32_t min_rays = 64;
    uint32_t k_worst = 0;
    uint32_t unused_frames = 10;
    uint64_t seed = 0;

    float theta_max_rad() const { return float(theta_max_deg * (std::numbers::pi / 180)); }
    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
};

// clang-format off
/// Everything that is said of the parameters, but their defaults.
inline constexpr std::tuple kMapRows{
    row("m", &MapCacheParameters::m, {.low = kMinMapLog2, .high = kMaxMapLog2},
        "M: maps have 2^m x 2^m cells; a record takes 76, 172, 572 or 2172 bytes."),
    row("n_startup", &MapCacheParameters::n_startup, {.low = 1, .high = 1 << 24},
        "Number of start-up records, at first hits distributed over the image."),
    row("d_max", &MapCacheParameters::d_max, {.low = 0, .high = 1000, .above = true},
        "Search radius for records as a fraction of the image width, measured by the size of a pixel at the "
        "point; at most a tenth of the scene's diagonal."),
    row("theta_max_deg", &MapCacheParameters::theta_max_deg, {.low = 0, .high = 180, .above = true},
        "Records are used only if their normal differs by less."),
    row("n_best", &MapCacheParameters::n_best, {.low = 1, .high = kMaxBlended},
        "Maximum number of blended records."),
    row("m_nearest", &MapCacheParameters::m_nearest, {.low = 1, .high = NearestSet::kMost},
        "Number of nearest records from which they are chosen; at least `n_best`."),
    row("lam", &MapCacheParameters::lambda, {.low = 0, .high = 1e6},
        "λ of Eq. 9."),
    row("w_min", &MapCacheParameters::w_min, {.low = 0, .high = 1, .open = -1, .open_word = nullptr},
        "A point gets a record if no record in reach has this weight. By default as the preset says."),
    row("delta_max", &MapCacheParameters::delta_max, {.low = 0, .high = 1, .open = -1, .open_word = nullptr},
        "A point gets a record if the mean difference of the blended maps is larger (Eq. 11). By default as "
        "the preset says."),
    row("r_min_px", &MapCacheParameters::r_min_px, {.low = 0, .high = 1e6},
        "If a record is nearer than this, in footprints of a pixel, differing maps do not cause a new one."),
    row("max_records", &MapCacheParameters::max_records, {.low = 1, .high = 1 << 26},
        "Maximum number of records in the cache."),
    row("weight_test", &MapCacheParameters::weight_test,
        "The weight compared with `w_min`: w_g·ŵ, ŵ, or w of Eq. 9."),
    row("filter", &MapCacheParameters::filter,
        "Test normals during the search for the nearest records, or after it."),
    row("criterion", &MapCacheParameters::criterion,
        "\"ambient\": records for ambient occlusion. There are more of them near surfaces, and maps may "
        "differ. Their rays find the nearest hit."),
    row("mode", &MapCacheParameters::mode,
        "\"batch\": the same records for any number of threads. \"locked\": a read-write lock, as in the "
        "paper."),
    row("batch", &MapCacheParameters::batch, {.low = 1, .high = 1 << 30},
        "Number of pixels that are looked up together."),
    row("repeat_passes", &MapCacheParameters::repeat_passes,
        "True: repeat passes over the image until no pixel needs a record. False: a single pass, as in the "
        "paper."),
    row("removal", &MapCacheParameters::removal,
        "Records removed at the end of a frame. \"rate\": those whose error rate exceeds `eps_max`. "
        "\"wilson\": those for which the lower end of its 95 % interval does. \"worst\": the `k_worst` with "
        "the highest error rates."),
    row("eps_max", &MapCacheParameters::eps_max, {.low = 0, .high = 1},
        "ε_max: maximum error rate."),
    row("min_rays", &MapCacheParameters::min_rays, {.low = 0},
        "Records compared with fewer rays are kept."),
    row("k_worst", &MapCacheParameters::k_worst, {.low = 0},
        "Number of records that removal \"worst\" removes."),
    row("unused_frames", &MapCacheParameters::unused_frames, {.low = 0},
        "Records that no pixel used for this many frames are removed; 0: never."),
    row("seed", &MapCacheParameters::seed, {.low = 0},
        "Seed of the directions of the maps and of the start-up rays."),
};
// clang-format on

inline void MapCacheParameters::validate() const {
    check_rows(kMapRows, *this);
    detail::require(
        m_nearest >= n_best,
        "m_nearest must be in [" + std::to_string(n_best) + ", " + std::to_string(NearestSet::kMost) + "]",
        m_nearest);
    detail::require(removal != Removal::kWorst || k_worst > 0, "k_worst must be > 0 with removal=\"worst\"",
                    k_worst);
}

}  // namespace viscache
