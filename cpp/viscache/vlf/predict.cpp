#include "viscache/vlf/predict.h"

#include <optional>

#include "viscache/casters/bsp_tree.h"

namespace viscache {

namespace {

// Subfields of a scene differ little in size, so a few of them speak for all.
constexpr uint32_t kSamples = 8;

/// Lower bound of the bytes of a field: its lists without division into leaves, and 16 bytes per tile.
double least_bytes(const FieldTriangles& triangles, const FieldSettings& s) {
    const double tiles = double(s.n_tiles) * s.n_tiles;
    return s.n_directions * (16 * tiles + 4 * expected_references(triangles.in_ball(), s.n_tiles));
}

/// True if a field is predicted to fit. Settings that are far too large are rejected without a trial build.
bool fits(const FieldTriangles& triangles, const FieldSettings& s, int threads, const Control& control) {
    // Twice the budget: the estimate is of averages, and only clear excess is refused without a trial.
    if (least_bytes(triangles, s) > 2.0 * double(s.max_bytes)) return false;
    return predicted_peak(triangles, s, threads, control).peak() <= s.max_bytes;
}

/// The first of several settings that fits.
template <class Change>
std::optional<FieldSettings> first_fit(const FieldTriangles& triangles, FieldSettings s, int threads,
                                       const Control& control, Change change) {
    while (change(s))
        if (fits(triangles, s, threads, control)) return s;
    return {};
}

bool halve_tiles(FieldSettings& s) { return (s.n_tiles /= 2) >= 1; }
bool less_depth(FieldSettings& s) { return --s.bsp_depth >= 0; }
bool fewer_directions(FieldSettings& s) {
    if (s.n_directions == 1) return false;
    // 2·4^k + 1 becomes 2·4^(k−1) + 1.
    s.n_directions = s.n_directions == 3 ? 1 : (s.n_directions - 1) / 4 + 1;
    return true;
}

std::string suggestions(const FieldTriangles& triangles, const FieldSettings& s, int threads,
                        const Control& control) {
    std::string text;
    // Each suggestion changes one setting: users choose which one they give up.
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", or ") + part; };
    if (const auto fit = first_fit(triangles, s, threads, control, halve_tiles))
        add("n_tiles=" + std::to_string(fit->n_tiles));
    if (const auto fit = first_fit(triangles, s, threads, control, less_depth))
        add("bsp_depth=" + std::to_string(fit->bsp_depth));
    if (const auto fit = first_fit(triangles, s, threads, control, fewer_directions))
        add("n_directions=" + std::to_string(fit->n_directions));
    return text.empty() ? "no smaller n_tiles, bsp_depth or n_directions alone would fit"
                        : "the largest that fit, each alone: " + text;
}

}  // namespace

double expected_references(std::span<const FlatTriangle> triangles, int n_tiles) {
    // Width of a tile
    const double c = 2.0 / n_tiles;
    double sum = 0;
    for (const FlatTriangle& t : triangles) {
        const Vec3 e[3] = {t.b - t.a, t.c - t.b, t.a - t.c};
        const double perimeter = double(length(e[0])) + length(e[1]) + length(e[2]);
        // Half the cross product is the area A.
        sum += 0.5 * length(cross(e[0], e[1])) / (2 * c * c) + perimeter / (2 * c) + 1;
    }
    return sum;
}

PredictedBytes predicted_peak(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                              const Control& control) {
    const Directions& directions = directions_of(settings.n_directions);
    const uint32_t samples = std::min(kSamples, directions.size());
    std::vector<PredictedBytes> bytes(samples);
    parallel_for(samples, threads, [&](size_t i, int) {
        control.check();
        // The middles of equal parts of the directions
        const size_t direction = (2 * i + 1) * directions.size() / (2 * samples);
        SubfieldBuilder builder(settings.shape());
        bytes[i].field = builder.build(triangles.in_ball(), {}, directions.frames()[direction]).bytes();
        bytes[i].builder = builder.bytes();
    });
    uint64_t sum = 0, builder = 0;
    for (const PredictedBytes& b : bytes) {
        sum += b.field;
        // The buffers of a builder grow to those of its largest subfield.
        builder = std::max(builder, b.builder);
    }
    return {triangles.bytes() + uint64_t(double(sum) / samples * directions.size()), builder};
}

uint64_t predicted_bytes(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                         const Control& control) {
    return predicted_peak(triangles, settings, threads, control).field;
}

int check_budget(const FieldTriangles& triangles, const FieldSettings& settings, int threads,
                 const Control& control) {
    const double least = least_bytes(triangles, settings);
    // Far beyond the budget, even a trial build could exhaust memory.
    const bool hopeless = least > 2.0 * double(settings.max_bytes);
    const PredictedBytes bytes =
        hopeless ? PredictedBytes{uint64_t(least), 0} : predicted_peak(triangles, settings, threads, control);
    if (bytes.peak() <= settings.max_bytes) {
        // What the field leaves of the budget is divided among the builders.
        const uint64_t builders = (settings.max_bytes - bytes.field) / std::max<uint64_t>(1, bytes.builder);
        return int(std::min<uint64_t>(uint64_t(resolve_threads(threads)), builders));
    }
    throw OverBudget("the visibility field is predicted to take " + std::string(hopeless ? "at least " : "") +
                     std::to_string(bytes.peak()) + " bytes, max_bytes is " +
                     std::to_string(settings.max_bytes) +
                     (hopeless ? "" : " (" + std::to_string(bytes.builder) + " only while it is built)") +
                     "; " + suggestions(triangles, settings, threads, control));
}

}  // namespace viscache
