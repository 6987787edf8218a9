#pragma once
// Where renderers ask for maps.
#include <cstddef>
#include <functional>

#include "viscache/vismap/blended_maps.h"

namespace viscache {

/// Maps that speak for a point seen through a pixel of the frame.
using MapReader = std::function<BlendedMaps(Vec3 position, Vec3 normal, size_t pixel)>;

/// Maps from any cache, which must not change while a frame is rendered.
struct MapSource {
    int m = 5;
    std::function<MapReader()> reader;  ///< makes one for each thread
    size_t records = 0;                 ///< > 0: ids lie below; count how often every record was wrong
};

}  // namespace viscache
