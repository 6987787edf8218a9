#include "viscache/vlf/aligned_oracle.h"

#include "viscache/visibility/shadow_ray.h"

namespace viscache {

void AlignedOracle::watch(const Control& control) {
    control_ = &control;
    exact_.watch(control);
}

void AlignedOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                          BitMatrix& visible, Counters& counters) {
    if (!is_direction(lights.semantic) || !by_batch(eyes, lights, wanted, visible, counters))
        exact_.block(eyes, lights, wanted, visible, counters);
}

/// Returns false if Embree must trace the block.
bool AlignedOracle::by_batch(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                             BitMatrix& visible, Counters& counters) {
    const uint64_t rays = count_bits(wanted);
    counters.direction_rays += rays;
    if (rays == 0 || lights.count == 0) return false;
    if (choose_ && is_hopeless(*batch_.triangles().scene, eyes.size(), lights.t_max)) return false;
    if (!fits_batch(batch_, eyes.origin)) return false;
    DirectionBlock block(batch_, eyes, lights, wanted, 1, *control_);
    if (choose_) {
        const EngineChoice choice = block.choose(active_isa());
        counters.batch_ns += choice.batch_ns * double(rays);
        counters.embree_ns += choice.embree_ns * double(rays);
        counters.predicted_rays += rays;
        if (choice.engine == AlignedEngine::kEmbree) return false;
    }
    block.trace(visible, active_isa());
    GroupCounters& group = counters.group(lights.group);
    group.queries += rays;
    group.rays += rays;
    group.occluded += rays - count_bits(visible);
    counters.batch_rays += rays;
    return true;
}

}  // namespace viscache
