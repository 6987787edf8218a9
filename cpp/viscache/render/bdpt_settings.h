#pragma once
// Settings of bidirectional path tracing. Names and defaults equal those of the Python dataclass.

namespace viscache {

/// How connections of light paths with the camera are tested.
enum class CameraConnections {
    kBypass,  ///< with one ray each, without the cache
    kKeyed,   ///< through the cache, with the camera as a point
    kOff,     ///< no such connections: the other strategies carry all paths
};

struct BdptSettings {
    int max_depth = 8;  ///< edges of a path; 1: emission seen directly
    CameraConnections camera_connections = CameraConnections::kKeyed;
    float cosmin = 0.05f;  ///< cosθ is clamped to this in the cache's densities
};

}  // namespace viscache
