#pragma once
// Bidirectional path tracing (Veach 1997, Sec. 10): every eye path of a frame is joined with one light path.
#include "viscache/render/frame.h"
#include "viscache/render/settings.h"

namespace viscache {

/// A path goes to the light group of the light or vertex that its last connection joins with the eye path.
/// Connections of light paths with the camera have their own group, `camera`. `emitted` is light that eye
/// paths hit. All groups are weighted, and `color` is their sum. Work is done in rounds whose size depends on
/// the frame only. `source` must be new: it serves one frame.
FrameResult render_bdpt(const Scene& scene, const RayCaster& caster, const Camera& camera,
                        const BdptSettings& settings, const FrameSettings& frame, OracleSource& source,
                        Control& control);

}  // namespace viscache
