#include "viscache/render/taps.h"

#include <algorithm>
#include <stdexcept>

#include "viscache/oracles/exact.h"

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

const LocalSamples& samples_of(const PairsAsk& ask) {
    if (!ask.samples) throw std::logic_error("only frames of tiles, which ask for samples, are recorded");
    return *ask.samples;
}

/// Records what is asked, and sees nothing.
class TapOracle final : public VisibilityOracle {
public:
    explicit TapOracle(size_t groups) : groups_(groups) {}
    void begin_tile(const EyeBlock& eyes) override {
        tap = {};
        tap.eyes = eyes;
        tap.wanted.reserve(groups_);
    }
    Answer block(const BlockAsk& ask, Counters&) override {
        const size_t rows = ask.wanted.rows(), columns = ask.wanted.columns();
        BitMatrix& kept = tap.wanted.emplace_back(rows, columns);
        for (size_t r = 0; r < rows; ++r) std::ranges::copy(ask.wanted.row_span(r), kept.row(r));
        return {.bits = &new_bits(rows, columns)};
    }
    Answer pairs(const PairsAsk& ask, Counters&) override {
        tap.samples[samples_of(ask).group].append(samples_of(ask), ask.contributions);
        return {.bits = &new_bits(1, ask.size())};
    }

    TileTap tap;

private:
    size_t groups_;
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

/// Hands on the answers of another oracle and records them.
class AnswerOracle final : public VisibilityOracle {
public:
    explicit AnswerOracle(std::unique_ptr<VisibilityOracle> own) : inner(std::move(own)) { wrap(*inner); }
    void begin_tile(const EyeBlock& eyes) override {
        kept = {};
        inner->begin_tile(eyes);
    }
    PairOrder order(const EyeBlock& eyes, std::optional<int> group) override {
        const PairOrder order = inner->order(eyes, group);
        TileAnswers::Samples& s = kept.samples[group.value()];
        s.order.assign(order.eye.begin(), order.eye.end());
        s.run_end.assign(order.run_end.begin(), order.run_end.end());
        return order;
    }
    Answer block(const BlockAsk& ask, Counters& counters) override {
        const Answer answer = inner->block(ask, counters);
        const size_t rows = answer.bits->rows(), columns = answer.bits->columns();
        BitMatrix& bits = kept.bits.emplace_back(rows, columns);
        std::vector<float>& weights = kept.weights.emplace_back();
        for (size_t r = 0; r < rows; ++r) std::ranges::copy(answer.row(r), bits.row(r));
        // The record has one row of weights with their corrections; the frame adds corrections one by one
        Answer recorded = answer;
        recorded.bits = &bits;
        for (size_t r = 0; r < rows; ++r) {
            const std::span<const float> row = recorded.corrected_weights(r, corrected_);
            if (row.empty()) continue;
            if (weights.empty()) weights.assign(rows * columns, 1.f);
            std::ranges::copy(row, weights.begin() + ptrdiff_t(r * columns));
        }
        return answer;
    }
    Answer pairs(const PairsAsk& ask, Counters& counters) override {
        const Answer answer = inner->pairs(ask, counters);
        const LocalSamples& samples = samples_of(ask);
        TileAnswers::Samples& s = kept.samples[samples.group];
        s.weighted |= !answer.weights.empty();
        for_each_sample(samples, [&](uint32_t eye, size_t i) {
            auto& [seen, weight] = s.rows[eye];
            seen.push_back(answer.bits->get(0, i));
            weight.push_back(answer.weights.empty() ? 1.f : answer.weights[i]);
        });
        return answer;
    }

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
    Answer block(const BlockAsk& ask, Counters&) override {
        const size_t rows = ask.wanted.rows(), first = source_.first_row_[ask.eyes.tile];
        for (size_t i = 0; ask.lights.group == source_.group_ && i < rows; ++i) {
            const size_t row = first + i;
            if (row < source_.begin_ || row >= source_.end_) continue;
            Rgb* to = source_.values_.data() + (row - source_.begin_) * source_.columns_;
            ask.contributions->values(uint32_t(i), {to, source_.columns_});
        }
        return {.bits = &new_bits(rows, ask.wanted.columns())};
    }
    Answer pairs(const PairsAsk& ask, Counters&) override { return {.bits = &new_bits(1, ask.size())}; }

private:
    ContributionSource& source_;
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

/// Gives recorded answers.
class GivenOracle final : public VisibilityOracle {
public:
    explicit GivenOracle(const GivenAnswers& answers) : answers_(answers) {}
    PairOrder order(const EyeBlock& eyes, std::optional<int> group) override {
        const auto found = answers_.samples.find(group.value());
        if (found == answers_.samples.end() || found->second.order.empty()) return {};
        return {found->second.order[eyes.tile], found->second.run_end[eyes.tile]};
    }
    Answer block(const BlockAsk& ask, Counters& counters) override {
        const size_t rows = ask.wanted.rows(), first = answers_.first_row[ask.eyes.tile];
        BitMatrix& visible = new_bits(rows, ask.wanted.columns());
        const auto found = answers_.blocks.find(ask.lights.group);
        if (found == answers_.blocks.end()) return {.bits = &visible};
        const GivenBlock& given = found->second;
        for (size_t i = 0; i < rows; ++i) {
            const Word* from = given.bits + (first + i) * given.words;
            for (size_t w = 0; w < given.words; ++w) visible.row(i)[w] = from[w] & ask.wanted.row(i)[w];
        }
        const uint64_t asked = count_bits(ask.wanted);
        counters.group(ask.lights.group).queries += asked;
        counters.group(ask.lights.group).occluded += asked - count_bits(visible);
        Answer answer{.bits = &visible};
        if (given.weights) answer.weights = {given.weights + first * given.columns, rows * given.columns};
        return answer;
    }
    Answer pairs(const PairsAsk& ask, Counters& counters) override {
        const LocalSamples& samples = samples_of(ask);
        BitMatrix& visible = new_bits(1, ask.size());
        weights_.clear();
        const auto found = answers_.samples.find(samples.group);
        if (found == answers_.samples.end()) return {.bits = &visible};
        const GivenSamples& given = found->second;
        if (given.weights) weights_.assign(samples.size(), 1.f);
        for (size_t row = 0; row < samples.eye.size(); ++row) {
            const size_t first = given.first_sample[answers_.first_row[ask.eyes.tile] + samples.eye[row]];
            const size_t begin = samples.begin_of(row);
            for (size_t i = begin; i < samples.end[row]; ++i) {
                const size_t number = first + (i - begin);
                if (given.visible[number]) visible.set(0, i);
                if (given.weights) weights_[i] = given.weights[number];
            }
        }
        counters.group(samples.group).queries += samples.size();
        counters.group(samples.group).occluded += samples.size() - count_bits(visible);
        return {.bits = &visible, .weights = weights_};
    }

private:
    const GivenAnswers& answers_;
    std::vector<float> weights_;
};

}  // namespace

std::unique_ptr<VisibilityOracle> GivenSource::make() { return std::make_unique<GivenOracle>(answers_); }

}  // namespace viscache
