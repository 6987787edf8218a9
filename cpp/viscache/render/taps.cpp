#include "viscache/render/taps.h"

#include <algorithm>
#include <stdexcept>

#include "viscache/visibility/exact.h"

namespace viscache {

void SamplesTap::append(const LocalSamples& s, std::span<const Rgb> values, uint32_t first_eye) {
    at.semantic = s.semantic;
    at.group = s.group;
    at.t_max = s.t_max;
    const uint32_t before = uint32_t(at.size());
    for (const uint32_t eye : s.eye) at.eye.push_back(first_eye + eye);
    for (const uint32_t end : s.end) at.end.push_back(before + end);
    const auto extend = [](auto& all, const auto& some) { all.insert(all.end(), some.begin(), some.end()); };
    extend(at.x, s.x);
    extend(at.y, s.y);
    extend(at.z, s.z);
    extend(at.normal, s.normal);
    extend(at.ray_end, s.ray_end);
    extend(at.density, s.density);
    extend(at.light_density, s.light_density);
    extend(contribution, values);
}

namespace {

class TapOracle final : public VisibilityOracle {
public:
    explicit TapOracle(size_t groups) : groups_(groups) {}
    void begin_tile(const EyeBlock& eyes) override {
        tap = {};
        tap.eyes = eyes;
        tap.wanted.reserve(groups_);
    }
    void weigh_samples(std::span<const Rgb> contribution) override { contribution_ = contribution; }
    void block(const EyeBlock&, const FarEnds&, const BitMatrix& wanted, BitMatrix&, Counters&) override {
        BitMatrix& kept = tap.wanted.emplace_back(wanted.rows(), wanted.columns());
        for (size_t r = 0; r < wanted.rows(); ++r)
            std::copy_n(wanted.row(r), wanted.row_words(), kept.row(r));
    }
    void pairs(const EyeBlock&, std::span<const ShadowQuery>, std::span<Word>, Counters&) override {
        throw std::logic_error("frames of tiles ask for samples, not for pairs");
    }
    void samples(const EyeBlock&, const LocalSamples& samples, std::span<Word>, Counters&) override {
        tap.samples[samples.group].append(samples, contribution_);
    }

    TileTap tap;

private:
    size_t groups_;
    std::span<const Rgb> contribution_;
};

}  // namespace

void TapSource::prepare(FrameStart& frame, Control&) {
    for (const FarEnds* lights : frame.lights()) lights_.push_back(*lights);
}

std::unique_ptr<VisibilityOracle> TapSource::make() { return std::make_unique<TapOracle>(lights_.size()); }

void TapSource::end_item(VisibilityOracle& oracle, size_t item) {
    tiles_[item] = std::move(dynamic_cast<TapOracle&>(oracle).tap);
}

namespace {

class AnswerOracle final : public VisibilityOracle {
public:
    explicit AnswerOracle(std::unique_ptr<VisibilityOracle> own) : inner(std::move(own)) {}
    void watch(const Control& control) override { inner->watch(control); }
    void weigh(const Contributions* contributions) override { inner->weigh(contributions); }
    void weigh_samples(std::span<const Rgb> contribution) override { inner->weigh_samples(contribution); }
    void begin_tile(const EyeBlock& eyes) override {
        kept = {};
        inner->begin_tile(eyes);
    }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override {
        inner->block(eyes, lights, wanted, visible, counters);
        BitMatrix& bits = kept.bits.emplace_back(visible.rows(), visible.columns());
        std::vector<float>& weights = kept.weights.emplace_back();
        for (size_t r = 0; r < visible.rows(); ++r) {
            std::copy_n(visible.row(r), visible.row_words(), bits.row(r));
            const std::span<const float> row =
                inner->corrected_weights(uint32_t(r), bits.row(r), lights.count, corrected_);
            if (row.empty()) continue;
            if (weights.empty()) weights.assign(visible.rows() * lights.count, 1.f);
            std::copy_n(row.begin(), lights.count, weights.begin() + ptrdiff_t(r * lights.count));
        }
    }
    std::span<const float> block_weights(uint32_t eye) const override { return inner->block_weights(eye); }
    std::span<const Correction> block_corrections(uint32_t eye) const override {
        return inner->block_corrections(eye);
    }
    PairOrder pair_order(const EyeBlock& eyes) override { return inner->pair_order(eyes); }
    PairOrder sample_order(const EyeBlock& eyes, int group) override {
        const PairOrder order = inner->sample_order(eyes, group);
        TileAnswers::Samples& s = kept.samples[group];
        s.order.assign(order.eye.begin(), order.eye.end());
        s.run_end.assign(order.run_end.begin(), order.run_end.end());
        return order;
    }
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override {
        inner->pairs(eyes, queries, visible, counters);
    }
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override {
        inner->samples(eyes, samples, visible, counters);
        const std::span<const float> weights = inner->pair_weights();
        TileAnswers::Samples& s = kept.samples[samples.group];
        s.weighted |= !weights.empty();
        for (size_t row = 0; row < samples.eye.size(); ++row) {
            auto& [seen, weight] = s.rows[samples.eye[row]];
            for (size_t i = samples.begin_of(row); i < samples.end[row]; ++i) {
                seen.push_back(get_bit(visible.data(), i));
                weight.push_back(weights.empty() ? 1.f : weights[i]);
            }
        }
    }
    std::span<const float> pair_weights() const override { return inner->pair_weights(); }

    std::unique_ptr<VisibilityOracle> inner;
    TileAnswers kept;

private:
    std::vector<float> corrected_;
};

}  // namespace

std::unique_ptr<VisibilityOracle> AnswerSource::make() {
    return std::make_unique<AnswerOracle>(inner_.make());
}

void AnswerSource::end_item(VisibilityOracle& oracle, size_t item) {
    auto& own = dynamic_cast<AnswerOracle&>(oracle);
    inner_.end_item(*own.inner, item);
    tiles_[item] = std::move(own.kept);
}

/// Records the contributions of a group of shared lights.
class ContributionOracle final : public VisibilityOracle {
public:
    explicit ContributionOracle(ContributionSource& source) : source_(source) {}
    void begin_tile(const EyeBlock& eyes) override { tile_ = eyes.tile; }
    void weigh(const Contributions* contributions) override { contributions_ = contributions; }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix&, BitMatrix&,
               Counters&) override {
        if (lights.group != source_.group_) return;
        const size_t first = source_.first_row_[tile_];
        for (size_t i = 0; i < eyes.size(); ++i) {
            const size_t row = first + i;
            if (row < source_.begin_ || row >= source_.end_) continue;
            Rgb* to = source_.values_.data() + (row - source_.begin_) * source_.columns_;
            contributions_->values(uint32_t(i), {to, source_.columns_});
        }
    }
    void pairs(const EyeBlock&, std::span<const ShadowQuery>, std::span<Word>, Counters&) override {}
    void samples(const EyeBlock&, const LocalSamples&, std::span<Word>, Counters&) override {}

private:
    ContributionSource& source_;
    const Contributions* contributions_ = nullptr;
    size_t tile_ = 0;
};

void ContributionSource::prepare(FrameStart& frame, Control&) {
    for (const FarEnds* lights : frame.lights())
        if (lights->group == group_) columns_ = lights->count;
    values_.assign((end_ - begin_) * columns_, {});
}

std::unique_ptr<VisibilityOracle> ContributionSource::make() {
    return std::make_unique<ContributionOracle>(*this);
}

namespace {

class GivenOracle final : public VisibilityOracle {
public:
    explicit GivenOracle(const GivenAnswers& answers) : answers_(answers) {}
    void begin_tile(const EyeBlock& eyes) override { tile_ = eyes.tile; }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override {
        given_ = nullptr;
        const auto found = answers_.blocks.find(lights.group);
        if (found == answers_.blocks.end()) return;
        given_ = &found->second;
        GroupCounters& group = counters.group(lights.group);
        for (size_t i = 0; i < eyes.size(); ++i) {
            const Word* from = given_->bits + (answers_.first_row[tile_] + i) * given_->words;
            for (size_t w = 0; w < given_->words; ++w) visible.row(i)[w] = from[w] & wanted.row(i)[w];
            const uint64_t asked = count_bits(wanted.row_span(i));
            group.queries += asked;
            group.occluded += asked - count_bits(visible.row_span(i));
        }
    }
    std::span<const float> block_weights(uint32_t eye) const override {
        if (!given_ || !given_->weights) return {};
        return {given_->weights + (answers_.first_row[tile_] + eye) * given_->columns, given_->columns};
    }
    PairOrder sample_order(const EyeBlock&, int group) override {
        const auto found = answers_.samples.find(group);
        if (found == answers_.samples.end() || found->second.order.empty()) return {};
        return {found->second.order[tile_], found->second.run_end[tile_]};
    }
    void samples(const EyeBlock&, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override {
        weights_.clear();
        const auto found = answers_.samples.find(samples.group);
        if (found == answers_.samples.end()) return;
        const GivenSamples& given = found->second;
        if (given.weights) weights_.assign(samples.size(), 1.f);
        GroupCounters& group = counters.group(samples.group);
        for (size_t row = 0; row < samples.eye.size(); ++row) {
            const size_t first = given.first_sample[answers_.first_row[tile_] + samples.eye[row]];
            const size_t begin = samples.begin_of(row);
            for (size_t i = begin; i < samples.end[row]; ++i) {
                const size_t number = first + (i - begin);
                if (given.visible[number]) set_bit(visible.data(), i);
                if (given.weights) weights_[i] = given.weights[number];
                group.occluded += !given.visible[number];
            }
        }
        group.queries += samples.size();
    }
    void pairs(const EyeBlock&, std::span<const ShadowQuery>, std::span<Word>, Counters&) override {
        throw std::logic_error("frames of tiles ask for samples, not for pairs");
    }
    std::span<const float> pair_weights() const override { return weights_; }

private:
    const GivenAnswers& answers_;
    const GivenBlock* given_ = nullptr;
    std::vector<float> weights_;
    size_t tile_ = 0;
};

}  // namespace

std::unique_ptr<VisibilityOracle> GivenSource::make() { return std::make_unique<GivenOracle>(answers_); }

}  // namespace viscache
