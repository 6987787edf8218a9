#pragma once
// The exact oracle: one ray per question, in the order that traces fastest.
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Which rays share a packet. Speed only: the answers are the same.
enum class PacketOrder {
    kByLight,  ///< 16 neighbouring eye points towards one light: the fastest
    kByPixel,  ///< one eye point towards 16 lights
};

class ExactOracle final : public VisibilityOracle {
public:
    /// `extent` is Scene::offset_extent.
    ExactOracle(const RayCaster& caster, float extent, PacketOrder order = PacketOrder::kByLight,
                Coherence coherence = Coherence::kCoherent)
        : caster_(caster), extent_(extent), order_(order), coherence_(coherence) {}

    void begin_tile(const EyeBlock&) override {}
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;

private:
    void block_by_light(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible);
    void block_by_pixel(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible);

    const RayCaster& caster_;
    float extent_;
    PacketOrder order_;
    Coherence coherence_;
};

/// Number of set bits of a matrix.
uint64_t count_bits(const BitMatrix& m);

}  // namespace viscache
