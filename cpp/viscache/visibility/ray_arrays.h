#pragma once
// Rays as a caller's arrays, and how they are handed on.
#include <cstddef>
#include <cstdint>

#include "viscache/math/vec.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Rays as arrays, read in place: ray i = origin[i] + t·direction[i] for t in [0, t_max[i·t_stride]].
struct RayArrays {
    const Vec3* origin;
    const Vec3* direction;
    const float* t_max;
    size_t t_stride;  ///< 0: one t_max for all
};

/// Points with normals side by side, in packets of 16; lanes that are not asked must be finite all the same.
struct PointLanes {
    const float *x, *y, *z, *nx, *ny, *nz;
    const uint16_t* asked;  ///< lanes, per packet
    size_t packets;
};

/// Axes side by side, unit; `padded` is a multiple of 16, those past `count` are copies of others.
struct AxisLanes {
    const float *x, *y, *z;
    size_t count, padded;
};

/// How rays are handed to Embree. Speed only: in robust scenes every plan gives the same answers.
struct PacketPlan {
    int width = 8;  ///< 1, 4, 8 or 16; coherent packets of 16 in scenes with instances go as packets of 8
    Coherence coherence = Coherence::kIncoherent;
};

}  // namespace viscache
