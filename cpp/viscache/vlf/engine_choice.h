#pragma once
// Chooses the engine for aligned rays by predicted cost. The choice is a function of the scene and the
// points only. It depends neither on timing nor on threads, so that these change no bits.
#include "viscache/vlf/aligned_batch.h"

namespace viscache {

enum class AlignedEngine { kBatch, kEmbree, kField };

struct EngineChoice {
    AlignedEngine engine = AlignedEngine::kBatch;
    double batch_ns = 0, embree_ns = 0;  ///< predicted cost per ray on one core
};

/// Decides without tracing: true if the batch cannot be faster, because each axis would process far more
/// triangles than there are points.
bool is_hopeless(uint64_t triangles, uint64_t points);

/// The order given to Embree. If points are farther apart than triangles, packets of neighbouring points
/// share no work.
AlignedOrder embree_order(uint64_t triangles, uint64_t points);

/// The axes along which the work is measured.
std::vector<size_t> probed_axes(size_t axes);

/// Predicts the cost of both engines from the work of the batch for some rays, without a decision.
EngineChoice predicted_costs(const AlignedCounts& work, double rays, Isa isa);

/// Makes the decision: Embree, unless the batch is clearly cheaper.
EngineChoice decided(EngineChoice costs, bool sparse = false);

/// Measures the work of the batch along a few of the axes and predicts the cost of both engines from it. The
/// number of tests per ray is a measure of the depth complexity, which determines the cost of Embree.
EngineChoice choose_engine(const AlignedBatch& batch, const AlignedInput& input, int threads,
                           Control& control, Isa isa = active_isa());

}  // namespace viscache
