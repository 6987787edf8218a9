#pragma once
// Estimators: each adds one kind of light at the eye points of a tile to the sums of its pixels. Those of a
// thread take its tiles one after another.
#include <memory>
#include <vector>

#include "viscache/render/frame.h"

namespace viscache {

/// Data of a frame that all tiles share.
struct FrameContext : EyePathTracer {
    std::vector<SharedLights> shared;
    const ProductContext* product = nullptr;  ///< product sampling of the environment; nullptr: not used
    const AmbientShares* shares = nullptr;    ///< of shared directions, traced before the tiles
};

/// Sums over the eye points of each pixel of a tile.
struct PixelSums {
    std::array<std::vector<Rgb>, kLightGroups> groups;  ///< empty if the frame lacks the group
    std::vector<Rgb> last_pass;                         ///< of product sampling
    std::vector<Rgb> variance;                          ///< of corrections; empty: not asked for
    std::vector<float> unoccluded;  ///< light of answers that may be wrong, unshadowed; empty: not asked for

    /// Begins a tile of a frame: all 0.
    void begin(const FrameResult& frame, size_t pixels);
    /// Adds the variance that a change of a pixel stands for, by a correction of a share q: change²·(1 − q),
    /// whose expectation over the draw is the variance of the correction.
    void add_variance(uint32_t pixel, Rgb change, float share) {
        if (!variance.empty()) variance[pixel] += change * change * (1 - share);
    }
};

/// What a tile leaves beside its pixels.
struct TileRecord {
    Counters counters;
    StageSeconds stages;
    ProductSeconds product;
    AuditRecords audit;
};

/// A tile in the hands of a thread.
struct TileWork {
    const FrameContext& frame;
    VisibilityOracle& oracle;
    const Control& control;
    QueryAudit* audit = nullptr;  ///< of queries
    LightGroupSet inexact{};      ///< groups of which an answer may be wrong, in all tiles so far
    // Of the tile
    size_t number = 0;
    Tile tile{};
    EyeTile eyes{};
    PixelSums sums{};
    StageClock clock{};

    size_t pixels() const { return size_t(eyes.width) * size_t(eyes.height); }
    EyeShade shade(size_t eye) const {
        return {eyes.block.position[eye], eyes.shading[eye].ng, eyes.shading[eye].ns};
    }
};

class Estimator {
public:
    virtual ~Estimator() = default;
    /// Adds its light of a tile.
    virtual void add(TileWork& work, TileRecord& out) = 0;
    /// After all tiles: adds what it found besides.
    virtual void end(FrameResult& /*out*/) const {}
};

/// Those of one thread, in the order in which they add to a pixel.
std::vector<std::unique_ptr<Estimator>> make_estimators(const FrameContext& frame);

}  // namespace viscache
