#pragma once
// What a frame is asked to be. The same names and defaults as the Python dataclasses; a test pins them
// together.
#include <cstdint>
#include <memory>
#include <vector>

#include "viscache/sampling/zero_two.h"

namespace viscache {

/// Where the density of an eye point comes from.
enum class PMode {
    kLastVertex,  ///< camera density with the unfolded length of the path
    kFootprint,   ///< ray differentials
};

/// How the environment is sampled.
enum class EnvironmentSampling {
    kMis,      ///< by its radiance and by the BRDF, combined by the balance heuristic
    kProduct,  ///< by light × reflection
    kShared,   ///< by its radiance, the same directions for all eye points
};

/// Who traces ambient occlusion along shared directions.
enum class AmbientEngine {
    kAuto,  ///< by predicted cost
    kBatch,
    kEmbree,
    kField,
};

struct Vpl;

struct IntegratorSettings {
    // Which parts are on
    bool direct = true;    ///< point, directional, area and environment light
    bool ambient = false;  ///< ambient occlusion instead of light
    int n_vpls = 0;        ///< virtual point lights (Whitted); 0 = none
    int max_depth = 1;     ///< specular bounces of an eye path that are followed
    bool shade_after_specular =
        false;  ///< false (Direct): after a mirror or glass only emission is collected

    // Samples per eye point
    int n_area = 16;         ///< over all area lights together, chosen by power
    int n_environment = 16;  ///< light samples of the environment
    int n_brdf = 16;         ///< BRDF samples of the environment; both combined by the balance heuristic
    EnvironmentSampling environment = EnvironmentSampling::kMis;
    int passes = 1;  ///< of n_environment product samples each
    PointSet points = PointSet::kZeroTwo;
    bool centred = false;  ///< primary rays through the centres of pixels
    int n_ambient = 64;
    bool ambient_cosine = true;      ///< false: uniform directions
    float ambient_max_distance = 0;  ///< 0 = unlimited
    bool ambient_aligned = false;    ///< along the n_ambient directions of a visibility field
    AmbientEngine ambient_engine = AmbientEngine::kAuto;

    // Virtual point lights
    std::shared_ptr<const std::vector<Vpl>> vpls;  ///< the caller's own, taken as they are; else traced
    int vpl_max_depth = 4;                         ///< bounces after the light
    int vpl_candidates = 4;                        ///< candidates per VPL that is kept
    int vpl_eye_points = 64;                       ///< camera points that judge the candidates
    float vpl_bound = 0.01f;  ///< × scene diagonal: added (squared) to d² in the geometry term; 0 = unbounded

    PMode p_mode = PMode::kLastVertex;
    float cosmin = 0.05f;  ///< cosθ is clamped to this in densities
};

struct FrameSettings {
    int width = 640, height = 400;
    int spp = 1;
    uint64_t seed = 0;
    int threads = 0;  ///< 0 = all
    /// Every `parts`-th tile from number `part` on is rendered; pixels elsewhere stay 0. For frames whose
    /// tiles depend on nothing but themselves and the lights: not for visibility maps, aligned rays or
    /// bidirectional paths.
    int part = 0, parts = 1;
};

}  // namespace viscache
