#pragma once
// Ambient occlusion along directions that all eye points of a frame share.
#include "viscache/render/eye_paths.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/engine_choice.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

/// Who traces a frame's shared directions.
struct AlignedEngines {
    const AlignedBatch* batch = nullptr;  ///< nullptr: too few points for the scene's triangles
    const EmbreeCaster& embree;
    const VisibilityField* field = nullptr;  ///< must be there if it is asked for
};

/// What the eye points of a frame see of their hemispheres.
struct AmbientShares {
    std::vector<size_t> first;  ///< number of each tile's first eye point
    std::vector<float> share;   ///< cosine-weighted, in [0, 1]; in the order of `EyePathTracer::trace`
    Counters counters;          ///< of the shadow rays alone
    EngineChoice choice;        ///< of the first run of tiles
    double trace_s = 0;         ///< wall seconds of the shadow rays
};

/// The directions' cells, side by side: axes and solid angles, padded with cells of no size.
struct DirectionCells {
    size_t count = 0;
    std::vector<float> x, y, z, weight;
    explicit DirectionCells(const Directions& directions);
};

/// Share of the hemisphere's cosine-weighted directions that are free: Σ w cosθ V / Σ w cosθ with the solid
/// angles w of the directions' cells. `row` has a bit for each.
float free_share(const DirectionCells& cells, Vec3 normal, std::span<const Word> row);

/// Traces the tiles' eye paths, then all their points' rays along the axes of integrator.n_ambient
/// directions. The engine is chosen for each run of tiles that fits memory, by `choose_engine` if asked.
AmbientShares aligned_ambient(const EyePathTracer& tracer, const std::vector<Tile>& tiles,
                              const AlignedEngines& engines, int threads, Control& control);

}  // namespace viscache
