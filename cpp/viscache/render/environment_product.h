#pragma once
// Light of the environment by product sampling. Visibility maps serve as control variate where they exist.
#include "viscache/render/eye_paths.h"
#include "viscache/visibility/oracle_source.h"
#include "viscache/vismap/map_source.h"
#include "viscache/vismap/point_estimate.h"
#include "viscache/vismap/temporal.h"

namespace viscache {

/// How the density is chosen.
enum class DensityChoice { kAuto, kProduct, kGuided };
/// α of the first pass.
enum class FirstAlpha { kPilot, kOne };

template <>
inline constexpr std::array kNames<DensityChoice>{"auto", "product", "guided"};
template <>
inline constexpr std::array kNames<FirstAlpha>{"pilot", "one"};

/// What each is, and its range: kVisMapRows.
struct VisMapSettings {
    AlphaChoice alpha;
    FirstAlpha first_alpha = FirstAlpha::kPilot;
    DensityChoice sampling = DensityChoice::kAuto;
    double eta = 0.25;
    bool replace = false;  ///< J replaces the estimate; no rays are traced

    /// With the density of product sampling as lower bound, guiding has no effect.
    DensityChoice density() const { return eta == 1 ? DensityChoice::kProduct : sampling; }
    void validate() const;
};

// clang-format off
inline constexpr std::tuple kVisMapRows{
    row("alpha", &VisMapSettings::alpha,
        "Coefficient of the control variate. \"previous_pass\": by regression on the samples of all earlier "
        "passes of the pixel; in the first pass by `first_alpha`. \"loo\": by regression on the other samples "
        "of the pass, only for `Direct(points=\"independent\")`. \"one\": 1 as in the paper. \"zero\": product "
        "sampling alone."),
    row("first_alpha", &VisMapSettings::first_alpha,
        "α of the first pass with \"previous_pass\": by regression on the samples of a pilot on some pixels, "
        "or 1 as in the paper."),
    row("sampling", &VisMapSettings::sampling,
        "\"guided\": the dilated maps also shape the density. \"product\": as in the paper. \"auto\": guided if "
        "a pilot on some pixels predicts at least a tenth less variance."),
    row("eta", &VisMapSettings::eta, {.low = 0, .high = 1, .above = true},
        "Minimum of guided densities relative to product sampling; 1 is product sampling."),
};
// clang-format on

inline void VisMapSettings::validate() const { check_rows(kVisMapRows, *this); }

/// What all tiles share.
struct ProductContext {
    const EnvironmentPyramid& light;
    const IntegratorSettings& integrator;
    uint64_t seed;
    int frame_width;
    const MapSource* maps;  ///< nullptr: product sampling alone
    VisMapSettings settings;
    bool guided = false;  ///< for kAuto: the result of the pilot
};

/// CPU seconds of the steps, summed over threads.
struct ProductSeconds {
    double trees = 0, maps = 0, samples = 0, visibility = 0, finish = 0;
    void merge(const ProductSeconds& b) {
        trees += b.trees;
        maps += b.maps;
        samples += b.samples;
        visibility += b.visibility;
        finish += b.finish;
    }
};

/// Renders on one thread. Its buffers are reused.
class EnvironmentProduct {
public:
    explicit EnvironmentProduct(const ProductContext& context)
        : c_(context),
          read_(context.maps ? context.maps->reader() : MapReader()),
          tally_(context.maps ? context.maps->records : 0) {}

    /// Compares every ray of the tiles so far with each blended record, weighted as under product sampling.
    const RecordTally& tally() const { return tally_; }

    /// Adds the mean of all passes to `sum` and the last pass to `last`. Both hold the pixels of the tile.
    void add(const Tile& tile, const EyeTile& eyes, VisibilityOracle& oracle, std::span<Rgb> sum,
             std::span<Rgb> last, Counters& counters, ProductSeconds& seconds, const Control& control);

private:
    struct Slot {
        uint32_t eye;
        PointMoments moments;
        AlphaSums earlier;
        BlendedMaps maps;
    };
    void prepare(const Tile& tile, const EyeTile& eyes, Slot& slot, PointEstimate& point, Counters& counters);
    void compare_records();
    void draw(const EyeTile& eyes, size_t slot, const PointEstimate& point, int pass, Counters& counters);
    void finish(const EyeTile& eyes, int pass, std::span<Rgb> sum, std::span<Rgb> last, Counters& counters);

    const ProductContext& c_;
    MapReader read_;
    RecordTally tally_;
    std::vector<PointEstimate> points_;
    std::vector<Slot> slots_;
    std::vector<DirectionSample> samples_;  ///< n per slot
    std::vector<uint8_t> visible_;
    std::vector<ShadowQuery> queries_;
    std::vector<uint32_t> asked_;  ///< index of the sample of each query
};

/// Result of the pilot. It is independent of the samples of the frame.
struct Forecast {
    double alpha = 1;           ///< pooled regression coefficient under the chosen density
    double variance_ratio = 1;  ///< guided over product density
    bool guided = false;
};

/// Runs the pilot: some product samples on some pixels.
Forecast forecast(const ProductContext& context, const EyePathTracer& tracer, OracleSource& source,
                  int threads, Counters& counters, const Control& control);

}  // namespace viscache
