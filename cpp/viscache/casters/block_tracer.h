#pragma once
// Traces any-hit rays of a caller's arrays in the way that suits them. Affects speed only: in robust scenes
// every way gives the same answers.
#include <cstdint>
#include <optional>

#include "viscache/casters/embree_caster.h"
#include "viscache/casters/ray_arrays.h"
#include "viscache/math/parallel.h"

namespace viscache {

/// Ways to trace a block of rays.
enum class RayWay {
    kCoherent,  ///< as given, in coherent packets
    kAsGiven,   ///< as given, in incoherent packets
    kSorted,    ///< similar rays together, in incoherent packets
};

/// Any hits of `count` rays; the answer for ray k is stored in occluded[k]. The way of a block of rays
/// follows from its rays, never from time; `fixed`: always this way.
///
/// False if a ray must not be traced: a component that is not finite or above kMaxCoordinate in size, or a
/// t_max that is not >= 0. Nothing of its batch is traced, and the answers are incomplete.
bool trace_any_hits(const EmbreeCaster& caster, const RayArrays& rays, size_t count, uint8_t* occluded,
                    int threads, Control& control, std::optional<RayWay> fixed = {});

}  // namespace viscache
