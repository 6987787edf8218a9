#pragma once
// Visibility of a tile's eye points from one light, by shafts: the inner loops, with one variant per
// instruction set.
//
// A shaft is the hull of the light and a node of eye points. Nodes of the scene outside of it block nothing
// there. Triangles that are left are tested against the node, then against its packets, by planes through the
// light and their edges. Every test has a bound of its rounding and of that of Embree's robust test, so that
// the two agree wherever a test is sure. Rays answer the rest, and nodes with long lists of triangles. The
// bits are therefore Embree's with every variant; the share of rays may differ between variants.
#include <array>
#include <cstdint>
#include <vector>

#include "viscache/math/isa.h"
#include "viscache/shafts/shaft_eyes.h"

namespace viscache {

/// Traces what shafts cannot decide.
class ShaftRays {
public:
    virtual ~ShaftRays() = default;
    /// Occluded lanes of a packet, out of `mask`, towards the light at hand.
    virtual uint32_t occluded(size_t packet, uint32_t mask) = 0;
};

/// Work of the kernels.
struct ShaftCounts {
    uint64_t nodes = 0;       ///< nodes tested against a shaft
    uint64_t blocks = 0;      ///< blocks of triangles tested against a node
    uint64_t lists = 0;       ///< 16 listed triangles tested against a packet
    uint64_t pairs = 0;       ///< triangles tested against the 16 points of a packet
    uint64_t doubted = 0;     ///< rays within the bounds of an edge, of a plane or of an end
    uint64_t long_lists = 0;  ///< rays of nodes with too many triangles
    uint64_t asked = 0;       ///< packets with a point that asks
    uint64_t packets = 0;     ///< packets with a ray that was traced
    uint64_t traced() const { return doubted + long_lists; }
    void merge(const ShaftCounts& b);
};

/// What rays leave out at their ends.
struct ShaftEnds {
    float most;       ///< before the light, as a length along the rays, of all points
    float end;        ///< the same of one point, in units of the largest coordinate of point and light
    float start = 0;  ///< at the point, in these units
};

/// One light and the points that ask for it. Coordinates are those of the tree.
struct ShaftLight {
    const ShaftTree& tree;
    const ShaftEyes& eyes;
    const ShaftColumns& columns;
    size_t column;
    float light[3];
    ShaftEnds ends;
    float slack;   ///< shafts are grown by this
    float bounds;  ///< factor of the error bounds: 1, or less to show that tests notice it
    const uint16_t* wanted;
    uint16_t* visible;  ///< zeroed; one mask per packet
};

/// A node of the scene, and the children that are still in play.
struct ShaftItem {
    int32_t node;
    uint32_t children;
};

/// Most triangles of a list. Where more remain, tracing rays is cheaper.
constexpr int kShaftList = 128;
/// Nodes of the level of 64 points have lists.
constexpr size_t kShaftListLevel = 1;
constexpr size_t kShaftMostLevels = 16;

/// Memory of one thread.
struct ShaftMemory {
    std::array<std::vector<ShaftItem>, kShaftMostLevels + 1> lists;  ///< by depth below the tile
    std::vector<ShaftItem> stack;
    /// Planes of listed triangles: three edges' normals, the plane's normal, and the height of the node's
    /// centre over it.
    alignas(64) float planes[13][kShaftList + kShaftLanes];
    ShaftCounts counts;
};

/// Enlarges a list to hold at least `count` items; returns its data.
ShaftItem* hold(std::vector<ShaftItem>& items, size_t count);

/// Answers all points for one light. Adds to memory.counts.
using AnswerLight = void (*)(const ShaftLight& light, ShaftMemory& memory, ShaftRays& rays);
AnswerLight shaft_kernel(Isa isa);

}  // namespace viscache
