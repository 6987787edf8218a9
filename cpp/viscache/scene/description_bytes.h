#pragma once
// A scene description as bytes, to send it to another process of the same build.
#include <string>
#include <string_view>

#include "viscache/scene/description.h"

namespace viscache {

/// Everything in the description; `description_from` gives it back. Not a file format: numbers are stored as
/// this machine holds them.
std::string description_bytes(const SceneDescription& description);

/// Throws SceneError where the bytes are not those of `description_bytes`.
SceneDescription description_from(std::string_view bytes);

}  // namespace viscache
