#pragma once
// Several infinite lights as one: a scene samples one environment.
#include "viscache/scene/description.h"

namespace viscache {

/// Replaces `environment` and `added_environments` of a checked description by one environment of their sum.
/// It has the rotation and the size of the largest image. Images of the same rotation and size are added
/// pixel by pixel; others are resampled and keep their power. Throws SceneError as
/// EnvironmentMap::from_latlong does.
void add_up_environments(SceneDescription& description, int threads);

}  // namespace viscache
