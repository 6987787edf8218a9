#include "viscache/oracles/roulette_source.h"

#include "viscache/math/wall_clock.h"

namespace viscache {

namespace {

/// Source of the oracles of the small learning frame.
class LearningSource final : public OracleSource {
public:
    LearningSource(VoxelVisibility& map, const RayCaster& caster, VoxelJournal* journal)
        : map_(map), caster_(caster), journal_(journal) {}
    std::unique_ptr<VisibilityOracle> make() override {
        return std::make_unique<LearningOracle>(map_, caster_, journal_ ? &journal_->of_thread() : nullptr);
    }

private:
    VoxelVisibility& map_;
    const RayCaster& caster_;
    VoxelJournal* journal_;
};

const NeePlusPlusSettings& checked(const NeePlusPlusSettings& settings) {
    settings.validate();
    return settings;
}

}  // namespace

RouletteSource::RouletteSource(const Scene& scene, const RayCaster& caster,
                               const NeePlusPlusSettings& settings, const RouletteOptions& options)
    : caster_(caster),
      settings_(checked(settings)),
      options_(options),
      map_(options.keep ? options.keep->begin(scene.bounds(), settings)
                        : own_.emplace(scene.bounds(), settings)) {
    if (!options.correct) return;
    const MeanSettings& c = *options.correct;
    if (c.share && !(*c.share > 0 && *c.share <= 1))
        throw std::invalid_argument("share must be in (0, 1], got " + std::to_string(*c.share));
    if (!(c.certain > 0))
        throw std::invalid_argument("certain must be > 0, got " + std::to_string(c.certain));
}

// What a frame learns does not depend on its own random choices, so that it stays unbiased.
void RouletteSource::prepare(FrameStart& frame, Control& control) {
    const double start = wall_seconds();
    const bool later = options_.keep && options_.keep->frames() > 0;
    const int pixels = later ? settings_.relearn_pixels : settings_.learn_pixels;
    if (pixels > 0) {
        // The first frame's map is dropped as a whole if the frame is not finished
        LearningSource learning(map_, caster_, later ? &options_.keep->journal() : nullptr);
        learning_rays_ = frame.ask_small(size_t(pixels), learning, control).rays();
    }
    learning_s_ = wall_seconds() - start;
}

std::unique_ptr<VisibilityOracle> RouletteSource::make() {
    if (options_.correct) return std::make_unique<MeanOracle>(map_, caster_, *options_.correct);
    return std::make_unique<RouletteOracle>(map_, caster_, options_.seed, options_.weighted);
}

void RouletteSource::report(Counters& counters, SourceReport& out) const {
    // Every query was traced or discarded; the sum of the frame includes the learning rays
    const uint64_t traced = counters.rays() - learning_rays_;
    out.counters = {{"discarded", counters.queries() - traced},
                    {"learning_rays", learning_rays_},
                    {"voxel_pairs", map_.pairs_tested()},
                    {"map_bytes", map_.bytes()}};
    if (options_.correct) out.counters.emplace_back("corrections", counters.corrections);
    out.timings = {{"learning_s", learning_s_}};
}

}  // namespace viscache
