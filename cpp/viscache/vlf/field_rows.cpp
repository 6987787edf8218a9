#include "viscache/vlf/field_rows.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "viscache/vlf/auto_settings.h"
#include "viscache/vlf/axis_bits.h"
#include "viscache/vlf/predict.h"

namespace viscache {

namespace {

constexpr int kDeepestChosen = 5;  // for settings that leave the depth open (auto_settings.cpp)

void check_axes(const VisibilityField& field, const AlignedInput& input) {
    const auto frames = field.directions().frames();
    bool same = frames.size() == input.axes.size();
    // Exactly equal: a ray beside the axis of its subfield would leave the tile.
    for (size_t k = 0; same && k < frames.size(); ++k) same = frames[k].z == input.axes[k].z;
    if (!same)
        throw std::invalid_argument("the field must have the directions asked for, it has " +
                                    std::to_string(frames.size()) + ", asked for " +
                                    std::to_string(input.axes.size()));
}

/// Lanes of a packet whose ray along an axis, on the side of the normal, is free.
uint16_t free_of(const VisibilityField& field, const PointPackets& points, const AlignedInput& input,
                 size_t p, size_t axis) {
    const Vec3 w = input.axes[axis].z;
    uint32_t free = 0;
    for (uint32_t left = points.asked[p]; left; left &= left - 1) {
        const auto lane = size_t(__builtin_ctz(left));
        const size_t i = points.order[p * kLanes + lane];
        // The side rule of the batch: n·ω = 0 runs along the axis.
        const Vec3 d = dot(w, input.normal[i]) >= 0 ? w : -w;
        const Ray ray{input.origin[i], 0, d, input.t_max};
        free |= uint32_t(!field.any(ray, uint32_t(axis))) << lane;
    }
    return uint16_t(free);
}

}  // namespace

void field_rows(const VisibilityField& field, const AlignedInput& input, std::span<Word> rows, int threads,
                Control& control) {
    check_axes(field, input);
    if (input.origin.empty()) return;
    // Placed as for the batch, so that both refuse the same points and use the same order.
    const PointPackets points(Placement::of(field.scene().bounds()), input.origin, input.normal, control);
    constexpr size_t kPacketsPerCheck = 256;
    rows_by_axis(input.axes.size(), points.packets, points.order, rows, threads, control,
                 [&](size_t axis, PacketRange range, int, uint16_t* free) {
                     // Keeps a lazy subfield alive for all points of an axis.
                     const SubfieldLease kept = field.subfield(uint32_t(axis));
                     for (size_t i = 0; i < range.packets; ++i) {
                         if (i % kPacketsPerCheck == 0) control.check();
                         free[i] = free_of(field, points, input, range.first + i, axis);
                     }
                 });
}

FieldPrediction predict_field_rows(const FieldTriangles& triangles, const FieldSettings& s) {
    FieldPrediction p;
    const double tiles = double(s.n_tiles) * s.n_tiles;
    const double references = expected_references(triangles.in_ball(), s.n_tiles);
    // 0.785 = π/4: the tiles outside the ball's disc are empty.
    const double listed = references / std::max(1.0, 0.785 * tiles);
    const int depth = s.bsp_depth < 0 ? kDeepestChosen : s.bsp_depth;
    const double leaves = 1 << tile_depth(size_t(std::ceil(listed)), depth, s.leaf_target);
    // The ray starts anywhere in its tile and crosses half the leaves on average, its own included.
    p.tests = listed * (1 + 1 / leaves) / 2;
    p.ray_ns = kFieldRayNs + kFieldTestNs * p.tests;
    p.build_s = expected_build_s(triangles, s);
    p.bytes = double(triangles.bytes()) + s.n_directions * (16 * tiles + 4 * references);
    return p;
}

}  // namespace viscache
