#pragma once
// What bidirectional path tracing is asked to be. The same names and defaults as the Python dataclass.

namespace viscache {

/// Light paths that are connected to the camera.
enum class CameraConnections {
    kBypass,  ///< a ray each, past any cache
    kKeyed,   ///< through the cache, with the camera as a point
    kOff,     ///< none: the other strategies carry all paths
};

struct BdptSettings {
    int max_depth = 8;  ///< edges of a path, 1 = emission seen directly
    CameraConnections camera_connections = CameraConnections::kKeyed;
    float cosmin = 0.05f;  ///< cosθ is clamped to this in the cache's densities
};

}  // namespace viscache
