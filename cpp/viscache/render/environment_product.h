#pragma once
// The environment's light on a tile's eye points by product sampling, with visibility maps as control
// variate where there are any.
#include <optional>

#include "viscache/render/eye_paths.h"
#include "viscache/visibility/oracle_source.h"
#include "viscache/vismap/map_source.h"
#include "viscache/vismap/point_estimate.h"
#include "viscache/vismap/temporal.h"

namespace viscache {

/// How the density is chosen.
enum class DensityChoice {
    kProduct,  ///< light × reflection: the paper
    kGuided,   ///< shaped by dilated maps
    kAuto,     ///< guided if a trial on some pixels promises less variance
};

struct VisMapSettings {
    AlphaChoice alpha;
    bool pilot_alpha = true;  ///< previous_pass begins with the trial's α, not with alpha.value
    DensityChoice sampling = DensityChoice::kAuto;
    double eta = 0.25;     ///< floor of guided densities
    bool replace = false;  ///< J is the answer, without rays
};

/// What all tiles share.
struct ProductContext {
    const EnvironmentPyramid& light;
    const IntegratorSettings& integrator;
    uint64_t seed;
    int frame_width;
    const MapSource* maps;  ///< nullptr: product sampling alone
    VisMapSettings settings;
    bool guided = false;  ///< of kAuto: what the trial said
};

/// CPU seconds of the parts, summed over threads.
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

/// One thread's work; buffers are kept.
class EnvironmentProduct {
public:
    explicit EnvironmentProduct(const ProductContext& context)
        : c_(context),
          read_(context.maps ? context.maps->reader() : MapReader()),
          tally_(context.maps ? context.maps->records : 0) {}

    /// Every ray of the tiles so far against what each blended record said, as under product sampling.
    const RecordTally& tally() const { return tally_; }

    /// Adds the mean of all passes to `sum`, and the last pass to `last`; both are the tile's pixels.
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
    std::vector<DirectionSample> samples_;  ///< n of every slot
    std::vector<uint8_t> visible_;
    std::vector<ShadowQuery> queries_;
    std::vector<uint32_t> asked_;  ///< sample of every query
    std::vector<Word> answer_;
};

/// What the trial on some pixels says: independent of the frame's own samples.
struct Forecast {
    double alpha = 1;           ///< pooled regression coefficient under the density of choice
    double variance_ratio = 1;  ///< guided over product density
    bool guided = false;
};

/// 16 product samples on up to 1024 pixels.
Forecast forecast(const ProductContext& context, const EyePathTracer& tracer, OracleSource& source,
                  int threads, Counters& counters, const Control& control);

}  // namespace viscache
