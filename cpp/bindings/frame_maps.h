#pragma once
// Visibility maps as a frame takes them.
#include <functional>

#include "viscache/render/frame.h"
#include "viscache/vismap/temporal.h"

namespace viscache::bindings {

struct FrameMaps {
    EnvironmentMaps maps;
    std::function<void(const RecordTally&)> take_tally;  ///< told how often each record served; may be empty
};

}  // namespace viscache::bindings
