#pragma once
// Validation of a scene description before it is frozen.
#include "viscache/scene/description.h"

namespace viscache {

/// Throws SceneError for the first unusable part. The message names the part, the requirement and the given
/// value.
void check_description(const SceneDescription& d);
/// The same for a camera.
void check_camera(const Camera& c);

}  // namespace viscache
