#pragma once
// Which engine traces aligned rays, by predicted cost. A function of scene and points alone: neither timing
// nor threads decide, so that neither changes a bit.
#include "viscache/vlf/aligned_batch.h"

namespace viscache {

enum class AlignedEngine { kBatch, kEmbree, kField };

struct EngineChoice {
    AlignedEngine engine = AlignedEngine::kBatch;
    double batch_ns = 0, embree_ns = 0;  ///< predicted, per ray on one core
};

/// Without tracing: true if the batch cannot pay, because each axis would touch far more triangles than
/// there are points.
bool is_hopeless(uint64_t triangles, uint64_t points);

/// Which order Embree is given: where points lie farther apart than triangles, packets of neighbouring points
/// have nothing in common.
AlignedOrder embree_order(uint64_t triangles, uint64_t points);

/// The axes, of so many, along which work is measured.
std::vector<size_t> probed_axes(size_t axes);

/// What both engines cost by the work that some rays were to the batch, without a decision.
EngineChoice predicted_costs(const AlignedCounts& work, double rays, Isa isa);

/// Decides: Embree where the batch is not clearly cheaper.
EngineChoice decided(EngineChoice costs, bool sparse = false);

/// Predicts the batch's cost from its work along a few of the axes, and Embree's from the same work: how many
/// tests a ray needs tells how crowded its way is.
EngineChoice choose_engine(const AlignedBatch& batch, const AlignedInput& input, int threads,
                           Control& control, Isa isa = active_isa());

}  // namespace viscache
