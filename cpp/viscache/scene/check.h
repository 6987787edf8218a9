#pragma once
// Validation of a scene description before it is frozen.
#include "viscache/scene/description.h"

namespace viscache {

/// Throws SceneError for the first thing that cannot be used: it says which part, what must hold and what was
/// given.
void check_description(const SceneDescription& d);
/// The same for a camera.
void check_camera(const Camera& c);

}  // namespace viscache
