#include "viscache/visibility/roulette_source.h"

#include "viscache/math/wall_clock.h"

namespace viscache {

namespace {

/// Source of the oracles of the small learning frame.
class LearningSource final : public OracleSource {
public:
    LearningSource(VoxelVisibility& map, const RayCaster& caster, float extent)
        : map_(map), caster_(caster), extent_(extent) {}
    std::unique_ptr<VisibilityOracle> make() override {
        return std::make_unique<LearningOracle>(map_, caster_, extent_);
    }

private:
    VoxelVisibility& map_;
    const RayCaster& caster_;
    float extent_;
};

const NeePlusPlusSettings& checked(const NeePlusPlusSettings& settings) {
    settings.validate();
    return settings;
}

}  // namespace

RouletteSource::RouletteSource(const Scene& scene, const RayCaster& caster,
                               const NeePlusPlusSettings& settings, uint64_t seed, bool weighted)
    : caster_(caster),
      extent_(scene.offset_extent()),
      settings_(checked(settings)),
      seed_(seed),
      weighted_(weighted),
      map_(scene.bounds(), settings) {}

void RouletteSource::prepare(FrameStart& frame, Control& control) {
    const double start = wall_seconds();
    LearningSource learning(map_, caster_, extent_);
    learning_rays_ = frame.ask_small(size_t(settings_.learn_pixels), learning, control).rays();
    learning_s_ = wall_seconds() - start;
}

std::unique_ptr<VisibilityOracle> RouletteSource::make() {
    return std::make_unique<RouletteOracle>(map_, caster_, extent_, seed_, weighted_);
}

void RouletteSource::report(Counters& counters, SourceReport& out) const {
    // Every query was traced or discarded; the sum of the frame includes the learning rays
    const uint64_t traced = counters.rays() - learning_rays_;
    out.counters = {{"discarded", counters.queries() - traced},
                    {"learning_rays", learning_rays_},
                    {"voxel_pairs", map_.pairs_tested()},
                    {"map_bytes", map_.bytes()}};
    out.timings = {{"learning_s", learning_s_}};
}

}  // namespace viscache
