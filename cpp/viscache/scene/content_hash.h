#pragma once
// A hash of everything that decides how a scene looks: caches and sweep stores are keyed by it.
#include <string>

#include "viscache/scene/description.h"

namespace viscache {

/// 32 hexadecimal digits; equal for equal content, names and file paths not counted.
std::string content_hash(const SceneDescription& d);

}  // namespace viscache
