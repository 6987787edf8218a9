#pragma once
// Shafts or packets of rays: by counted work, never by time. The frame decides whether its tree is worth
// building; then each tile decides for each group of lights. The tile's two limits were chosen in twelve
// scenes and hold in twelve others (docs/performance/exact.md). A list of prices for all counters predicted
// the other scenes worse.
#include "viscache/shafts/shaft_kernels.h"

namespace viscache {

/// Queries that a frame may ask per triangle before its tree is built. Building takes the time of 10 to 15
/// rays per triangle, once for all frames: 3 to 8 % of one frame, in which shafts may then save nothing.
constexpr uint64_t kLeastQueriesPerTriangle = 256;
/// Points ask for at least so many lights each, on average; else preparing them costs more than shafts save.
constexpr uint64_t kLeastLightsPerPoint = 12;
/// At least so many queries per packet and light, on average; else shafts answer mostly for points that do
/// not ask, as where points pick a few of many lights.
constexpr uint64_t kLeastQueriesPerPacket = 1;
/// Lights of the first 64 that shafts answer for a trial.
constexpr Word kTrialLights = 0x0101010101010101;
/// Largest share of packets with a ray that shafts leave to be traced. A packet costs as much with one ray.
constexpr double kMostPacketsTraced = 0.33;

inline bool shafts_pay(const ShaftCounts& trial) {
    return double(trial.packets) <= kMostPacketsTraced * double(trial.asked);
}

}  // namespace viscache
