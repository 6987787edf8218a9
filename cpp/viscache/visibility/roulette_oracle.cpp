#include "viscache/visibility/roulette_oracle.h"

#include "viscache/sampling/point_key.h"

namespace viscache {

namespace {

/// q as a threshold for 32 random bits, and the inverse of the resulting probability.
struct Chance {
    uint32_t threshold;
    float weight;
    explicit Chance(double q) {
        const double steps = std::clamp(std::floor(q * 0x1p32), 1.0, 0x1p32);
        threshold = uint32_t(steps - 1);
        weight = float(0x1p32 / steps);
    }
};

/// 32 random bits of one connection, from the key of the eye point and the index of the far end.
inline uint32_t random_bits(uint32_t low, uint32_t high, uint32_t number) {
    uint32_t x = low + number * 0x9E3779B9u;
    x ^= x >> 16;
    x *= 0x7FEB352Du;
    x ^= high;
    x ^= x >> 15;
    x *= 0x846CA68Bu;
    return x ^ (x >> 16);
}

}  // namespace

void LearningOracle::watch(const Control& control) {
    VisibilityOracle::watch(control);
    exact_.watch(control);
}

void LearningOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                           BitMatrix& visible, Counters& counters) {
    exact_.block(eyes, lights, wanted, visible, counters);
    std::vector<uint32_t> far(lights.count);
    for (size_t k = 0; k < far.size(); ++k)
        far[k] = map_.far_cell(lights.semantic, {lights.x[k], lights.y[k], lights.z[k]});
    for (size_t i = 0; i < wanted.rows(); ++i) {
        const uint32_t voxel = map_.voxel(eyes.position[i]);
        for_each_bit(wanted.row_span(i), [&](size_t k) { add(voxel, far[k], get_bit(visible.row(i), k)); });
    }
}

void LearningOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                           std::span<Word> visible, Counters& counters) {
    exact_.pairs(eyes, queries, visible, counters);
    for (size_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        add(map_.voxel(eyes.position[q.eye]), map_.far_cell(q.semantic, q.far), get_bit(visible.data(), i));
    }
}

void RouletteOracle::watch(const Control& control) {
    VisibilityOracle::watch(control);
    exact_.watch(control);
}

/// Random key of an eye point. It depends on its position, not on tiles or threads.
uint64_t RouletteOracle::eye_key(const EyeBlock& eyes, size_t eye, int group) const {
    Rng rng(seed_, Purpose::kRoulette, uint64_t(group), 0);
    return mix_point(rng.next_u32(), eyes.position[eye]);
}

/// Computes the probabilities of all columns for every voxel with eye points.
void RouletteOracle::make_rows(const EyeBlock& eyes, const FarEnds& lights) {
    for (const auto& row : rows_) row_of_voxel_[row->voxel] = kNone;
    rows_.clear();
    far_.resize(lights.count);
    for (size_t k = 0; k < far_.size(); ++k)
        far_[k] = map_.far_cell(lights.semantic, {lights.x[k], lights.y[k], lights.z[k]});
    row_of_eye_.resize(eyes.size());
    for (size_t i = 0; i < eyes.size(); ++i) {
        const uint32_t voxel = map_.voxel(eyes.position[i]);
        if (row_of_voxel_[voxel] == kNone) {
            auto row = std::make_unique<Row>();
            row->voxel = voxel;
            row->threshold.assign(lights.x.size(), 0);
            row->weight.assign(lights.x.size(), 1.f);
            for (size_t k = 0; k < far_.size(); ++k) {
                const Chance chance(map_.probability(voxel, far_[k]));
                row->threshold[k] = chance.threshold;
                row->weight[k] = chance.weight;
            }
            row_of_voxel_[voxel] = uint32_t(rows_.size());
            rows_.push_back(std::move(row));
        }
        row_of_eye_[i] = row_of_voxel_[voxel];
    }
}

/// Selects the wanted columns of one eye point that are traced.
void RouletteOracle::keep_row(const EyeBlock& eyes, size_t eye, const FarEnds& lights, const Word* wanted,
                              Word* kept) const {
    const uint64_t key = eye_key(eyes, eye, lights.group);
    const uint32_t low = uint32_t(key), high = uint32_t(key >> 32);
    const std::vector<uint32_t>& threshold = rows_[row_of_eye_[eye]]->threshold;
    for (size_t w = 0; w < words_for(lights.count); ++w) {
        if (!wanted[w]) continue;
        uint8_t passes[kWordBits];
        for (size_t j = 0; j < kWordBits; ++j) {
            const uint32_t k = uint32_t(w * kWordBits + j);
            passes[j] = random_bits(low, high, k) <= threshold[k];
        }
        Word bits = 0;
        for (size_t j = 0; j < kWordBits; ++j) bits |= Word(passes[j]) << j;
        kept[w] = wanted[w] & bits;
    }
}

void RouletteOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                           BitMatrix& visible, Counters& counters) {
    make_rows(eyes, lights);
    kept_.reset(wanted.rows(), lights.count);
    for (size_t i = 0; i < wanted.rows(); ++i) {
        if (i % 256 == 0) check_cancelled();
        keep_row(eyes, i, lights, wanted.row(i), kept_.row(i));
    }
    exact_.block(eyes, lights, kept_, visible, counters);
    const uint64_t left_out = count_bits(wanted) - count_bits(kept_);
    GroupCounters& group = counters.group(lights.group);
    group.queries += left_out;
    group.occluded += left_out;
}

void RouletteOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                           std::span<Word> visible, Counters& counters) {
    weight_.assign(queries.size(), 1.f);
    traced_.clear();
    queries_.clear();
    for (size_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        const Chance chance(
            map_.probability(map_.voxel(eyes.position[q.eye]), map_.far_cell(q.semantic, q.far)));
        const uint64_t key = mix_point(eye_key(eyes, q.eye, q.group), q.far);
        weight_[i] = chance.weight;
        if (random_bits(uint32_t(key), uint32_t(key >> 32), 0) <= chance.threshold) {
            traced_.push_back(uint32_t(i));
            queries_.push_back(q);
        } else {
            ++counters.group(q.group).queries;
            ++counters.group(q.group).occluded;
        }
    }
    answer_.assign(words_for(queries_.size()), 0);
    exact_.pairs(eyes, queries_, answer_, counters);
    for_each_bit(answer_, [&](size_t i) { set_bit(visible.data(), traced_[i]); });
}

}  // namespace viscache
