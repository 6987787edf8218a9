#pragma once
// Traces directions shared by all points, one direction after the other: what each point sees along each
// axis.
#include <optional>

#include "viscache/casters/embree_caster.h"
#include "viscache/math/bits.h"
#include "viscache/math/isa.h"
#include "viscache/math/parallel.h"
#include "viscache/vlf/aligned_blocks.h"

namespace viscache {

/// Scale of the offsets of rays along shared directions: the batch rotates the scene, which rounds by its
/// size, so points are offset by its size, whatever triangle they lie on.
inline float aligned_extent(const Scene& scene) { return scene.bounds().diagonal(); }

/// Points, and the axes along which all of them look.
struct AlignedInput {
    // The three spans describe the rays: one per origin and axis.
    std::span<const Vec3> origin;  ///< already offset from the surface (`spawned`)
    std::span<const Vec3> normal;  ///< unit vectors, one per origin
    std::span<const Frame3> axes;  ///< orthonormal; rays run along z or against it
    float t_max = kInfinity;       ///< length of the rays
    /// The `kd_order` of the origins, if it is known. Affects speed only.
    std::span<const uint32_t> order = {};
};

/// Number of points that are traced along all axes before the next ones; their data stays in the caches.
constexpr size_t kPointsAtOnce = size_t{1} << 16;

/// How rays are grouped into packets when Embree traces them. Affects speed only.
enum class AlignedOrder { kByAxis, kByPoint };

/// [VLF Sec. 7] The rays of ambient occlusion: one along each axis, on the side of the normal (n·ω = 0:
/// along the axis). The rays of a point are therefore the directions of the subfields in its hemisphere. For
/// one axis, each ray is a point of a plane with a depth, and it is blocked if a triangle covers that point
/// farther along the axis. No ray is walked and nothing is stored per direction. Blocks of 16 triangles
/// descend a tree of boxes over packets of 16 points. Watertight for each axis; triangles seen exactly
/// edge-on are not hit.
// Differs (V11): the paper looks up its rays point by point in stored subfields, tile by tile. Here points
// stream past triangles, one axis after the other, which suits the memory and vector units of current CPUs.
class AlignedBatch {
public:
    /// Instances are expanded. Alpha masks cut holes, as with Embree.
    explicit AlignedBatch(std::shared_ptr<const Scene> scene) : triangles_(std::move(scene)) {}

    /// Bit k of row i is 1 if the ray from origin i along axis k is free. Rows have words_for(axes) words;
    /// padding bits are 0. The bits depend neither on `threads` nor on `isa`.
    AlignedCounts rows(const AlignedInput& input, std::span<Word> rows, int threads, Control& control,
                       Isa isa = active_isa()) const;

    const TriangleBlocks& triangles() const { return triangles_; }

private:
    TriangleBlocks triangles_;
};

/// The same with Embree, in packets of 8 or 16. Without a flag, the packets get the one that suits their
/// width. In robust scenes the bits depend only on the input.
/// By axis, a packet holds the parallel rays of neighbouring points; by point, it holds the rays of one point
/// along successive axes.
void embree_rows(const EmbreeCaster& caster, const AlignedInput& input, std::span<Word> rows,
                 AlignedOrder order, int width, std::optional<Coherence> flag, int threads, Control& control);

}  // namespace viscache
