#pragma once
// Audit of a frame whose oracle approximates: a few pixels are also answered by exact rays, which tells how
// large the error of the frame is. Only the frame size and the seed choose these pixels.
#include <array>
#include <memory>
#include <vector>

#include "viscache/render/eye_paths.h"
#include "viscache/render/local_samples.h"
#include "viscache/render/shared_lights.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

/// Sums over the audited pixels. One pixel stands for each block of the frame; its weight w is the number of
/// pixels of the block. With d, the sum over the channels of a pixel's absolute errors, Σ w·d estimates
/// Σ|a − b| of the frame.
struct AuditSums {
    uint64_t pixels = 0;
    uint64_t rays = 0;
    double error = 0;                           ///< Σ w·d
    double square = 0;                          ///< Σ (w·d)²
    std::array<double, kLightGroups> groups{};  ///< Σ w·d of single light groups
    void merge(const AuditSums& b);
};

/// The audited pixels of one tile after another, on one thread.
class TileAudit {
public:
    TileAudit(const FrameSettings& frame, OracleSource& source, const Control& control)
        : frame_(frame), source_(source), control_(control) {}

    void begin_tile(const Tile& tile, const EyeTile& eyes);
    /// Compares the answers of a block. `value(eye, row)`: the light of the visible columns.
    template <class Value>
    void block(const FarEnds& lights, const BitMatrix& wanted, const BitMatrix& visible, Value value) {
        VisibilityOracle* exact = oracle(lights.group, &lights);
        if (!exact || eye_.empty()) return;
        ask_block(*exact, lights, wanted);
        for (size_t k = 0; k < eye_.size(); ++k)
            if (differ(seen_.row_span(k), visible.row_span(eye_[k])))
                add(lights.group, k, value(eye_[k], visible.row(eye_[k])) - value(eye_[k], seen_.row(k)));
    }
    /// Compares the answers of samples of single eye points.
    void samples(const WeightedSamples& samples, std::span<const Word> visible);
    void end_tile(AuditSums& out) const;

private:
    struct Pixel {
        double weight;
        std::array<Rgb, kLightGroups> error;
    };
    /// The exact oracle for a light group; nullptr if its answers need no audit.
    VisibilityOracle* oracle(int group, const FarEnds* lights);
    void ask_block(VisibilityOracle& exact, const FarEnds& lights, const BitMatrix& wanted);
    static bool differ(std::span<const Word> a, std::span<const Word> b);
    void add(int group, size_t k, Rgb error) { pixels_[pixel_of_[k]].error[size_t(group)] += error; }

    struct Auditor {
        bool asked = false;
        std::unique_ptr<VisibilityOracle> oracle;
    };
    const FrameSettings& frame_;
    OracleSource& source_;
    const Control& control_;
    std::array<std::array<Auditor, 2>, kLightGroups> auditors_;  ///< of shared lights, of own samples
    bool audits_ = false;                                        ///< at least one light group is audited
    std::vector<Pixel> pixels_;
    std::vector<uint32_t> eye_, pixel_of_;  ///< the eye points of these pixels, and their pixels
    std::vector<uint32_t> number_;          ///< per eye point of the tile: its number in `eye_`, or kNone
    EyeBlock block_;                        ///< these eye points
    Counters counters_;
    BitMatrix wanted_, seen_;
};

}  // namespace viscache
