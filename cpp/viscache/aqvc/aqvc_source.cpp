#include "viscache/aqvc/aqvc_source.h"

namespace viscache {

namespace {

constexpr int kPaperTile = 32;  // edge of a CPU tile in pixels (AQVC Sec. 4.4)

const AqvcParameters& checked(const AqvcParameters& p) {
    p.validate();
    return p;
}

}  // namespace

AqvcSource::AqvcSource(const Scene& scene, const RayCaster& caster, const AqvcParameters& parameters, int spp)
    : parameters_(checked(parameters)), scene_(scene), caster_(caster), spp_(spp) {}

int AqvcSource::dealt_tile_edge() const {
    return parameters_.storage == Storage::kPaperTiles ? kPaperTile : 0;
}

std::unique_ptr<VisibilityOracle> AqvcSource::make_audit(int group, const FarEnds* lights) {
    const bool exact =
        lights ? answers_exactly(parameters_, group, lights->count) : answers_own_exactly(parameters_, group);
    if (parameters_.form != Form::kWaves || exact) return nullptr;
    return std::make_unique<ExactOracle>(caster_, scene_.offset_extent());
}

std::unique_ptr<QuantizedCache> AqvcSource::make_cache(FrameTable* table) const {
    return std::make_unique<QuantizedCache>(caster_, parameters_, scene_.center(), scene_.radius(),
                                            scene_.offset_extent(), spp_, table);
}

std::unique_ptr<VisibilityOracle> KeptTableSource::make() {
    auto cache = make_cache();
    cache->use_kept(table_, checks_);
    return cache;
}

void KeptTableSource::report(Counters& c, SourceReport& out) const {
    out.counters = {{"reused_kept", c.reused_kept},   {"reused_fresh", c.reused_fresh},
                    {"checked_kept", c.checked_kept}, {"checked_fresh", c.checked_fresh},
                    {"wrong_kept", c.wrong_kept},     {"wrong_fresh", c.wrong_fresh}};
}

}  // namespace viscache
