#pragma once
// A finished frame as Python objects.
#include <pybind11/pybind11.h>

#include "viscache/render/frame.h"

namespace viscache::bindings {

/// Layers (H, W, C), timings, counters, threads and tile_edge_px.
pybind11::dict frame_dict(const FrameResult& frame);

/// Only the counters, the timings of the source and the engine: the account of queries without a frame.
pybind11::dict account_dict(const FrameResult& frame);

}  // namespace viscache::bindings
