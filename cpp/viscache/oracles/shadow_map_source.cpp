#include "viscache/oracles/shadow_map_source.h"

#include "viscache/math/wall_clock.h"

namespace viscache {

ShadowMapSource::ShadowMapSource(const Scene& scene, const RayCaster& caster,
                                 const ShadowMapSettings& settings)
    : caster_(caster), extent_{scene.center(), scene.radius()}, settings_(settings) {
    settings_.validate();
}

void ShadowMapSource::prepare(FrameStart& frame, Control& control) {
    const double start = wall_seconds();
    // Shared directions of the sky are samples, not lights, and have no maps
    std::vector<const FarEnds*> with_maps;
    for (const FarEnds* lights : frame.lights()) {
        const auto group = LightGroup(lights->group);
        if (group == LightGroup::kPoint || group == LightGroup::kDirectional ||
            (group == LightGroup::kVpl && settings_.vpls))
            with_maps.push_back(lights);
    }
    maps_.emplace(caster_, extent_, settings_, with_maps, frame.threads(), control);
    maps_s_ = wall_seconds() - start;
}

std::unique_ptr<VisibilityOracle> ShadowMapSource::make() {
    return std::make_unique<ShadowMapOracle>(*maps_, caster_);
}

void ShadowMapSource::report(Counters& counters, SourceReport& out) const {
    for (int g = 0; g < kLightGroups; ++g) counters.group(g).rays += maps_->rays(g);
    out.counters = {{"shadow_maps", maps_->maps()},
                    {"shadow_map_rays", maps_->rays()},
                    {"shadow_map_bytes", maps_->bytes()}};
    out.timings = {{"shadow_maps_s", maps_s_}};
}

}  // namespace viscache
