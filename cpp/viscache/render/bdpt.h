#pragma once
// Bidirectional path tracing (Veach 1997, Sec. 10): every eye path of a frame is joined with one light path.
#include "viscache/render/bdpt_settings.h"
#include "viscache/render/frame.h"

namespace viscache {

/// Groups of the result: what a path's last connection joins the eye path with; `camera` for connections of
/// light paths with the camera. `emitted` is light that eye paths hit. All are weighted: `color` is their
/// sum. Work goes in rounds whose size depends on the frame alone. `source` must be new: it serves one frame.
FrameResult render_bdpt(const Scene& scene, const RayCaster& caster, const Camera& camera,
                        const BdptSettings& settings, const FrameSettings& frame, OracleSource& source,
                        Control& control);

}  // namespace viscache
