#pragma once
// The interface through which renderers obtain maps.
#include <cstddef>
#include <functional>

#include "viscache/vismap/blended_maps.h"

namespace viscache {

/// Returns the maps for a point seen through a pixel of the frame.
using MapReader = std::function<BlendedMaps(Vec3 position, Vec3 normal, size_t pixel)>;

/// Maps from any cache. The cache must not change while a frame is rendered.
struct MapSource {
    int m = 5;
    std::function<MapReader()> reader;  ///< creates a reader for each thread
    size_t records = 0;                 ///< > 0: ids are smaller than this; errors are counted per record
};

}  // namespace viscache
