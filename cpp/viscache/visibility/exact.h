#pragma once
// The exact oracle: one ray per query, in the order that traces fastest.
#include <optional>
#include <vector>

#include "viscache/visibility/coherence_trial.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/point_order.h"
#include "viscache/visibility/query.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// The rays that share a packet. Affects speed only; Embree's flag also one answer in 10⁹
/// (coherence_trial.h).
enum class PacketOrder {
    kByLight,  ///< 16 neighbouring eye points towards one light: the fastest. Neighbours in space where many
               ///< lights share the cost of sorting, else in the order of the tile
    kByPixel,  ///< one eye point towards 16 lights
};

class ExactOracle final : public VisibilityOracle {
public:
    /// `extent` is Scene::offset_extent. Without an order or a flag, short trials select the fastest.
    ExactOracle(const RayCaster& caster, float extent, std::optional<PacketOrder> order = std::nullopt,
                std::optional<Coherence> flag = std::nullopt)
        : caster_(caster),
          extent_(extent),
          by_light_(order != PacketOrder::kByPixel),
          block_plan_(plans(order, flag), {}, 1024),
          pairs_flag_(flag) {}

    void begin_tile(const EyeBlock&) override { order_.clear(); }
    void log(QueryLog* log) override { log_ = log; }
    bool is_exact(const FarEnds&) const override { return true; }
    bool is_exact_own(int) const override { return true; }
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override;

private:
    struct Plan {
        PacketOrder order;
        Coherence flag;
    };
    static std::vector<Plan> plans(std::optional<PacketOrder> order, std::optional<Coherence> flag);
    std::span<const uint32_t> order_of(const EyeBlock& eyes, const FarEnds& lights);
    uint64_t trace_rows(const EyeBlock& eyes, std::span<const uint32_t> order, const FarEnds& lights,
                        const BitMatrix& wanted, BitMatrix& visible);
    size_t rows16_by_light(size_t first, const EyeBlock& eyes, std::span<const uint32_t> order,
                           const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
                           Coherence flag);
    size_t row_by_pixel(size_t row, uint32_t eye, const EyeBlock& eyes, const FarEnds& lights,
                        const BitMatrix& wanted, BitMatrix& visible, Coherence flag);

    /// Traces connections i = 0 … size − 1 of a source, which has eye(i), target(i), ray(i) and
    /// is_direction(i).
    template <class Source>
    void trace_all(const Source& source, const EyeBlock& eyes, std::span<Word> visible, Counters& counters);
    template <class Source>
    void sort_by_direction(const Source& source, const EyeBlock& eyes, Counters& counters);

    const RayCaster& caster_;
    float extent_;
    bool by_light_;  ///< packets of eye points may be traced
    QueryLog* log_ = nullptr;
    Trial<Plan> block_plan_;
    std::vector<uint32_t> order_;  ///< the tile's eye points along a spatial tree; empty: not sorted so far
    std::vector<uint32_t> order_by_set_;
    BitMatrix wanted_in_order_, visible_in_order_;
    CoherenceTrial pairs_flag_;
    // For `pairs` and `samples`: direction bins of the connections, and indices sorted by bin
    std::vector<uint16_t> bin_;
    std::vector<uint32_t> order_by_direction_;
    std::vector<uint32_t> begin_;
    std::vector<uint32_t> eye_of_sample_;
};

/// Number of set bits.
uint64_t count_bits(std::span<const Word> words);
uint64_t count_bits(const BitMatrix& m);

}  // namespace viscache
