#pragma once
// The eye points of a tile for shafts: packets of 16 neighbours and a tree over them, four children a node.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/bits.h"
#include "viscache/math/bounds.h"
#include "viscache/shafts/shaft_tree.h"

namespace viscache {

/// All points of a node lie in the box and between two planes. The planes are needed at flat surfaces: the
/// points' own surface is only some ulps away.
struct ShaftEyeNode {
    Vec3 lo, hi;
    Vec3 centre;
    Vec3 half;          ///< half of the box
    float size;         ///< longest side
    Vec3 normal;        ///< mean normal of the points, or of a plane through three of them
    double mid, reach;  ///< dot(normal, point) lies in [mid − reach, mid + reach]
};

class ShaftEyes {
public:
    /// `order` is the packet_order of the points; all coordinates are multiplied by `scale`. Without `order`
    /// there are no points. Points without normals pass none.
    void build(std::span<const Vec3> origin, std::span<const Vec3> normal, std::span<const uint32_t> order,
               float scale);

    size_t packets() const { return x.size() / kShaftLanes; }
    size_t levels() const { return nodes.size(); }
    /// Largest coordinate of a point.
    float magnitude() const { return magnitude_; }
    size_t size() const { return size_; }

    /// Coordinates, packet after packet. The last packet is filled up with its first point.
    std::vector<float> x, y, z;
    /// nodes[0] are the packets. Node i of a level is the parent of the nodes 4 i … 4 i + 3 of the level
    /// below.
    std::vector<std::vector<ShaftEyeNode>> nodes;

private:
    float magnitude_ = 0;
    size_t size_ = 0;
};

/// One word of columns of a block: which points of each packet ask for each of 64 lights.
class ShaftColumns {
public:
    /// Reads word w of the rows, which are in the order of the packets.
    void read(const BitMatrix& wanted, size_t w, const ShaftEyes& eyes);
    /// The same, where all points ask for the same lights.
    void read(Word wanted, const ShaftEyes& eyes);
    /// ORs the answers into the rows.
    void write(BitMatrix& visible, size_t w) const;

    /// Lights that some point asks for.
    Word all() const { return any_.back()[0]; }
    const uint16_t* wanted(size_t column) const { return &wanted_[column * stride_]; }
    uint16_t* visible(size_t column) { return &visible_[column * stride_]; }
    /// Lights that a point below a node asks for, node by node.
    const Word* any(size_t level) const { return any_[level].data(); }

private:
    void resize(const ShaftEyes& eyes);

    size_t packets_ = 0, stride_ = 0;
    std::vector<uint16_t> wanted_, visible_;  ///< column after column, 16 points per packet
    std::vector<std::vector<Word>> any_;      ///< by level and node: lights that a point below asks for
};

}  // namespace viscache
