#include "viscache/render/light_pick.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "viscache/render/eye_samples.h"
#include "viscache/render/glossy_sums.h"

namespace viscache {

namespace {

constexpr double kMost = std::numeric_limits<float>::max();
constexpr size_t kBlock = 32;  // columns whose sum tells whether a point lies among them

/// Sum of a block in four running sums.
double block_sum(const float* c, size_t size) {
    // Four chains hide the latency of additions. The order of sums is fixed, since picks depend on
    // it
    double lanes[4] = {};
    size_t i = 0;
    for (; i + 4 <= size; i += 4)
        for (size_t j = 0; j < 4; ++j) lanes[j] += double(c[i + j]);
    for (; i < size; ++i) lanes[0] += double(c[i]);
    return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

}  // namespace

bool pick_columns(std::span<const float> contributions, size_t most, double u,
                  std::vector<PickedLight>& out) {
    const size_t n = contributions.size();
    const float* c = contributions.data();
    const size_t positive = size_t(std::count_if(c, c + n, [](float v) { return v > 0; }));
    double total = 0;
    for (size_t k = 0; k < n; k += kBlock) total += block_sum(c + k, std::min(kBlock, n - k));
    // As few lights as picks: all count, without noise. A sum that is not finite has no proportions
    if (positive <= most || !std::isfinite(total)) return false;
    // Points lie at (i + u) · distance on the running sum, i < most
    const double distance = total / double(most);
    double before = 0;
    size_t points = 0;  // passed so far
    const auto next_lies_before = [&](double sum) {
        return points < most && (double(points) + u) * distance < sum;
    };
    // Blocks without a point are passed by their sum alone: there are far more columns than picks
    for (size_t first = 0; first < n; first += kBlock) {
        const size_t size = std::min(kBlock, n - first);
        const double after = before + block_sum(c + first, size);
        // Within a block, columns are added one by one; rounding may differ from the block's own
        // sum, so the block's end is taken from `after`
        double sum = before;
        for (size_t k = first; k < first + size && next_lies_before(after); ++k) {
            sum += double(c[k]);
            // The next point lies on this column if the running sum passes it here
            if (!next_lies_before(sum)) continue;
            // Finite, so that the weight of the least contributions brings light and no NaN
            const double weight = std::clamp(distance / double(c[k]), 1.0, kMost);
            out.push_back({uint32_t(k), float(weight)});
            // A column longer than the distance holds several points, but is stored once, with
            // weight 1
            while (next_lies_before(sum)) ++points;
        }
        before = after;
    }
    return true;
}

void TilePicks::begin(const SharedLights& lights) {
    lights_ = &lights;
    picked_.clear();
    end_.clear();
}

void TilePicks::add(const EyeShade& shade, const EyeTile& eyes, uint32_t eye, Word* wanted) {
    // At most `most_` lights never need a choice
    if (most_ == 0 || lights_->ends.count <= most_) return;
    const ShadingPoint& brdf = eyes.shading[eye];
    if (is_black(brdf)) {
        end_.push_back(picked_.size());
        return;
    }
    const ColumnRange asked = lights_->ends.columns_of(eyes.block, eye);
    // By what the light adds under this BRDF, so that highlights are not left to chance
    if (brdf.kind == MaterialKind::kGlossy)
        contribution_row_glossy(*lights_, shade, brdf, wanted, contributions_);
    else
        contribution_row(*lights_, shade, asked, contributions_);
    // Keyed by pixel, branch and sequence, not by sample: all samples of the pixel share one van
    // der Corput sequence
    Rng rng(seed_, Purpose::kLightPick, eyes.block.place[eye],
            eyes.sequence() * kLightGroups + uint64_t(lights_->ends.group));
    const uint32_t first = rng.next_u32(), rest = rng.next_u32();
    const uint32_t scramble = rng.next_u32(), shuffle = rng.next_u32();
    const uint32_t number = shuffled_sample(eyes.sample(eye), shuffle);
    // The member of the scrambled sequence relative to member 0: a shift of the pixel's random
    // offset
    const uint32_t step = owen_scramble_reversed(number, scramble) ^ owen_scramble_reversed(0, scramble);
    // 64 bits of offset: a float would never hit short columns of long rows
    const uint64_t bits = uint64_t(first ^ step) << 32 | rest;
    // Picks of all eye points lie in one list
    const size_t before = picked_.size();
    const std::span<const float> columns(contributions_.data() + asked.first, asked.size());
    if (pick_columns(columns, most_, double(bits >> 11) * 0x1p-53, picked_)) {
        std::fill_n(wanted, row_words_for(lights_->ends.count), Word{0});
        for (size_t p = before; p < picked_.size(); ++p) {
            // From the columns of the set that was asked to those of the group
            picked_[p].column += uint32_t(asked.first);
            set_bit(wanted, picked_[p].column);
        }
    }
    end_.push_back(picked_.size());
}

}  // namespace viscache
