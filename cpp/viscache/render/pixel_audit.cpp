#include "viscache/render/pixel_audit.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace viscache {

namespace {

constexpr uint32_t kNone = 0xffffffffu;

}  // namespace

PixelAudit::PixelAudit(const FrameSettings& frame, const RayCaster& caster, float extent,
                       const Control& control)
    : exact_(caster, extent),
      drawn_(draw_audit_pixels(uint32_t(frame.width), uint32_t(frame.height), frame.audit_pixels, frame.seed,
                               frame.first_sample)),
      by_row_(drawn_.size()) {
    exact_.watch(control);
    std::iota(by_row_.begin(), by_row_.end(), 0u);
    std::sort(by_row_.begin(), by_row_.end(), [&](uint32_t a, uint32_t b) {
        return std::tie(drawn_[a].y, drawn_[a].x) < std::tie(drawn_[b].y, drawn_[b].x);
    });
}

void PixelAudit::begin_tile(const Tile& tile, const EyeTile& eyes) {
    pixels_.clear();
    eye_.clear();
    pixel_of_.clear();
    block_.clear();
    counters_ = {};
    std::vector<uint32_t> chosen(size_t(eyes.width) * size_t(eyes.height), kNone);
    const auto first = std::partition_point(by_row_.begin(), by_row_.end(),
                                            [&](uint32_t i) { return drawn_[i].y < uint32_t(tile.y0); });
    for (auto i = first; i != by_row_.end() && drawn_[*i].y < uint32_t(tile.y1); ++i) {
        const AuditPixel& pixel = drawn_[*i];
        if (pixel.x < uint32_t(tile.x0) || pixel.x >= uint32_t(tile.x1)) continue;
        const size_t row = pixel.y - uint32_t(tile.y0), column = pixel.x - uint32_t(tile.x0);
        chosen[row * size_t(eyes.width) + column] = uint32_t(pixels_.size());
        pixels_.push_back({*i, {}});
    }
    number_.assign(eyes.size(), kNone);
    for (size_t i = 0; i < eyes.size(); ++i) {
        const uint32_t pixel = chosen[eyes.pixel[i]];
        if (pixel == kNone) continue;
        number_[i] = uint32_t(eye_.size());
        eye_.push_back(uint32_t(i));
        pixel_of_.push_back(pixel);
        block_.position.push_back(eyes.block.position[i]);
        block_.normal.push_back(eyes.block.normal[i]);
        block_.origin.push_back(eyes.block.origin[i]);
        block_.density.push_back(eyes.block.density[i]);
    }
}

void PixelAudit::block(const AuditedBlock& block) {
    if (eye_.empty() || block.oracle.is_exact(block.lights)) return;
    wanted_.reset(eye_.size(), block.lights.count);
    seen_.reset(eye_.size(), block.lights.count);
    for (size_t k = 0; k < eye_.size(); ++k) {
        const std::span<const Word> row = block.wanted.row_span(eye_[k]);
        std::copy(row.begin(), row.end(), wanted_.row(k));
    }
    exact_.begin_tile(block_);
    exact_.block(block_, block.lights, wanted_, seen_, counters_);
    for (size_t k = 0; k < eye_.size(); ++k) {
        const std::span<const Word> answered = block.visible.row_span(eye_[k]), truth = seen_.row_span(k);
        const std::span<const float> weights = block.oracle.block_weights(eye_[k]);
        if (weights.empty() && std::equal(answered.begin(), answered.end(), truth.begin(), truth.end()))
            continue;
        const Rgb found = block.light(eye_[k], answered.data(), weights);
        add(block.lights.group, k, found - block.light(eye_[k], truth.data(), {}));
    }
}

void PixelAudit::samples(const WeightedSamples& samples, std::span<const Word> visible,
                         const VisibilityOracle& oracle) {
    const LocalSamples& all = samples.at;
    if (eye_.empty() || oracle.is_exact_own(all.group)) return;
    LocalSamples some;
    some.semantic = all.semantic;
    some.group = all.group;
    some.t_max = all.t_max;
    std::vector<size_t> number;
    for (size_t row = 0; row < all.eye.size(); ++row) {
        const uint32_t k = number_[all.eye[row]];
        if (k == kNone) continue;
        for (size_t i = all.begin_of(row); i < all.end[row]; ++i) {
            number.push_back(i);
            some.add(all.far(i), all.density[i], all.light_density[i]);
            if (all.is_direction()) continue;
            some.normal.push_back(all.normal[i]);
            some.ray_end.push_back(all.ray_end[i]);
        }
        some.close(k);
    }
    if (number.empty()) return;
    std::vector<Word> seen(words_for(number.size()));
    exact_.begin_tile(block_);
    exact_.samples(block_, some, seen, counters_);
    const std::span<const float> weights = oracle.pair_weights();
    for_each_sample(some, [&](uint32_t k, size_t i) {
        const bool truth = get_bit(seen.data(), i);
        float answer = get_bit(visible.data(), number[i]) ? 1.f : 0.f;
        if (!weights.empty()) answer *= weights[number[i]];
        const float error = answer - (truth ? 1.f : 0.f);
        if (error != 0) add(some.group, k, samples.contribution[number[i]] * error);
    });
}

void PixelAudit::end_tile(AuditRecords& out) {
    out.pixels = pixels_;
    out.rays = counters_.rays();
}

}  // namespace viscache
