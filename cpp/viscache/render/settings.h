#pragma once
// Settings of a frame. Names and defaults equal those of the Python dataclasses; a test checks this.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "viscache/sampling/zero_two.h"

namespace viscache {

/// How the density of eye points is estimated.
enum class PMode {
    kLastVertex,  ///< camera density at the unfolded path length
    kFootprint,   ///< ray differentials
};

/// How one of several area lights is chosen for a sample.
enum class LightChoice {
    kContribution,  ///< by its estimated contribution to the eye point, without shadows
    kPower,
};

/// How the environment is sampled.
enum class EnvironmentSampling {
    kMis,      ///< by radiance and by the BRDF, combined by the balance heuristic
    kProduct,  ///< by light × reflection
    kShared,   ///< by radiance, with the same directions for all eye points
};

/// Engine for ambient occlusion along shared directions.
enum class AmbientEngine {
    kAuto,  ///< chosen by predicted cost
    kBatch,
    kEmbree,
    kField,
};

struct Vpl;

struct IntegratorSettings {
    // Light transport
    bool direct = true;                 ///< point, directional, area and environment light
    bool ambient = false;               ///< ambient occlusion instead of light
    int n_vpls = 0;                     ///< virtual point lights (Whitted); 0 = none
    int max_depth = 1;                  ///< largest number of specular bounces of an eye path
    bool shade_after_specular = false;  ///< false (Direct): only emission is seen through mirrors and glass

    // Samples per eye point
    int n_area = 16;  ///< light samples, over all area lights
    LightChoice light_choice = LightChoice::kContribution;
    int n_environment = 16;  ///< light samples of the environment
    int n_brdf = 16;  ///< BRDF samples of the environment, and at glossy points of area lights; beside shared
                      ///< directions, of sharp lobes alone, and dealt to the sets
    EnvironmentSampling environment = EnvironmentSampling::kMis;
    int passes = 1;  ///< passes of n_environment product samples each
    PointSet points = PointSet::kZeroTwo;
    bool centred = false;  ///< primary rays through the centres of pixels
    int n_ambient = 64;
    bool ambient_cosine = true;      ///< false: uniform directions
    float ambient_max_distance = 0;  ///< 0 = unlimited
    bool ambient_aligned = false;    ///< along the n_ambient directions of a visibility field
    AmbientEngine ambient_engine = AmbientEngine::kAuto;

    // Virtual point lights
    std::shared_ptr<const std::vector<Vpl>> vpls;  ///< the caller's VPLs, used unchanged; nullptr: traced
    int vpl_max_depth = 4;                         ///< bounces after the light
    int vpl_candidates = 4;                        ///< candidates per VPL that is kept
    int vpl_eye_points = 64;                       ///< camera points at which candidates are weighted
    float vpl_bound = 0.01f;  ///< × scene diagonal; its square is added to d²; 0 = unbounded

    int interleave = 1;  ///< sets of shared directions, which the eye points of a pixel ask in turns
    int pick = 0;        ///< lights per eye point of each group that all eye points share; 0 = all

    PMode p_mode = PMode::kLastVertex;
    float cosmin = 0.05f;  ///< cosθ is clamped to this in densities
};

struct FrameSettings {
    int width = 640, height = 400;
    int spp = 1;
    uint64_t seed = 0;
    /// Number of the first eye sample of every pixel: a frame that goes on where another ended has its seed,
    /// and new samples of the same lights. A multiple of spp. Not for bidirectional paths.
    uint64_t first_sample = 0;
    int threads = 0;  ///< 0 = all
    /// Renders every `parts`-th tile from number `part` on. The other pixels stay 0. Only for frames whose
    /// tiles are independent of each other: not for visibility maps, aligned rays or bidirectional paths.
    int part = 0, parts = 1;
    /// Audits, for frames of tiles of eye points: of about so many whole pixels, or of the queries whose
    /// contribution exceeds `audit_above` means of their eye point or tile and of a share of the others. 0 =
    /// none.
    size_t audit_pixels = 0;
    double audit_share = 0;
    float audit_above = 4;
};

}  // namespace viscache
