#pragma once
// A finished frame as Python takes it.
#include <pybind11/pybind11.h>

#include "viscache/render/frame.h"

namespace viscache::bindings {

/// Layers (H, W, C), timings, counters, threads and tile_edge_px.
pybind11::dict frame_dict(const FrameResult& frame);

/// Counters, timings of the source and the engine alone, for questions without a frame.
pybind11::dict account_dict(const FrameResult& frame);

}  // namespace viscache::bindings
