#pragma once
// The exact oracle: one ray per query, in the order that traces fastest.
#include <optional>
#include <vector>

#include "viscache/visibility/oracle.h"
#include "viscache/visibility/packet_choice.h"
#include "viscache/visibility/point_order.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

class ExactOracle final : public VisibilityOracle {
public:
    /// Without an order or a flag, each packet gets those that suit it.
    explicit ExactOracle(const RayCaster& caster, std::optional<PacketOrder> order = std::nullopt,
                         std::optional<Coherence> flag = std::nullopt)
        : caster_(caster), order_given_(order), flag_given_(flag) {}

    void begin_tile(const EyeBlock&) override { order_.clear(); }
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

private:
    std::span<const uint32_t> order_of(const EyeBlock& eyes, const FarEnds& lights);
    uint64_t trace_rows(const EyeBlock& eyes, std::span<const uint32_t> order, const FarEnds& lights,
                        const BitMatrix& wanted, BitMatrix& visible);
    size_t rows16_by_light(size_t first, const EyeBlock& eyes, std::span<const uint32_t> order,
                           const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible);
    size_t row_by_pixel(size_t row, uint32_t eye, const EyeBlock& eyes, const FarEnds& lights,
                        const BitMatrix& wanted, BitMatrix& visible);

    /// Traces connections i = 0 … size − 1 of a source, which has eye(i), target(i), ray(i) and
    /// is_direction(i).
    template <class Source>
    void trace_all(const Source& source, const EyeBlock& eyes, std::span<Word> visible, Counters& counters);
    template <class Source>
    void sort_by_direction(const Source& source, const EyeBlock& eyes, Counters& counters);

    const RayCaster& caster_;
    std::optional<PacketOrder> order_given_;
    std::optional<Coherence> flag_given_;
    std::vector<uint32_t> order_;  ///< the tile's eye points along a spatial tree; empty: not sorted so far
    std::vector<uint32_t> order_by_set_;
    BitMatrix wanted_in_order_, visible_in_order_;
    // For `pairs`: direction bins of the connections, and indices sorted by bin
    std::vector<uint16_t> bin_;
    std::vector<uint32_t> order_by_direction_;
    std::vector<uint32_t> begin_;
    std::vector<uint32_t> eye_of_sample_;
};

}  // namespace viscache
