#pragma once
// The near ends of a tile: camera paths through mirrors and glass, stored as eye points.
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/render/settings.h"
#include "viscache/render/tiles.h"
#include "viscache/scene/bsdf.h"
#include "viscache/scene/film_camera.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/counters.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// What the camera's own samples of a pixel hit first, mirrors and glass included: sums over `count` hits.
struct FirstHits {
    uint32_t count = 0;
    float depth = 0;  ///< distances from the camera
    Vec3 normal;      ///< unit shading normals on the side of the camera
    Rgb albedo;       ///< base colours
};

/// Eye points with what shading needs, beside the oracle's EyeBlock; index i is the same eye point in all
/// arrays.
struct EyeTile {
    EyeBlock block;
    std::vector<ShadingPoint> shading;
    std::vector<Rgb> throughput;
    std::vector<uint32_t> pixel;  ///< index into the tile's pixels, row-major
    std::vector<uint64_t>
        stream;  ///< key of the eye point's random numbers: unique in the frame, free of tiles and threads

    // Per pixel of the tile, row-major
    int width = 0, height = 0;
    std::vector<Rgb>
        emitted;  ///< light that reaches the eye without a connection: emitters and environment seen
    std::vector<FirstHits> first;

    void reset(int width, int height);
    size_t size() const { return block.size(); }
};

/// Everything about the camera paths of a frame.
struct EyePathTracer {
    const Scene& scene;
    const RayCaster& caster;
    FilmCamera film;
    IntegratorSettings integrator;
    FrameSettings frame;

    /// Traces all samples of the tile's pixels, along its Morton curve.
    void trace(const Tile& tile, EyeTile& out, Counters& counters, const Control& control) const;
};

}  // namespace viscache
