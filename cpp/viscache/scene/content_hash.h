#pragma once
// Hashes of everything that decides how a scene looks, or what hides what: caches and sweep stores are keyed
// by them.
#include <string>

#include "viscache/scene/description.h"

namespace viscache {

/// 32 hexadecimal digits; equal for equal content, names and file paths not counted.
std::string content_hash(const SceneDescription& d);
/// The same of what decides who sees whom alone: shapes, where they are, and holes cut by alpha.
std::string geometry_hash(const SceneDescription& d);

}  // namespace viscache
