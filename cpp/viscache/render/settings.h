#pragma once
// Settings of integrators and frames, one row each. What reads the rows: `validate`, the bindings, and the
// help of viscache.Direct, Whitted, AmbientOcclusion and Bdpt.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include "viscache/sampling/zero_two.h"
#include "viscache/visibility/parameter_row.h"
#include "viscache/vlf/directions.h"

namespace viscache {

/// How the environment is sampled.
enum class EnvironmentSampling {
    kMis,      ///< by radiance and by the BRDF, combined by the balance heuristic
    kShared,   ///< by radiance, with the same directions for all eye points
    kProduct,  ///< by light × reflection
};
/// How the directions of ambient occlusion are drawn, and who uses them.
enum class AmbientDistribution { kCosine, kUniform };
enum class AmbientDirections { kPerPoint, kShared };
/// Engine for ambient occlusion along shared directions. kAuto: chosen by predicted cost.
enum class AmbientEngine { kAuto, kBatch, kEmbree, kField };
/// How connections of light paths with the camera are tested.
enum class CameraConnections {
    kKeyed,   ///< through the cache, with the camera as a point
    kBypass,  ///< with one ray each, without the cache
    kOff,     ///< no such connections: the other strategies carry all paths
};

template <>
inline constexpr std::array kNames<EnvironmentSampling>{"mis", "shared", "product"};
template <>
inline constexpr std::array kNames<PointSet>{"independent", "even"};
template <>
inline constexpr std::array kNames<AmbientDistribution>{"cosine", "uniform"};
template <>
inline constexpr std::array kNames<AmbientDirections>{"own", "shared"};
template <>
inline constexpr std::array kNames<AmbientEngine>{"auto", "batch", "embree", "field"};
template <>
inline constexpr std::array kNames<CameraConnections>{"keyed", "bypass", "off"};

/// cosθ is clamped to this in densities of eye points, so that grazing hits keep cells of finite size.
constexpr float kLeastCosine = 0.05f;
/// Candidates per virtual point light that is kept, and the camera points at which they are weighted. More
/// cost time and change the expectation of no frame.
constexpr size_t kVplCandidates = 4, kVplEyePoints = 64;

struct Vpl;

/// A length, 0 for no limit. "auto", as Python writes it, is for the caller to replace.
struct Reach {
    static constexpr double kAuto = -1;
    double distance = kAuto;
};

/// What each is, and its range: the rows of the struct that is made of it for an integrator.
struct IntegratorSettings {
    bool direct = true;                 ///< point, directional, area and environment light
    bool ambient = false;               ///< ambient occlusion instead of light
    bool shade_after_specular = false;  ///< false (Direct): only emission is seen through mirrors and glass
    int max_depth = 1;

    // Samples per eye point
    int n_area = 16;
    int n_environment = 16;
    int n_brdf = 16;
    EnvironmentSampling environment = EnvironmentSampling::kMis;
    int passes = 1;
    PointSet points = PointSet::kZeroTwo;
    bool centred = false;
    int interleave = 1;
    int pick = 0;

    // Virtual point lights
    int n_vpls = 0;
    int vpl_max_depth = 4;
    double vpl_bound = 0.01;
    std::shared_ptr<const std::vector<Vpl>> vpls;  ///< the caller's, used unchanged; nullptr: traced

    // Ambient occlusion
    int n_ambient = 64;
    AmbientDistribution ambient_distribution = AmbientDistribution::kCosine;
    Reach ambient_reach;
    AmbientDirections ambient_directions = AmbientDirections::kPerPoint;
    AmbientEngine ambient_engine = AmbientEngine::kAuto;
};

// clang-format off
inline constexpr std::tuple kSampleRows{
    row("n_area", &IntegratorSettings::n_area, {.low = 0, .high = 1 << 16},
        "Samples per eye point over all area lights together; 0 leaves area lights out. Each chooses its "
        "light by what it can send to the eye point, estimated from its radiance, solid angle and cosines, "
        "without shadows. Up to 16 · `n_area` triangles and spheres (256 at most) are estimated one by one; "
        "a tree over the lights (Conty Estevez, Kulla 2018) serves more."),
    row("n_environment", &IntegratorSettings::n_environment, {.low = 0, .high = 1 << 16},
        "Samples per eye point of the environment by its radiance."),
    row("n_brdf", &IntegratorSettings::n_brdf, {.low = 0, .high = 1 << 16},
        "Samples per eye point by the BRDF: of the environment, and at glossy points of area lights. They "
        "are combined with those of the lights by the balance heuristic (Veach, Guibas 1995). Beside shared "
        "directions, they are of the environment by sharp lobes alone, and are dealt to the sets of "
        "`interleave` as the directions are. A lobe is sharp if its peak is at least three times the "
        "reflection of a diffuse surface of the same albedo."),
    row("interleave", &IntegratorSettings::interleave, {.low = 1, .high = 1 << 16},
        "Sets to which shared directions are dealt; the eye points of a pixel ask the sets in turns, so each "
        "costs `n_environment` / `interleave` rays. With as many samples per pixel, a pixel asks all "
        "directions once (interleaved sampling, Keller, Heidrich 2001), and rays of the same set stay as "
        "coherent as those of all."),
    row("pick", &IntegratorSettings::pick, {.low = 0, .high = 1 << 20},
        "Lights that each eye point picks from each group that all eye points share: point and spot lights, "
        "directional lights, shared directions, virtual point lights. Only these are asked for. They are "
        "picked by their contribution without shadows (systematic sampling), and weighted by the inverse of "
        "their probability, so the expectation is the sum over all lights. 0: all lights, and also where at "
        "most `pick` lights contribute."),
};
inline constexpr std::tuple kDirectRows = std::tuple_cat(kSampleRows, std::tuple{
    row("environment", &IntegratorSettings::environment,
        "\"mis\": as `n_environment` and `n_brdf` say. \"shared\": `n_environment` directions drawn by "
        "radiance once per frame, the same for all eye points. The error then appears as bands instead of "
        "noise. Tiles are answered as a whole: by level waves of `Aqvc`, or by the aligned batch of "
        "`Exact(sky_engine=\"auto\")`. \"product\": `n_environment` directions per eye point and pass, drawn "
        "by light × reflection, without `n_brdf`. `VisMaps` always does this."),
    row("passes", &IntegratorSettings::passes, {.low = 1, .high = 1 << 16},
        "Independent passes of product samples; the image is their mean, the layer "
        "\"environment_last_pass\" the last one alone."),
    row("points", &IntegratorSettings::points,
        "Product samples: a randomised (0, 2)-sequence (\"even\"), or independent ones."),
    row("centred", &IntegratorSettings::centred,
        "Primary rays go through the centres of pixels instead of random positions. There is no "
        "antialiasing; for comparisons of variance."),
});
inline constexpr std::tuple kWhittedRows = std::tuple_cat(kSampleRows, std::tuple{
    row("environment", &IntegratorSettings::environment, {.high = double(EnvironmentSampling::kShared)},
        "As for `Direct`."),
    row("n_vpls", &IntegratorSettings::n_vpls, {.low = 0, .high = 1 << 20},
        "Number of virtual point lights; it may be smaller, because equal ones are merged."),
    row("max_depth", &IntegratorSettings::max_depth, {.low = 0, .high = 16},
        "Mirror and glass bounces of an eye path. Glass splits a path in two. Branches with less than 0.3 % "
        "of a sample continue by Russian roulette (noise below 0.2 % of a sample). "
        "`frame.counters[\"lost_throughput\"]` counts what `max_depth` cuts off."),
    row("vpl_max_depth", &IntegratorSettings::vpl_max_depth, {.low = 1, .high = 64},
        "Bounces of a light path."),
    row("vpl_bound", &IntegratorSettings::vpl_bound, {.low = 0, .high = 1},
        "Bounds the geometry term cos·cos/(d² + (vpl_bound · scene diagonal)²); 0: unbounded."),
    row("vpls", &IntegratorSettings::vpls,
        "Virtual point lights of your own; `n_vpls` and the parameters of tracing are not used."),
});
inline constexpr std::tuple kAmbientRows{
    row("n_samples", &IntegratorSettings::n_ambient, {.low = 1, .high = 1 << 20},
        "Directions per eye point."),
    row("distribution", &IntegratorSettings::ambient_distribution,
        "How directions are drawn; both give the cosine-weighted share."),
    row("max_distance", &IntegratorSettings::ambient_reach,
        "Length of the rays in scene units; farther occluders do not count. \"auto\": a tenth of the "
        "diagonal of the scene's bounding box, so that closed rooms are not black. "
        "`frame.parameters[\"integrator\"]` has the number. None or inf: no limit."),
    row("directions", &IntegratorSettings::ambient_directions,
        "\"own\": each eye point draws its directions. \"shared\": all eye points use the directions of "
        "`vlf.directions` on their side (VLF Sec. 7), weighted by solid angle and cosine. This costs several "
        "times less and has no noise, but all pixels miss what these directions miss. `n_samples` must be "
        "one of vlf.DIRECTION_COUNTS, e.g. 513. `distribution` and the frame's seed are not used."),
    row("engine", &IntegratorSettings::ambient_engine,
        "The engine for shared directions, as in `vlf.trace_aligned`. \"auto\" does not use the field, "
        "because its build takes longer than one frame gains."),
};
// clang-format on

/// Throws std::invalid_argument unless the sets of directions fit.
inline void check_interleave(const IntegratorSettings& s) {
    detail::require(s.interleave == 1 || s.environment == EnvironmentSampling::kShared,
                    "interleave must be 1 without environment=\"shared\"", s.interleave);
    detail::require(s.interleave <= std::max(1, s.n_environment),
                    "interleave must be >= 1 and at most n_environment", s.interleave);
}

struct DirectSettings : IntegratorSettings {
    void validate() const {
        check_rows(kDirectRows, *this);
        check_interleave(*this);
    }
};
struct WhittedSettings : IntegratorSettings {
    WhittedSettings() {
        shade_after_specular = true;
        n_vpls = 1024;
        max_depth = 8;
    }
    void validate() const {
        check_rows(kWhittedRows, *this);
        check_interleave(*this);
    }
};
struct AmbientSettings : IntegratorSettings {
    AmbientSettings() {
        direct = false;
        ambient = true;
        max_depth = 0;
    }
    void validate() const {
        check_rows(kAmbientRows, *this);
        const bool own = ambient_directions == AmbientDirections::kPerPoint;
        detail::require(own || is_direction_count(uint64_t(n_ambient)),
                        "n_samples must be 1 or 2·4^k + 1 up to 8193, e.g. 513, with shared directions",
                        n_ambient);
    }
};

struct BdptSettings {
    int max_depth = 8;
    CameraConnections camera_connections = CameraConnections::kKeyed;
    void validate() const;
};

// clang-format off
inline constexpr std::tuple kBdptRows{
    row("max_depth", &BdptSettings::max_depth, {.low = 1, .high = 64},
        "Edges of a path as Mitsuba counts them: 1 = emission seen directly, 2 = direct light."),
    row("camera_connections", &BdptSettings::camera_connections,
        "Connections of light paths with the camera. \"keyed\": through the cache, if there is one, with the "
        "camera as a point. \"bypass\": a shadow ray each, without the cache. \"off\": none, so only eye "
        "paths find caustics."),
};
// clang-format on

inline void BdptSettings::validate() const { check_rows(kBdptRows, *this); }

struct FrameSettings {
    int width = 640, height = 400;
    int spp = 1;
    uint64_t seed = 0;
    uint64_t first_sample = 0;  ///< not for bidirectional paths
    int threads = 0;
    /// Only for frames whose tiles are independent of each other: not for visibility maps, aligned rays or
    /// bidirectional paths.
    int part = 0, parts = 1;
    // Audits, for frames of tiles of eye points. 0: none
    size_t audit_pixels = 0;
    double audit_share = 0;
    float audit_above = 4;
    void validate() const;
};

// clang-format off
inline constexpr std::tuple kFrameRows{
    row("width", &FrameSettings::width, {.low = 1, .high = 1 << 16}, "Pixels."),
    row("height", &FrameSettings::height, {.low = 1, .high = 1 << 16}, "Pixels."),
    row("spp", &FrameSettings::spp, {.low = 1, .high = 1 << 20}, "Eye samples per pixel."),
    row("seed", &FrameSettings::seed, {.low = 0}, "Of all random choices."),
    row("first_sample", &FrameSettings::first_sample, {.low = 0, .high = 0x1p31 - 1},
        "Number of the first eye sample of every pixel, a multiple of spp: a frame that goes on where another "
        "ended has its seed, and new samples of the same lights."),
    row("threads", &FrameSettings::threads, {.low = 0, .high = 1024},
        "0: all cores."),
    row("part", &FrameSettings::part, {.low = 0, .high = (1 << 20) - 1},
        "Every `parts`-th tile is rendered, from number `part` on. The other pixels stay 0."),
    row("parts", &FrameSettings::parts, {.low = 1, .high = 1 << 20}, "Parts of the frame."),
    row("audit_pixels", &FrameSettings::audit_pixels, {.low = 0, .high = 1 << 24},
        "Whole pixels that an audit traces again, about."),
    row("audit_share", &FrameSettings::audit_share, {.low = 0, .high = 1},
        "Share of the queries below `audit_above` that an audit traces."),
    row("audit_above", &FrameSettings::audit_above, {.low = 0, .high = 1e6},
        "An audit of queries traces all whose contribution exceeds so many means of their eye point or tile."),
};
// clang-format on

inline void FrameSettings::validate() const {
    check_rows(kFrameRows, *this);
    detail::require(part < parts, "part must be < parts", part);
}

}  // namespace viscache
