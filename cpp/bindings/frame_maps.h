#pragma once
// Visibility maps as a frame takes them.
#include <pybind11/pybind11.h>

#include <functional>

#include "viscache/render/frame.h"
#include "viscache/vismap/temporal.h"

namespace viscache::bindings {

struct FrameMaps {
    EnvironmentMaps maps;
    std::function<void(const RecordTally&)> take_tally;  ///< told how often each record served; may be empty
    pybind11::tuple arrays;                              ///< what `maps` looks at
};

}  // namespace viscache::bindings
