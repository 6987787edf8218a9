#include "viscache/aqvc/aqvc_source.h"

#include "viscache/oracles/exact.h"

namespace viscache {

namespace {

constexpr int kPaperTile = 32;  // edge of a CPU tile in pixels (AQVC Sec. 4.4)

/// A frame whose only shared lights are those of the exact groups.
class ExactStart final : public FrameStart {
public:
    // The source of the exact groups prepares only what it will answer: a shadow map of a light of the cache
    // would be work for nothing.
    ExactStart(FrameStart& frame, const AqvcParameters& parameters, size_t shared, size_t few)
        : frame_(frame) {
        for (const FarEnds* lights : frame.lights())
            if (answers_exactly(parameters, lights->group, lights->count, shared, few))
                lights_.push_back(lights);
    }
    std::span<const FarEnds* const> lights() const override { return lights_; }
    size_t lights_per_point() const override { return frame_.lights_per_point(); }
    uint64_t eye_points() const override { return frame_.eye_points(); }
    int threads() const override { return frame_.threads(); }
    Counters ask_small(size_t pixels, OracleSource& source, Control& control) override {
        return frame_.ask_small(pixels, source, control);
    }

private:
    FrameStart& frame_;
    std::vector<const FarEnds*> lights_;
};

}  // namespace

AqvcSource::AqvcSource(const Scene& scene, const RayCaster& caster, const AqvcParameters& parameters, int spp,
                       OracleSource* exact)
    : parameters_(checked(parameters)), scene_(scene), caster_(caster), spp_(spp), exact_(exact) {}

void AqvcSource::prepare(FrameStart& frame, Control& control) {
    // The number of all shared lights decides which groups are small enough to be exact (`answers_exactly`).
    shared_in_frame_ = 0;
    for (const FarEnds* lights : frame.lights()) shared_in_frame_ += lights->count;
    if (!exact_) return;
    ExactStart start(frame, parameters_, shared_in_frame_, few_);
    exact_->prepare(start, control);
}

void AqvcSource::report(Counters& counters, SourceReport& out) const {
    if (exact_) exact_->report(counters, out);
}

int AqvcSource::dealt_tile_edge() const {
    // As in the paper, each thread has tiles of its own and keeps its table for all of them.
    return parameters_.storage == Storage::kPaperTiles ? kPaperTile : 0;
}

std::unique_ptr<QuantizedCache> AqvcSource::make_cache(FrameTable* table) const {
    // Without a source of its own, an exact group gets packets of rays.
    auto exact = exact_ ? exact_->make() : std::make_unique<ExactOracle>(caster_);
    return std::make_unique<QuantizedCache>(caster_, ExactAnswers{std::move(exact), shared_in_frame_, few_},
                                            parameters_, scene_.center(), scene_.radius(), spp_, table);
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

std::unique_ptr<VisibilityOracle> AqvcRowsSource::make() {
    auto cache = make_cache();
    cache->use_rows(rows_);
    return cache;
}

void AqvcRowsSource::report(Counters& counters, SourceReport& out) const {
    AqvcSource::report(counters, out);
    out.counters.emplace_back("kept_cells", rows_.cells());
    out.counters.emplace_back("kept_bytes", rows_.bytes());
    out.counters.emplace_back("tiles_not_kept", rows_.tiles_not_kept());
}

}  // namespace viscache
