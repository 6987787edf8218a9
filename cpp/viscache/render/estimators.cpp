#include "viscache/render/estimators.h"

#include <algorithm>

#include "viscache/render/glossy_sums.h"
#include "viscache/render/local_samples.h"
#include "viscache/render/tile_contributions.h"
#include "viscache/render/weighted_lights.h"

namespace viscache {

void PixelSums::begin(const FrameResult& frame, size_t pixels) {
    // What the frame lacks stays empty, which estimators ask instead of settings
    for (size_t g = 0; g < groups.size(); ++g) groups[g].assign(frame.groups[g].empty() ? 0 : pixels, {});
    last_pass.assign(frame.last_pass.empty() ? 0 : pixels, {});
    variance.assign(frame.variance.empty() ? 0 : pixels, {});
    unoccluded.assign(frame.unoccluded.empty() ? 0 : pixels, 0);
}

namespace {

constexpr size_t kEyesPerBatch = 256;       // largest number of eye points per batch of samples
constexpr size_t kPairsPerBatch = 1 << 16;  // bounds the queries of a batch
constexpr size_t kRowsPerCheck = 256;       // eye points between checks for an interrupt

/// Shows audits an answer of a light group. `source` has the contributions that were asked about.
template <class Source>
void note_answer(TileWork& work, const Answer& answer, int group, const Source& source) {
    // Exact answers need no audit. One answer that is not exact makes the group worth auditing
    if (answer.is_exact(group)) return;
    work.inexact.set(size_t(group));
    if (!work.sums.unoccluded.empty()) source.add_to(work.eyes.pixel, work.sums.unoccluded);
}

/// Lights that all eye points share: a block of queries for each group.
class SharedLightEstimator final : public Estimator {
public:
    explicit SharedLightEstimator(const FrameContext& frame)
        : picks_(size_t(frame.integrator.pick), frame.frame.seed) {}

    void add(TileWork& work, TileRecord& out) override {
        for (const SharedLights& lights : work.frame.shared) add_group(lights, work, out);
    }

private:
    void add_group(const SharedLights& lights, TileWork& work, TileRecord& out) {
        // The queries: connections that contribute, or those that the eye point picks of them
        const EyeTile& eyes = work.eyes;
        wanted_.reset(eyes.size(), lights.ends.count);
        picks_.begin(lights);
        for (size_t i = 0; i < eyes.size(); ++i) {
            if (i % kRowsPerCheck == 0) work.control.check();
            const ColumnRange asked = lights.ends.columns_of(eyes.block, i);
            // Black points keep an empty row: rows and eye points have the same numbers
            if (!is_black(eyes.shading[i]))
                out.counters.non_finite += wanted_row(lights, work.shade(i), asked, wanted_.row(i));
            // Called for black points too: picks have one entry per eye point
            picks_.add(work.shade(i), eyes, uint32_t(i), wanted_.row(i));
        }
        work.clock.lap(out.stages.contributions);
        // Their answer
        // Contributions are computed when an oracle or an audit asks for them; many never do
        const TileContributions contributions(lights, eyes, picks_, wanted_);
        const BlockAsk ask{eyes.block, lights.ends, wanted_, &contributions};
        const Answer answer = work.oracle.block(ask, out.counters);
        WeightedLights weighted(lights);
        work.clock.lap(out.stages.visibility);
        if (work.audit)
            work.audit->block(ask, answer, contributions, [&](size_t i, const Word* row) {
                // Weights of picks are part of a contribution; those of the oracle's answer are not
                return reflected(weighted.with(picks_.of(i), {}), work, i, row);
            });
        note_answer(work, answer, lights.ends.group, contributions);
        work.clock.lap(out.stages.audit);
        // The light of what is visible, and of each correction
        std::vector<Rgb>& sum = work.sums.groups[size_t(lights.ends.group)];
        for (size_t i = 0; i < eyes.size(); ++i) {
            if (i % kRowsPerCheck == 0) work.control.check();
            // The lights with the weights of this eye point, or as they are where it has none
            const SharedLights& counted = weighted.with(picks_.of(i), answer.weights_of(i));
            sum[eyes.pixel[i]] += reflected(counted, work, i, answer.bits->row(i));
            const std::span<const Correction> corrections = answer.corrections_of(i);
            if (corrections.empty()) continue;
            // Weights of corrections are complete: those of the answer have no part in them
            const SharedLights& once = weighted.with(picks_.of(i), {});
            for (const Correction& c : corrections) {
                // One column at a time, by the function that sums rows: a correction has the
                // contribution of the answer that it corrects
                one_.assign(wanted_.row_words(), 0);
                set_bit(one_.data(), c.column);
                const Rgb change = reflected(once, work, i, one_.data()) * c.weight;
                sum[eyes.pixel[i]] += change;
                work.sums.add_variance(eyes.pixel[i], change, c.share);
            }
        }
        work.clock.lap(out.stages.shading);
    }

    /// Light of the columns in `row` that eye point i sends to its pixel.
    static Rgb reflected(const SharedLights& lights, const TileWork& work, size_t i, const Word* row) {
        const ShadingPoint& sp = work.eyes.shading[i];
        // A diffuse surface has base/π for all lights, a lobe another value for each
        const Rgb light = sp.kind == MaterialKind::kGlossy
                              ? sum_row_glossy(lights, work.shade(i), sp, row)
                              : sum_row(lights, work.shade(i), row) * (sp.base * (1 / kPi));
        return work.eyes.throughput[i] * light;
    }

    TilePicks picks_;
    BitMatrix wanted_;
    std::vector<Word> one_;  ///< a row with one bit
};

/// A kind of samples that belong to single eye points.
struct SampleKind {
    Semantic semantic;
    LightGroup group;
    int most;  ///< samples of an eye point
    AddSamples* make;
    bool only_lobes = false;  ///< tiles without lobes have none
};

/// Samples of single eye points of one kind, in batches of eye points.
class SampleEstimator final : public Estimator {
public:
    explicit SampleEstimator(const SampleKind& kind) : kind_(kind) {}

    void add(TileWork& work, TileRecord& out) override {
        const EyeTile& eyes = work.eyes;
        // Most tiles of most scenes have no lobes; an empty call of the oracle is not free
        if (kind_.only_lobes && !std::ranges::any_of(eyes.shading, has_lobe)) return;
        // Batches follow the order and the runs that suit the oracle
        const int group = int(kind_.group);
        const PairOrder order = work.oracle.order(eyes.block, group);
        // Batches bound memory, and are large enough that a cache finds queries of the same cell
        // together
        const size_t most = std::clamp<size_t>(kPairsPerBatch / size_t(kind_.most), 1, kEyesPerBatch);
        size_t run = 0;
        for (size_t first = 0; first < eyes.size();) {
            work.control.check();
            const size_t last =
                run < order.run_end.size() ? order.run_end[run++] : std::min(first + most, eyes.size());
            samples_.begin(kind_.semantic, kind_.group);
            for (size_t i = first; i < last; ++i)
                // In the order of the oracle if it has one, otherwise along the tile's curve
                kind_.make(work.frame, eyes, order.eye.empty() ? uint32_t(i) : order.eye[i], samples_,
                           out.counters);
            work.clock.lap(out.stages.contributions);
            const Answer answer = work.oracle.pairs(
                {.eyes = eyes.block, .samples = &samples_.at, .contributions = samples_.contribution},
                out.counters);
            work.clock.lap(out.stages.visibility);
            if (work.audit) work.audit->samples(samples_, answer);
            note_answer(work, answer, group, samples_);
            work.clock.lap(out.stages.audit);
            add_seen(answer, eyes.pixel, work.sums);
            work.clock.lap(out.stages.shading);
            first = last;
        }
    }

private:
    /// Adds the contributions of visible samples. Their weights include the corrections.
    void add_seen(const Answer& answer, std::span<const uint32_t> pixel_of, PixelSums& sums) const {
        std::vector<Rgb>& sum = sums.groups[size_t(kind_.group)];
        const LocalSamples& at = samples_.at;
        size_t row = 0;
        for_each_bit(answer.row(0), [&](size_t i) {
            // Bits come in ascending order, so the row only goes forward
            while (at.end[row] <= i) ++row;
            const Rgb value = samples_.contribution[i];
            sum[pixel_of[at.eye[row]]] += answer.weights.empty() ? value : value * answer.weights[i];
        });
        row = 0;
        // Corrections are in the weights already; what is left is their variance
        for (const Correction& c : answer.corrections) {
            while (at.end[row] <= c.column) ++row;
            sums.add_variance(pixel_of[at.eye[row]], samples_.contribution[c.column] * c.weight, c.share);
        }
    }

    SampleKind kind_;
    WeightedSamples samples_;
};

/// Ambient occlusion along shared directions, whose rays were traced before the tiles.
class AlignedAmbientEstimator final : public Estimator {
public:
    void add(TileWork& work, TileRecord&) override {
        const float* share = work.frame.shares->share.data() + work.frame.shares->first[work.number];
        std::vector<Rgb>& sum = work.sums.groups[size_t(LightGroup::kAmbient)];
        for (size_t i = 0; i < work.eyes.size(); ++i)
            sum[work.eyes.pixel[i]] += work.eyes.throughput[i] * share[i];
    }
};

/// Product sampling of the environment.
class ProductEstimator final : public Estimator {
public:
    explicit ProductEstimator(const ProductContext& context) : product_(context) {}
    void add(TileWork& work, TileRecord& out) override {
        // Without several passes, no layer has the last one
        PixelSums& sums = work.sums;
        // The estimator always writes a last pass; here it goes where nobody reads it
        if (sums.last_pass.empty()) sums.last_pass.assign(work.pixels(), {});
        ProductSeconds s;
        product_.add(work.tile, work.eyes, work.oracle, sums.groups[size_t(LightGroup::kEnvironment)],
                     sums.last_pass, out.counters, s, work.control);
        // Product sampling times its own steps, which are finer than the stages of a tile
        out.stages.contributions += s.trees + s.maps + s.samples;
        out.stages.visibility += s.visibility;
        out.stages.shading += s.finish;
        out.product.merge(s);
    }
    void end(FrameResult& out) const override {
        if (out.tally) out.tally->merge(product_.tally());
    }

private:
    EnvironmentProduct product_;
};

}  // namespace

std::vector<std::unique_ptr<Estimator>> make_estimators(const FrameContext& c) {
    std::vector<std::unique_ptr<Estimator>> made;
    const auto add_samples = [&](const SampleKind& kind) {
        made.push_back(std::make_unique<SampleEstimator>(kind));
    };
    const auto has_lobes = [](const SharedLights& lights) { return lights.has_lobes(); };
    const IntegratorSettings& s = c.integrator;
    // Each where the scene and the integrator have such light. The order is that of the sums of a
    // pixel
    made.push_back(std::make_unique<SharedLightEstimator>(c));
    if (s.direct && !c.scene.area_lights().empty() && s.n_area > 0)
        add_samples({Semantic::kSurface, LightGroup::kArea, most_area_samples(c.scene, s), add_area_samples});
    if (s.direct && c.scene.environment() && s.n_environment + s.n_brdf > 0 &&
        s.environment == EnvironmentSampling::kMis)
        add_samples({Semantic::kSolidAngle, LightGroup::kEnvironment, s.n_environment + s.n_brdf,
                     add_environment_samples});
    if (std::ranges::any_of(c.shared, has_lobes))  // beside shared directions of the sky
        add_samples(
            {Semantic::kSolidAngle, LightGroup::kEnvironment, most_lobe_samples(s), add_lobe_samples, true});
    if (s.ambient && s.ambient_directions == AmbientDirections::kPerPoint)
        add_samples({Semantic::kSolidAngle, LightGroup::kAmbient, s.n_ambient, add_ambient_samples});
    if (c.shares) made.push_back(std::make_unique<AlignedAmbientEstimator>());
    if (c.product) made.push_back(std::make_unique<ProductEstimator>(*c.product));
    return made;
}

}  // namespace viscache
