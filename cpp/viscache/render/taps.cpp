#include "viscache/render/taps.h"

#include <algorithm>
#include <stdexcept>

#include "viscache/oracles/exact.h"

namespace viscache {

void SamplesTap::append(const LocalSamples& s, std::span<const Rgb> values, uint32_t first_eye) {
    at.semantic = s.semantic;
    at.group = s.group;
    at.t_max = s.t_max;
    // Ends count within the samples of `s`; here they follow those that are there already
    const uint32_t before = uint32_t(at.size());
    for (const uint32_t eye : s.eye) at.eye.push_back(first_eye + eye);
    for (const uint32_t end : s.end) at.end.push_back(before + end);
    // Directions have no normals and ends, so some of these stay empty on both sides
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
    // Bidirectional paths ask by queries, whose recording `vc.connections` refuses before
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
        // Blocks come in the order of the groups, so position is enough to know the group
        tap.wanted.reserve(groups_);
    }
    Answer block(const BlockAsk& ask, Counters&) override {
        const size_t rows = ask.wanted.rows(), columns = ask.wanted.columns();
        BitMatrix& kept = tap.wanted.emplace_back(rows, columns);
        for (size_t r = 0; r < rows; ++r) std::ranges::copy(ask.wanted.row_span(r), kept.row(r));
        // All zero: no light is added, so the frame costs no shading
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
    // Copied: the frame's own go with it, and the record outlives the frame
    for (const FarEnds* lights : frame.lights()) lights_.push_back(*lights);
}

std::unique_ptr<VisibilityOracle> TapSource::make() { return std::make_unique<TapOracle>(lights_.size()); }

void TapSource::end_item(VisibilityOracle& oracle, size_t item) {
    // A thread's oracle serves many tiles, so the record of each is taken as soon as it ends. Slots
    // are separate: no lock
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
        // The order decides which samples share a call, and so the answers of a cache: a replay
        // needs it
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
        // The oracle may reuse its buffers for the next block
        for (size_t r = 0; r < rows; ++r) std::ranges::copy(answer.row(r), bits.row(r));
        // The record has one row of weights with their corrections; the frame adds corrections one by one
        Answer recorded = answer;
        recorded.bits = &bits;
        for (size_t r = 0; r < rows; ++r) {
            const std::span<const float> row = recorded.corrected_weights(r, corrected_);
            // Weights are stored from the first row on that has any; rows before it get ones
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
            // By eye point, because batches may come in an order of the oracle's own
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
    // The inner source must see its own oracle: it may take what the tile has learnt
    inner_.end_item(*own.inner, item);
    tiles_[item] = std::move(own.kept);
}

/// Not in the anonymous namespace: its source names it as a friend.
/// Records the contributions of a group of shared lights.
class ContributionOracle final : public VisibilityOracle {
public:
    explicit ContributionOracle(ContributionSource& source) : source_(source) {}
    Answer block(const BlockAsk& ask, Counters&) override {
        const size_t rows = ask.wanted.rows(), first = source_.first_row_[ask.eyes.tile];
        for (size_t i = 0; ask.lights.group == source_.group_ && i < rows; ++i) {
            const size_t row = first + i;
            // Contributions are taken in slices of rows, because those of a whole frame may not fit
            // in memory
            if (row < source_.begin_ || row >= source_.end_) continue;
            Rgb* to = source_.values_.data() + (row - source_.begin_) * source_.columns_;
            // Each row belongs to one eye point of one tile, so threads never write the same place
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
        // A group that the frame lacks leaves no columns and an empty result
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
        // The order in which contributions are added decides the last bits of a pixel, so a replay
        // repeats it
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
            // Given bits of connections that contribute nothing have no effect, as with any oracle
            for (size_t w = 0; w < given.words; ++w) visible.row(i)[w] = from[w] & ask.wanted.row(i)[w];
        }
        const uint64_t asked = count_bits(ask.wanted);
        counters.group(ask.lights.group).queries += asked;
        counters.group(ask.lights.group).occluded += asked - count_bits(visible);
        Answer answer{.bits = &visible};
        // Rows of a tile lie one after the other, so its weights are one span of the caller's array
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
            // Samples are numbered through the frame by eye point, not by the order in which they
            // are asked for
            const size_t first = given.first_sample[answers_.first_row[ask.eyes.tile] + samples.eye[row]];
            const size_t begin = samples.begin_of(row);
            for (size_t i = begin; i < samples.end[row]; ++i) {
                // A row of samples is one eye point's, in the order in which they were recorded
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
