#pragma once
// Renders one frame, tile by tile: eye paths, light groups, visibility oracle.
#include <memory>

#include "viscache/math/parallel.h"
#include "viscache/render/aligned_ambient.h"
#include "viscache/render/audit.h"
#include "viscache/render/environment_product.h"
#include "viscache/render/eye_paths.h"
#include "viscache/render/query_audit.h"
#include "viscache/render/shared_lights.h"
#include "viscache/render/stage_clock.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

/// Real sums of one tile; their order decides the last bits of the sum over a frame.
struct TileSums {
    double lost_throughput = 0, expected_false_hits = 0;
};

struct FrameResult {
    int width = 0, height = 0, spp = 1;
    std::vector<Rgb> color;
    std::vector<Rgb> emitted;
    std::vector<Rgb> seen_emitters;  ///< of bidirectional paths: the part of `emitted` that the camera sees
    std::vector<Rgb> variance;       ///< of corrections, as they estimate it; empty without corrections
    std::vector<Rgb> last_pass;      ///< environment from the last pass; empty if there is one pass only
    std::array<std::vector<Rgb>, kLightGroups> groups;  ///< empty if the group does not exist
    // First hits: means over the samples of a pixel that hit anything; zero if none did
    std::vector<float> depth;
    std::vector<Vec3> normal;
    std::vector<Rgb> albedo;
    std::vector<float> coverage;  ///< share of the samples that hit
    Counters counters;
    std::vector<float> unoccluded;              ///< light without shadows of what may be wrong, for audits
    std::vector<AuditedPixel> audited_pixels;   ///< two of each stratum, one after the other; or all
    std::vector<AuditRecords> audited_queries;  ///< of each tile
    uint64_t audit_rays = 0;
    SourceReport source;  ///< report of the oracle source
    StageSeconds stages;
    ProductSeconds product;               ///< product sampling of the environment; included in `stages`
    std::optional<Forecast> forecast;     ///< for frames with visibility maps
    std::optional<RecordTally> tally;     ///< if the map source numbers its records
    double pilot_s = 0;                   ///< wall seconds of the pilot
    std::optional<EngineChoice> aligned;  ///< for ambient occlusion along shared directions
    double aligned_s = 0;                 ///< wall seconds of its rays and sums
    double lights_s = 0, tiles_s = 0;     ///< wall seconds for VPLs and light groups, and for all tiles
    double prepare_s = 0;                 ///< wall seconds of the source's preparation
    size_t n_vpls = 0;
    int tile_edge_px = 0;
    std::vector<TileSums> tile_sums;  ///< for parts: of each tile
    int threads = 0;
};

/// A frame with the layers that all frames have.
FrameResult sized_result(const FrameSettings& frame);

/// Makes the shared light groups of a frame: point, directional, environment and VPL.
std::vector<SharedLights> make_shared_lights(const Scene& scene, const RayCaster& caster,
                                             const FilmCamera& film, const IntegratorSettings& integrator,
                                             const FrameSettings& frame, Control& control,
                                             Counters& counters);

/// The shared lights of a frame, for later frames that have the same: of the same scene, integrator, frame
/// size and seed. The caller ensures this.
struct KeptLights {
    std::optional<std::vector<SharedLights>> groups;
};

/// Visibility maps for the environment, from any cache.
struct EnvironmentMaps {
    MapSource source;
    VisMapSettings settings;
};

/// `source` must be new: it serves one frame. `aligned` is required if the integrator asks for shared
/// directions. `lights`: shared lights that the frame takes if there are any, and else makes.
FrameResult render_frame(const Scene& scene, const RayCaster& caster, const Camera& camera,
                         const IntegratorSettings& integrator, const FrameSettings& frame,
                         OracleSource& source, Control& control, const EnvironmentMaps* maps = nullptr,
                         const AlignedEngines* aligned = nullptr, KeptLights* lights = nullptr);

}  // namespace viscache
