#pragma once
// An audit of whole pixels: exact rays answer all queries of all samples of the drawn pixels.
#include "viscache/render/audit.h"
#include "viscache/render/audit_pixels.h"

namespace viscache {

class PixelAudit final : public TileAudit {
public:
    PixelAudit(const FrameSettings& frame, const RayCaster& caster, float extent, const Control& control);
    void begin_tile(const Tile& tile, const EyeTile& eyes) override;
    void block(const AuditedBlock& block) override;
    void samples(const WeightedSamples& samples, std::span<const Word> visible,
                 const VisibilityOracle& oracle) override;
    void end_tile(AuditRecords& out) override;

private:
    void add(int group, size_t k, Rgb error) { pixels_[pixel_of_[k]].error[size_t(group)] += error; }

    ExactOracle exact_;
    std::vector<AuditPixel> drawn_;         ///< of the frame
    std::vector<uint32_t> by_row_;          ///< indices into these, sorted by row and column
    std::vector<AuditedPixel> pixels_;      ///< of the tile
    std::vector<uint32_t> eye_, pixel_of_;  ///< the eye points of these pixels, and their pixels
    std::vector<uint32_t> number_;          ///< per eye point of the tile: its number in `eye_`, or kNone
    EyeBlock block_;                        ///< these eye points
    Counters counters_;
    BitMatrix wanted_, seen_;
};

}  // namespace viscache
