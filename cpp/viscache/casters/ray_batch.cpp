#include "viscache/casters/ray_batch.h"

#include <algorithm>
#include <cmath>

#include "viscache/casters/row_lanes.h"
#include "viscache/math/isa_variants.h"
#include "viscache/visibility/query.h"

namespace viscache {

namespace {

#define VISCACHE_INLINE inline __attribute__((always_inline))

// NaN compares false and infinity is too large, so one comparison checks all
VISCACHE_INLINE int32_t usable(float x) { return std::fabs(x) <= kMaxCoordinate; }

/// Arranges rays in lanes and checks them in the same pass. Branch-free, for the compiler's vectors.
VISCACHE_INLINE bool pack_body(const RayBatch::Input& in, size_t packets, RayLanes& out) {
    // One flag per lane, joined at the end: a branch per ray would cost more than the checks
    int32_t fine[16];
    std::fill_n(fine, 16, 1);
    for (size_t p = 0; p < packets; ++p) {
        RayPacket16& r = out.packet[p];
        rows_to_lanes16(in.origin + 48 * p, r.ox, r.oy, r.oz);
        rows_to_lanes16(in.direction + 48 * p, r.dx, r.dy, r.dz);
        const float* __restrict end = in.t_max + in.t_step * p;
        int32_t* __restrict asked = out.asked[p];
        float* __restrict t_max = r.t_max;
        for (size_t i = 0; i < 16; ++i) {
            const float dx = r.dx[i], dy = r.dy[i], dz = r.dz[i], t = end[i];
            fine[i] &= usable(r.ox[i]) & usable(r.oy[i]) & usable(r.oz[i]) & usable(dx) & usable(dy) &
                       usable(dz) & (t >= 0);
            const int32_t ask = (t > 0) & ((dx != 0) | (dy != 0) | (dz != 0));
            asked[i] = -ask;
            // Inactive lanes get a ray that is valid: where Embree splits packets, it traces them
            // too
            t_max[i] = ask ? t : kInfinity;
        }
        std::fill_n(r.t_min, 16, 0.f);
    }
    return std::all_of(fine, fine + 16, [](int32_t f) { return f != 0; });
}

#undef VISCACHE_INLINE

constexpr size_t kAhead = 32;  // rays that are fetched before they are copied

}  // namespace

RayBatch::RayBatch(Isa isa) : pack_(variant_of<pack_body>(isa)) {}

bool RayBatch::pack(const Input& input, size_t count) {
    size_ = count;
    const size_t packets = (count + 15) / 16;
    if (!pack_(input, packets, lanes_)) return false;
    // Copies past the end are checked like rays but not asked
    for (size_t i = count; i < 16 * packets; ++i) lanes_.asked[i / 16][i % 16] = 0;
    return true;
}

/// Copies rows to where there are no gaps, with copies of the last one past the end.
template <class Number>
bool RayBatch::gather(const RayArrays& rays, Number number, size_t count) {
    if (count == 0) return pack({}, 0);
    const size_t padded = (count + 15) / 16 * 16;
    const auto copy = [](float* to, Vec3 v) {
        to[0] = v.x;
        to[1] = v.y;
        to[2] = v.z;
    };
    for (size_t i = 0; i < padded; ++i) {
        // Rays in an order of our own lie anywhere in the caller's arrays: each is fetched well
        // before it is copied
        const size_t k = number(std::min(i, count - 1)), ahead = number(std::min(i + kAhead, count - 1));
        __builtin_prefetch(rays.origin.data + ptrdiff_t(ahead) * rays.origin.stride);
        __builtin_prefetch(rays.direction.data + ptrdiff_t(ahead) * rays.direction.stride);
        copy(origin_ + 3 * i, rays.origin[k]);
        copy(direction_ + 3 * i, rays.direction[k]);
    }
    if (rays.t_stride == 0) {
        std::fill_n(t_max_, 16, *rays.t_max);
    } else {
        for (size_t i = 0; i < padded; ++i)
            t_max_[i] = rays.t_max[number(std::min(i, count - 1)) * rays.t_stride];
    }
    return pack({origin_, direction_, t_max_, rays.t_stride ? size_t{16} : 0}, count);
}

bool RayBatch::take(const RayArrays& rays, size_t first, size_t count) {
    // Rows without gaps in whole packets are read where they lie
    const bool in_place = rays.origin.stride == 3 && rays.direction.stride == 3 && count % 16 == 0;
    if (!in_place || rays.t_stride > 1) return gather(rays, [&](size_t i) { return first + i; }, count);
    const float* ends = rays.t_max + first;
    if (rays.t_stride == 0) {
        std::fill_n(t_max_, 16, *rays.t_max);
        ends = t_max_;
    }
    return pack({rays.origin.data + 3 * first, rays.direction.data + 3 * first, ends, 16 * rays.t_stride},
                count);
}

bool RayBatch::take(const RayArrays& rays, std::span<const uint32_t> order) {
    return gather(rays, [&](size_t i) -> size_t { return order[i]; }, order.size());
}

}  // namespace viscache
