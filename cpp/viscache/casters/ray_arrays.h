#pragma once
// Rays in a caller's arrays, and the way in which they are traced.
#include <cstddef>
#include <cstdint>

#include "viscache/math/vec.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Rows of three floats in a caller's array, read in place. Row i begins `stride` floats after row i − 1.
struct Rows {
    const float* data;
    ptrdiff_t stride = 3;  ///< 0: one row for all

    Vec3 operator[](size_t i) const {
        const float* row = data + ptrdiff_t(i) * stride;
        return {row[0], row[1], row[2]};
    }
};

/// Rays as arrays, read in place: ray i = origin[i] + t·direction[i] for t in [0, t_max[i·t_stride]].
struct RayArrays {
    Rows origin, direction;
    const float* t_max;
    size_t t_stride;  ///< 0: one t_max for all rays
};

/// Points with normals as arrays, in packets of 16. Lanes that are not requested must be finite too.
struct PointLanes {
    const float *x, *y, *z, *nx, *ny, *nz;
    const uint16_t* asked;  ///< mask of requested lanes for each packet
    size_t packets;
};

/// Unit axes as arrays. `padded` is a multiple of 16; axes past `count` are copies of others.
struct AxisLanes {
    const float *x, *y, *z;
    size_t count, padded;
};

/// How rays are passed to Embree. Affects speed only: in robust scenes every plan gives the same answers.
struct PacketPlan {
    /// 1, 4, 8 or 16. In scenes with instances, coherent packets of 16 are traced as packets of 8.
    int width = 8;
    Coherence coherence = Coherence::kIncoherent;
};

}  // namespace viscache
