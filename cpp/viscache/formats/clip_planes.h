#pragma once
// Near and far planes of cameras, which are not modelled: do they cut anything that the camera sees?
#include "viscache/scene/description.h"

namespace viscache {

struct ClipPlanes {
    float near = 0, far = kInfinity;  ///< distances along the axis
};

struct CutGeometry {
    bool before = false, behind = false;  ///< a surface in the picture lies before `near`, or behind `far`
    bool any() const { return before || behind; }
};

CutGeometry cut_geometry(const SceneDescription& scene, const Camera& camera, const ClipPlanes& planes);

}  // namespace viscache
