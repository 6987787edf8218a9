#pragma once
// Visibility maps for the environment light of a frame.
#include <pybind11/pybind11.h>

#include <functional>

#include "viscache/render/frame.h"
#include "viscache/vismap/temporal.h"

namespace viscache::bindings {

struct FrameMaps {
    EnvironmentMaps maps;
    // A function and not a cache: frames also take maps from readers that have none.
    std::function<void(const RecordTally&)>
        take_tally;          ///< receives how often each record was used; may be empty
    pybind11::tuple arrays;  ///< the arrays that `maps` refers to
};

}  // namespace viscache::bindings
