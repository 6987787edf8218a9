#include "viscache/render/query_audit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "viscache/sampling/rng.h"

namespace viscache {

namespace {

double sum_of(Rgb c) { return double(c.x) + c.y + c.z; }

/// A weighted answer has no single bit that a ray could contradict.
void refuse_weights(const Answer& answer) {
    if (!answer.weights.empty())
        throw std::invalid_argument("visibility must answer without weights for an audit of queries");
}

void add_wrong(AuditedQueries& found, bool certain, double error) {
    if (certain) {
        ++found.certain_wrong;
        // All bright ones are traced: their sum is known, without a variance
        found.certain_error += error;
    } else {
        ++found.sampled_wrong;
        found.sampled_error += error;
        found.sampled_square += error * error;
        // Squares estimate the variance, fourth powers tell how far that estimate can be trusted
        found.sampled_fourth += error * error * error * error;
    }
}

}  // namespace

void QueryAudit::begin_tile(const EyeTile& eyes) {
    eyes_ = &eyes;
    counters_ = {};
    found_ = {};
}

void QueryAudit::draw(uint64_t stream, int group, size_t n, std::span<Word> bits) const {
    const double share = frame_.audit_share;
    // A geometric distribution with p = 1 would divide by log 0
    if (share >= 1) {
        for (size_t k = 0; k < n; ++k) set_bit(bits.data(), k);
        return;
    }
    // Distances between drawn bits have a geometric distribution
    Rng rng(frame_.seed, Purpose::kAudit, stream, uint64_t(group));
    const double per_log = 1 / std::log1p(-share);
    for (double k = -1;;) {
        // Never 0, whose logarithm is infinite
        const double u = (double(rng.next_u64() >> 11) + 0.5) * 0x1p-53;
        // One random number per drawn bit instead of one per query
        k += 1 + std::floor(std::log(u) * per_log);
        if (!(k < double(n))) return;
        set_bit(bits.data(), size_t(k));
    }
}

void QueryAudit::block(const BlockAsk& ask, const Answer& answer, const TileContributions& contributions,
                       const Light& light_of) {
    const size_t columns = ask.lights.count, n = eyes_->size();
    AuditedQueries& found = found_[size_t(ask.lights.group)];
    // Rays would say the same again
    if (answer.is_exact(ask.lights.group)) {
        found.exact += count_bits(ask.wanted);
        return;
    }
    refuse_weights(answer);
    // What is asked again: the bright connections, and a share of the others
    asked_.reset(n, columns);
    bright_.reset(n, columns);
    row_.assign(ask.wanted.row_words(), 0);
    Word* const rows[1] = {row_.data()};
    double light = 0;
    const auto wanted_of = [&](size_t i) { return count_bits(ask.wanted.row_span(i)); };
    for (size_t i = 0; i < n; ++i)
        if (wanted_of(i)) light += contributions.unoccluded(uint32_t(i));
    // Mean contribution of a query of the tile: the scale on which a connection is bright
    const double mean = light / double(std::max<uint64_t>(1, count_bits(ask.wanted)));
    for (size_t i = 0; i < n; ++i) {
        const std::span<const Word> wanted = ask.wanted.row_span(i);
        const uint64_t asks = wanted_of(i);
        if (asks == 0) continue;
        std::fill(row_.begin(), row_.end(), Word{0});
        // Few bright connections of a tile decide its error
        const double here = double(contributions.unoccluded(uint32_t(i))) / double(asks);
        // `at_most` counts in means of the eye point, so the lower of both means is the unit:
        // points darker than the tile keep their own
        const float limit[1] = {frame_.audit_above * float(mean < here ? mean / here : 1)};
        contributions.at_most(uint32_t(i), limit, rows);
        const std::span<Word> bright(bright_.row(i), wanted.size()), asked(asked_.row(i), wanted.size());
        // By the key of the eye point: the same queries are drawn whatever the tiles and threads
        draw(eyes_->stream[i], ask.lights.group, columns, asked);
        for (size_t w = 0; w < wanted.size(); ++w) {
            // Drawn among all columns, then cut to those that were asked
            bright[w] = wanted[w] & ~row_[w];
            asked[w] = (wanted[w] & asked[w]) | bright[w];
        }
    }
    // Rays answer it, and every answer that differs counts with its light
    exact_.begin_tile(eyes_->block);
    // Its own oracle and counters, so that the frame's rays and bytes do not change
    const Answer exact = exact_.block({eyes_->block, ask.lights, asked_}, counters_);
    const uint64_t certain = count_bits(bright_);
    found.queries += count_bits(ask.wanted);
    found.certain += certain;
    found.sampled += count_bits(asked_) - certain;
    for (size_t i = 0; i < n; ++i) {
        const Word *asked = asked_.row(i), *seen = exact.bits->row(i), *answered = answer.bits->row(i);
        for (size_t w = 0; w < row_.size(); ++w) row_[w] = asked[w] & (answered[w] ^ seen[w]);
        // The light of one wrong connection at a time, by the function that shades the frame
        std::vector<Word> one(row_.size());
        for_each_bit(row_, [&](size_t k) {
            set_bit(one.data(), k);
            const double c = sum_of(light_of(i, one.data()));
            clear_bit(one.data(), k);
            // Positive: light that the answer lets through. Negative: light that it takes away
            add_wrong(found, get_bit(bright_.row(i), k), get_bit(answered, k) ? c : -c);
        });
    }
}

void QueryAudit::samples(const WeightedSamples& samples, const Answer& answer) {
    const LocalSamples& all = samples.at;
    AuditedQueries& found = found_[size_t(all.group)];
    if (answer.is_exact(all.group)) {
        found.exact += all.size();
        return;
    }
    found.queries += all.size();
    refuse_weights(answer);
    // What is asked again, as in a block
    LocalSamples some;
    some.semantic = all.semantic;
    some.group = all.group;
    // A second list with the chosen samples alone; `number` leads back to the answers
    some.t_max = all.t_max;
    std::vector<size_t> number;
    std::vector<bool> certain;
    double light = 0;
    for (const Rgb c : samples.contribution) light += sum_of(c);
    const double mean = light / double(std::max<size_t>(1, all.size()));
    for (size_t row = 0; row < all.eye.size(); ++row) {
        const size_t begin = all.begin_of(row), end = all.end[row];
        double sum = 0;
        for (size_t i = begin; i < end; ++i) sum += sum_of(samples.contribution[i]);
        // The same rule as in a block: a multiple of the lower of both means
        const double limit =
            frame_.audit_above * std::min(mean, sum / double(std::max<size_t>(1, end - begin)));
        row_.assign(words_for(end - begin), 0);
        draw(eyes_->stream[all.eye[row]], all.group, end - begin, row_);
        for (size_t i = begin; i < end; ++i) {
            const bool bright = sum_of(samples.contribution[i]) > limit;
            if (!bright && !get_bit(row_.data(), i - begin)) continue;
            number.push_back(i);
            certain.push_back(bright);
            (bright ? found.certain : found.sampled) += 1;
            some.add(all.far(i), all.density[i], all.light_density[i]);
            // Directions have neither normal nor end
            if (all.is_direction()) continue;
            some.normal.push_back(all.normal[i]);
            some.ray_end.push_back(all.ray_end[i]);
        }
        some.close(all.eye[row]);
    }
    // Empty rows would cost the exact oracle a sort
    if (number.empty()) return;
    exact_.begin_tile(eyes_->block);
    const Answer exact = exact_.pairs({.eyes = eyes_->block, .samples = &some}, counters_);
    for (size_t k = 0; k < number.size(); ++k) {
        const bool answered = answer.bits->get(0, number[k]);
        if (answered == exact.bits->get(0, k)) continue;
        const double c = sum_of(samples.contribution[number[k]]);
        add_wrong(found, certain[k], answered ? c : -c);
    }
}

void QueryAudit::end_tile(AuditRecords& out) {
    out.queries = found_;
    out.rays = counters_.rays();
}

}  // namespace viscache
