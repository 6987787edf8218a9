#pragma once
// Ambient occlusion along directions that all eye points of a frame share.
#include "viscache/render/eye_paths.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/engine_choice.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// Engines that can trace the shared directions of a frame.
struct AlignedEngines {
    const AlignedBatch* batch = nullptr;  ///< nullptr: too few points for the number of triangles
    const EmbreeCaster& embree;
    const VisibilityField* field = nullptr;  ///< required if the field engine is asked for
};

/// Unoccluded share of the hemisphere of every eye point.
struct AmbientShares {
    std::vector<size_t> first;  ///< index of the first eye point of each tile
    std::vector<float> share;   ///< cosine-weighted, in [0, 1]; in the order of `EyePathTracer::trace`
    Counters counters;          ///< of the shadow rays alone
    EngineChoice choice;        ///< of the first run of tiles
    double trace_s = 0;         ///< wall seconds of the shadow rays
};

/// Axes and solid angles of the directions' cells as arrays, padded with cells of size zero.
struct DirectionCells {
    size_t count = 0;
    std::vector<float> x, y, z, weight;
    explicit DirectionCells(const Directions& directions);
};

/// Cosine-weighted share of the hemisphere that is unoccluded: Σ w cosθ V / Σ w cosθ. The weights w are the
/// solid angles of the directions' cells. `row` has one bit per direction.
float free_share(const DirectionCells& cells, Vec3 normal, std::span<const Word> row);

/// Traces the eye paths of the tiles, then the rays of all their points along the axes of
/// integrator.n_ambient directions. Tiles are grouped into runs that fit in memory. `choose_engine` chooses
/// the engine for each run if the settings ask for that.
AmbientShares aligned_ambient(const EyePathTracer& tracer, const std::vector<Tile>& tiles,
                              const AlignedEngines& engines, int threads, Control& control);

}  // namespace viscache
