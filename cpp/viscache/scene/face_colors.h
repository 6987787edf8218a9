#pragma once
// Colours of faces, given to vertices.
#include <span>

#include "viscache/scene/description.h"

namespace viscache {

/// Gives the corners of each triangle its colour, `faces[triangle]`. A vertex whose triangles differ becomes
/// one vertex per colour. Throws SceneError where a triangle names no vertex.
void color_faces(Mesh& mesh, std::span<const VertexColor> faces);

}  // namespace viscache
