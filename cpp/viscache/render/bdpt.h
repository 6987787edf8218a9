#pragma once
// Bidirectional path tracing (Veach 1997, Sec. 10): every eye path of a frame is joined with one light path.
#include "viscache/render/bdpt_settings.h"
#include "viscache/render/frame.h"

namespace viscache {

/// The oracles of a frame. Work goes in rounds whose size depends on the frame alone; a cache that is shared
/// by all threads takes up what was learned between them, so that answers do not depend on threads.
struct RoundOracles {
    OracleFactory make;                                             ///< of one worker thread
    std::function<void(size_t items)> begin_round = [](size_t) {};  ///< before the items of a round
    std::function<void(VisibilityOracle&, size_t item)> end_item = [](VisibilityOracle&, size_t) {};
    std::function<void(Counters&)> end_round = [](Counters&) {};  ///< after them, on one thread
};

/// Groups of the result: what a path's last connection joins the eye path with; `camera` for connections of
/// light paths with the camera. `emitted` is light that eye paths hit. All are weighted: `color` is their
/// sum.
FrameResult render_bdpt(const Scene& scene, const RayCaster& caster, const Camera& camera,
                        const BdptSettings& settings, const FrameSettings& frame, const RoundOracles& oracles,
                        Control& control);

}  // namespace viscache
