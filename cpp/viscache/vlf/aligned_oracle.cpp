#include "viscache/vlf/aligned_oracle.h"

#include "viscache/visibility/shadow_ray.h"

namespace viscache {

Answer AlignedOracle::block(const BlockAsk& ask, Counters& counters) {
    // Local lights have no common direction; only skies and distant lights suit the batch.
    BitMatrix* bits = is_direction(ask.lights.semantic) ? by_batch(ask, counters) : nullptr;
    return {.bits = bits ? bits : exact_.block(ask, counters).bits};
}

/// Returns nullptr if Embree must trace the block.
BitMatrix* AlignedOracle::by_batch(const BlockAsk& ask, Counters& counters) {
    const FarEnds& lights = ask.lights;
    const uint64_t rays = count_bits(ask.wanted);
    // Counts the rays of directions, whoever traces them, so that `report` can say which share the batch
    // took.
    counters.direction_rays += rays;
    if (rays == 0 || lights.count == 0) return nullptr;
    // Cheap refusals come first: DirectionBlock sorts the points, and `choose` traces along some axes.
    if (choose_ && is_hopeless(*batch_.triangles().scene, ask.eyes.size(), lights.t_max)) return nullptr;
    if (!fits_batch(batch_, ask.eyes.origin)) return nullptr;
    DirectionBlock block(batch_, ask.eyes, lights, ask.wanted, 1, control());
    if (choose_) {
        const EngineChoice choice = block.choose(active_isa());
        counters.batch_ns += choice.batch_ns * double(rays);
        counters.embree_ns += choice.embree_ns * double(rays);
        counters.predicted_rays += rays;
        if (choice.engine == AlignedEngine::kEmbree) return nullptr;
    }
    BitMatrix& visible = new_bits(ask.wanted.rows(), ask.wanted.columns());
    block.trace(visible, active_isa());
    GroupCounters& group = counters.group(lights.group);
    group.queries += rays;
    group.rays += rays;
    group.occluded += rays - count_bits(visible);
    counters.batch_rays += rays;
    return &visible;
}

}  // namespace viscache
