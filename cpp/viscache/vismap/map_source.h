#pragma once
// Where renderers ask for maps.
#include <cstddef>
#include <functional>

#include "viscache/vismap/blended_maps.h"

namespace viscache {

/// Maps that speak for points, from any cache. `at` must not change while a frame is rendered.
struct MapSource {
    int m = 5;
    std::function<BlendedMaps(Vec3 position, Vec3 normal, size_t pixel)> at;
    size_t records = 0;  ///< > 0: ids lie below; count how often every record was wrong
};

}  // namespace viscache
