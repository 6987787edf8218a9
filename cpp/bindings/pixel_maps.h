#pragma once
// The maps of a cache for the first hits of the pixels of a frame.
#include "arrays.h"
#include "viscache/render/settings.h"
#include "viscache/vismap/map_cache.h"
#include "viscache/vismap/map_source.h"

namespace viscache::bindings {

/// `d_max` and `footprint` hold one entry per pixel of the frame; they and the cache must outlive the result.
inline MapSource pixel_maps(const MapCache& cache, const FrameSettings& frame, const FloatArray& d_max,
                            const FloatArray& footprint) {
    const py::ssize_t pixels = py::ssize_t(frame.width) * frame.height;
    for (const auto* a : {&d_max, &footprint})
        if (a->ndim() != 1 || a->shape(0) != pixels)
            throw py::value_error("d_max and footprint must have one entry per pixel, got " + shape_text(*a));
    const float *reach = d_max.data(), *width = footprint.data();
    // One reader per thread, each with a list of neighbours of its own.
    const auto reader = [&cache, reach, width]() -> MapReader {
        return [&cache, reach, width, around = NeighbourList()](Vec3 position, Vec3 normal,
                                                                size_t pixel) mutable {
            const CachePoint p{position, normal, reach[pixel], width[pixel]};
            return p.usable() ? cache.blend(cache.select(p, around)) : BlendedMaps{.m = cache.parameters().m};
        };
    };
    return {cache.parameters().m, reader, 0};
}

}  // namespace viscache::bindings
