#pragma once
// Chooses the engine for aligned rays by predicted cost. The choice is a function of the scene and the
// points only. It depends neither on timing nor on threads, so that these change no bits.
#include "viscache/vlf/aligned_sample.h"

namespace viscache {

enum class AlignedEngine { kBatch, kEmbree, kField };

struct EngineChoice {
    AlignedEngine engine = AlignedEngine::kBatch;
    double batch_ns = 0, embree_ns = 0;  ///< predicted cost per ray on one core; 0: not predicted
};

/// Decides without tracing: true if the batch cannot be faster, because each axis would process far more
/// triangles than there are points. Rays that end inside the scene need more points.
bool is_hopeless(const Scene& scene, uint64_t points, float t_max);

/// The order given to Embree. If points are farther apart than triangles, packets of neighbouring points
/// share no work.
AlignedOrder embree_order(uint64_t triangles, uint64_t points);

/// `n` of the axes, spread evenly.
std::vector<size_t> probed_axes(size_t axes, size_t n);

/// Predicts the cost of both engines from the work of the batch, without a decision. `length` is the length
/// of the rays over the size of the scene.
EngineChoice predicted_costs(const AlignedWork& work, AlignedOrder order, float length, Isa isa);

/// Decides by predicted costs: Embree, unless the batch costs less than `share` of it.
EngineChoice decided(EngineChoice costs, double share);

/// Decides by the work for a sample of the rays. If the batch may be faster, decides again by the work for
/// all points along a few axes; if there are too few axes for that, the sample must be clear.
EngineChoice choose_engine(const AlignedBatch& batch, const AlignedInput& input, int threads,
                           Control& control, Isa isa = active_isa());

}  // namespace viscache
