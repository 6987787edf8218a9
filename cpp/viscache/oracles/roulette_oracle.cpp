#include "viscache/oracles/roulette_oracle.h"

namespace viscache {

namespace {

/// 32 random bits of one connection, from the key of the eye point and the index of the far end.
inline uint32_t random_bits(uint32_t low, uint32_t high, uint32_t number) {
    // 32 bits, so that the compiler draws 8 or 16 connections at a time
    uint32_t x = low + number * 0x9E3779B9u;
    x ^= x >> 16;
    x *= 0x7FEB352Du;
    x ^= high;
    x ^= x >> 15;
    x *= 0x846CA68Bu;
    return x ^ (x >> 16);
}

}  // namespace

Answer LearningOracle::block(const BlockAsk& ask, Counters& counters) {
    const Answer answer = exact_.block(ask, counters);
    const FarEnds& lights = ask.lights;
    // Cells of far ends once per block, not once per query
    std::vector<uint32_t> far(lights.count);
    for (size_t k = 0; k < far.size(); ++k)
        far[k] = map_.far_cell(lights.semantic, {lights.x[k], lights.y[k], lights.z[k]});
    for (size_t i = 0; i < ask.wanted.rows(); ++i) {
        const uint32_t voxel = map_.voxel(ask.eyes.position[i]);
        for_each_bit(ask.wanted.row_span(i), [&](size_t k) { add(voxel, far[k], answer.bits->get(i, k)); });
    }
    return answer;
}

Answer LearningOracle::pairs(const PairsAsk& ask, Counters& counters) {
    const Answer answer = exact_.pairs(ask, counters);
    std::vector<ShadowQuery> made;
    const std::span<const ShadowQuery> queries = ask.as_queries(made);
    for (size_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        add(map_.voxel(ask.eyes.position[q.eye]), map_.far_cell(q.semantic, q.far), answer.bits->get(0, i));
    }
    return answer;
}

/// Computes the probabilities of all columns for every voxel with eye points.
void RouletteOracle::make_rows(const BlockAsk& ask) {
    thresholds_.clear();
    weights_.clear();
    voxels_.make(ask, [&](uint32_t voxel, std::span<const uint32_t> far) {
        for (const uint32_t cell : far) {
            const RandomShare share(map_.probability(voxel, cell));
            // Less one, so that a probability of 1, whose threshold is 2³², fits into 32 bits; it
            // is compared with <=
            thresholds_.push_back(uint32_t(share.threshold - 1));
            weights_.push_back(share.inverse);
        }
        // Whole words, because rows are drawn by words
        thresholds_.resize((thresholds_.size() + kWordBits - 1) / kWordBits * kWordBits);
    });
}

/// Draws the wanted columns of one eye point that are traced.
void RouletteOracle::draw_row(const BlockAsk& ask, size_t eye, Word* drawn) const {
    const uint64_t key = keys_.of(ask.eyes, eye, ask.lights.group);
    const uint32_t low = uint32_t(key), high = uint32_t(key >> 32);
    const size_t words = words_for(ask.lights.count);
    const Word* wanted = ask.wanted.row(eye);
    const uint32_t* threshold = thresholds_.data() + voxels_.of_eyes()[eye] * words * kWordBits;
    for (size_t w = 0; w < words; ++w) {
        if (!wanted[w]) continue;
        // Comparisons first, bits afterwards: the first loop is vectorised
        uint8_t passes[kWordBits];
        for (size_t j = 0; j < kWordBits; ++j) {
            const uint32_t k = uint32_t(w * kWordBits + j);
            passes[j] = random_bits(low, high, k) <= threshold[k];
        }
        Word bits = 0;
        for (size_t j = 0; j < kWordBits; ++j) bits |= Word(passes[j]) << j;
        drawn[w] = wanted[w] & bits;
    }
}

Answer RouletteOracle::block(const BlockAsk& ask, Counters& counters) {
    make_rows(ask);
    drawn_.reset(ask.wanted.rows(), ask.lights.count);
    for (size_t i = 0; i < drawn_.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        draw_row(ask, i, drawn_.row(i));
    }
    const Answer traced = exact_.block({ask.eyes, ask.lights, drawn_}, counters);
    // A query that is not traced counts as blocked
    const uint64_t left_out = count_bits(ask.wanted) - count_bits(drawn_);
    GroupCounters& group = counters.group(ask.lights.group);
    group.queries += left_out;
    group.occluded += left_out;
    return {.bits = traced.bits, .weights = weights(), .weight_row = voxels_.of_eyes()};
}

Answer RouletteOracle::pairs(const PairsAsk& ask, Counters& counters) {
    const std::span<const ShadowQuery> queries = ask.as_queries(made_);
    weights_.clear();
    number_.clear();
    traced_.clear();
    for (size_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        const RandomShare share(
            map_.probability(map_.voxel(ask.eyes.position[q.eye]), map_.far_cell(q.semantic, q.far)));
        const uint64_t key = mix_point(keys_.of(ask.eyes, q.eye, q.group), q.far);
        weights_.push_back(share.inverse);
        if (random_bits(uint32_t(key), uint32_t(key >> 32), 0) < share.threshold) {
            number_.push_back(uint32_t(i));
            traced_.push_back(q);
        } else {
            // As in a block, a query that is not traced counts as blocked
            ++counters.group(q.group).queries;
            ++counters.group(q.group).occluded;
        }
    }
    const Answer seen = exact_.pairs({ask.eyes, traced_}, counters);
    BitMatrix& visible = new_bits(1, queries.size());
    for_each_bit(seen.row(0), [&](size_t i) { visible.set(0, number_[i]); });
    return {.bits = &visible, .weights = weights()};
}

}  // namespace viscache
