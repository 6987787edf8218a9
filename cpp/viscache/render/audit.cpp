#include "viscache/render/audit.h"

#include <algorithm>
#include <cmath>

#include "viscache/sampling/rng.h"

namespace viscache {

namespace {

constexpr double kPixels = 256;  // number of audited pixels in large frames
constexpr int kLeastEdge = 16;   // so at most one of 256 pixels is audited
constexpr uint32_t kNone = 0xffffffffu;

/// Edge of the blocks of which one pixel each is audited.
int block_edge(const FrameSettings& frame) {
    return std::max(kLeastEdge,
                    int(std::ceil(std::sqrt(double(frame.width) * double(frame.height) / kPixels))));
}

}  // namespace

void AuditSums::merge(const AuditSums& b) {
    pixels += b.pixels;
    rays += b.rays;
    error += b.error;
    square += b.square;
    for (size_t g = 0; g < groups.size(); ++g) groups[g] += b.groups[g];
}

void TileAudit::begin_tile(const Tile& tile, const EyeTile& eyes) {
    pixels_.clear();
    eye_.clear();
    pixel_of_.clear();
    block_.clear();
    counters_ = {};
    audits_ = false;
    const int edge = block_edge(frame_);
    std::vector<uint32_t> chosen(size_t(eyes.width) * size_t(eyes.height), kNone);
    for (int y0 = tile.y0 / edge * edge; y0 < tile.y1; y0 += edge)
        for (int x0 = tile.x0 / edge * edge; x0 < tile.x1; x0 += edge) {
            const uint64_t key = mix64(mix64(frame_.seed) ^ (uint64_t(y0) << 32 | uint64_t(x0)));
            const int width = std::min(edge, frame_.width - x0), height = std::min(edge, frame_.height - y0);
            const int x = x0 + int((key >> 32) % uint64_t(width));
            const int y = y0 + int((key & 0xffffffffu) % uint64_t(height));
            if (x < tile.x0 || x >= tile.x1 || y < tile.y0 || y >= tile.y1) continue;
            chosen[size_t(y - tile.y0) * size_t(eyes.width) + size_t(x - tile.x0)] = uint32_t(pixels_.size());
            pixels_.push_back({double(width) * height, {}});
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

VisibilityOracle* TileAudit::oracle(int group, const FarEnds* lights) {
    Auditor& auditor = auditors_[size_t(group)][lights == nullptr];
    if (!auditor.asked) {
        auditor.asked = true;
        auditor.oracle = source_.make_audit(group, lights);
        if (auditor.oracle) auditor.oracle->watch(control_);
    }
    audits_ |= auditor.oracle != nullptr;
    return auditor.oracle.get();
}

void TileAudit::ask_block(VisibilityOracle& exact, const FarEnds& lights, const BitMatrix& wanted) {
    wanted_.reset(eye_.size(), lights.count);
    seen_.reset(eye_.size(), lights.count);
    for (size_t k = 0; k < eye_.size(); ++k) {
        const std::span<const Word> row = wanted.row_span(eye_[k]);
        std::copy(row.begin(), row.end(), wanted_.row(k));
    }
    exact.begin_tile(block_);
    exact.block(block_, lights, wanted_, seen_, counters_);
}

bool TileAudit::differ(std::span<const Word> a, std::span<const Word> b) {
    return !std::equal(a.begin(), a.end(), b.begin(), b.end());
}

void TileAudit::samples(const WeightedSamples& samples, std::span<const Word> visible) {
    VisibilityOracle* exact = oracle(samples.at.group, nullptr);
    if (!exact || eye_.empty()) return;
    const LocalSamples& all = samples.at;
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
    exact->begin_tile(block_);
    exact->samples(block_, some, seen, counters_);
    for_each_sample(some, [&](uint32_t k, size_t i) {
        const bool cached = get_bit(visible.data(), number[i]), truth = get_bit(seen.data(), i);
        if (cached != truth) add(some.group, k, samples.contribution[number[i]] * (cached ? 1.f : -1.f));
    });
}

void TileAudit::end_tile(AuditSums& out) const {
    if (!audits_) return;
    out.pixels += pixels_.size();
    out.rays += counters_.rays();
    const auto sum_of = [](Rgb e) { return double(std::fabs(e.x)) + std::fabs(e.y) + std::fabs(e.z); };
    for (const Pixel& pixel : pixels_) {
        Rgb total{};
        for (size_t g = 0; g < pixel.error.size(); ++g) {
            total += pixel.error[g];
            out.groups[g] += pixel.weight * sum_of(pixel.error[g]);
        }
        const double error = pixel.weight * sum_of(total);
        out.error += error;
        out.square += error * error;
    }
}

}  // namespace viscache
