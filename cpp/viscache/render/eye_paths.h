#pragma once
// Eye paths of a tile: camera rays through mirrors and glass, and the eye points where they end.
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/render/settings.h"
#include "viscache/render/tiles.h"
#include "viscache/sampling/pixel_place.h"
#include "viscache/scene/bsdf.h"
#include "viscache/scene/film_camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/counters.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// First hits of the camera rays of a pixel, mirrors and glass included: sums over `count` hits.
struct FirstHits {
    uint32_t count = 0;
    float depth = 0;  ///< distances from the camera
    Vec3 normal;      ///< unit shading normals on the side of the camera
    Rgb albedo;       ///< base colours
};

/// Bits of `EyeTile::stream` that tell branches of a sample apart.
constexpr int kBranchBits = 10;
constexpr uint64_t kBranches = uint64_t{1} << kBranchBits;

/// Eye points with the data for shading and the EyeBlock for the oracle. All arrays use the same index.
struct EyeTile {
    EyeBlock block;
    std::vector<ShadingPoint> shading;
    std::vector<Rgb> throughput;
    std::vector<uint32_t> pixel;   ///< index into the tile's pixels, row-major
    std::vector<uint64_t> stream;  ///< random-number key: unique in the frame, free of tiles and threads
    uint64_t first_sample = 0;     ///< of the frame (FrameSettings)

    // Per pixel of the tile, row-major
    int width = 0, height = 0;
    std::vector<Rgb> emitted;  ///< light that needs no connection: visible emitters and environment
    std::vector<FirstHits> first;

    void reset(int width, int height);
    size_t size() const { return block.size(); }
    /// The sequences of a pixel's light samples: frames that go on from each other share `sequence()`, a
    /// number, and `sample()` counts the pixel's samples in it. Their key is `block.place`.
    uint64_t sequence() const { return first_sample / kSamplesPerSequence; }
    uint32_t sample(size_t eye) const { return block.turn[eye] - uint32_t(sequence() * kSamplesPerSequence); }
    uint32_t sample_of_frame(size_t eye) const { return block.turn[eye] - uint32_t(first_sample); }
};

/// Traces the eye paths of a frame.
struct EyePathTracer {
    const Scene& scene;
    const RayCaster& caster;
    FilmCamera film;
    IntegratorSettings integrator;
    FrameSettings frame;

    /// Traces all samples of a tile, pixel by pixel along its Morton curve.
    void trace(const Tile& tile, EyeTile& out, Counters& counters, const Control& control) const;
};

}  // namespace viscache
