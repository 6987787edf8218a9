#pragma once
// Shared directions, traced one after the other for all points: what each point sees along each axis.
#include <optional>

#include "viscache/math/bits.h"
#include "viscache/math/isa.h"
#include "viscache/math/parallel.h"
#include "viscache/visibility/embree_caster.h"
#include "viscache/vlf/aligned_blocks.h"

namespace viscache {

/// Points and the axes they all look along.
struct AlignedInput {
    std::span<const Vec3> origin;  ///< off the surface (`spawn`)
    std::span<const Vec3> normal;  ///< unit, one per origin
    std::span<const Frame3> axes;  ///< orthonormal; rays run along z or against it
    float t_max = kInfinity;       ///< how far they look
};

/// Which rays are packed together when Embree traces them. Speed only.
enum class AlignedOrder { kByAxis, kByPoint };

/// [VLF Sec. 7] Ambient occlusion's rays: one along each axis on the side of the normal (n·ω = 0: along), so
/// that a point's rays are its hemisphere's share of the subfields' directions. For an axis, rays are points
/// of a plane with a depth, and a point is blocked if a triangle covers it farther along: no ray is walked,
/// nothing is stored per direction. Triangles in blocks of 16 are led down a tree of boxes over packets of 16
/// points. Watertight per axis; triangles seen exactly edge-on are not hit.
// Differs: the paper looks its rays up point by point in subfields it has stored, tile by tile. Axis by axis,
// points stream past triangles instead, which today's memories and vector units favour.
class AlignedBatch {
public:
    /// Instances are expanded; holes of alpha masks are open, as for Embree.
    explicit AlignedBatch(std::shared_ptr<const Scene> scene) : triangles_(std::move(scene)) {}

    /// Bit k of row i is 1 if origin i is free along axis k. Rows have words_for(axes) words, padding bits
    /// are 0. The bits depend neither on `threads` nor on `isa`.
    AlignedCounts rows(const AlignedInput& input, std::span<Word> rows, int threads, Control& control,
                       Isa isa = active_isa()) const;

    const TriangleBlocks& triangles() const { return triangles_; }

private:
    TriangleBlocks triangles_;
};

/// The same by Embree, in packets of 8 or 16. Without a flag, each thread finds the faster one. Nothing but
/// the input changes the bits of robust scenes.
void embree_rows(const EmbreeCaster& caster, const AlignedInput& input, std::span<Word> rows,
                 AlignedOrder order, int width, std::optional<Coherence> flag, int threads, Control& control);

}  // namespace viscache
