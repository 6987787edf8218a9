#pragma once
// Hashes of everything that affects the appearance or the occlusion of a scene. They are the keys of caches
// and sweep stores.
#include <string>

#include "viscache/scene/description.h"

namespace viscache {

/// 32 hexadecimal digits. Equal content gives equal digits; names and file paths do not count.
std::string content_hash(const SceneDescription& d);
/// The same for visibility alone: shapes, their placement, cut-outs and opacity.
std::string geometry_hash(const SceneDescription& d);

}  // namespace viscache
