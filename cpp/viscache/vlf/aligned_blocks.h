#pragma once
// What aligned rays are traced over: triangles in blocks of 16, points in packets of 16, and what one thread
// knows of them along one axis.
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "viscache/math/bounds.h"
#include "viscache/math/frame.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"
#include "viscache/visibility/flat_triangles.h"

namespace viscache {

constexpr size_t kLanes = 16;           ///< triangles of a block, points of a packet, children of a node
constexpr size_t kGroupsPerCheck = 16;  ///< between looks whether the caller gave up
/// How far points may be from the scene, in its sizes: floats there are farther apart than it is large, and
/// products of three coordinates are still floats.
constexpr float kFarthest = 1e9f;

inline size_t in_lanes(size_t n) { return (n + kLanes - 1) / kLanes; }

/// Floats on a boundary of 64 bytes.
class LaneArray {
public:
    /// The contents are lost.
    void resize(size_t n) {
        if (n > capacity_) {
            data_.reset(static_cast<float*>(::operator new[](n * sizeof(float), std::align_val_t{64})));
            capacity_ = n;
        }
        size_ = n;
    }
    size_t size() const { return size_; }
    float* data() { return data_.get(); }
    const float* data() const { return data_.get(); }
    float& operator[](size_t i) { return data_[i]; }
    const float& operator[](size_t i) const { return data_[i]; }

private:
    struct Free {
        void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
    };
    std::unique_ptr<float[], Free> data_;
    size_t size_ = 0, capacity_ = 0;
};

/// Numbers of the points in an order that makes runs of 16, 256 and 4096 compact: halved at medians of the
/// longest side of their box, at multiples of these.
std::vector<uint32_t> kd_order(std::span<const Vec3> points, const Control& control);

/// Where triangles and points are moved before they are turned, so that rounding scales with the scene and
/// no product leaves the range of floats: around the centre, at a size of one half to one.
struct Placement {
    Vec3 centre;
    float scale = 1;  ///< a power of two
    static Placement of(const Bounds& bounds);
    Vec3 apply(Vec3 p) const { return (p - centre) * scale; }
};

/// Up to 16 blocks that lie together.
struct BlockGroup {
    size_t first, blocks;
    Vec3 centre, half;  ///< of the box of their corners
};

/// Triangles, placed and ordered: large ones first, those that alpha masks cut holes into last, each kind in
/// blocks of its own, compact in space. Last blocks are filled up with points, which nothing hits.
struct TriangleBlocks {
    std::shared_ptr<const Scene> scene;
    Placement placement;
    size_t triangles = 0, blocks = 0;
    size_t first_small = 0;              ///< block; those before hold large triangles
    std::vector<BlockGroup> groups;      ///< of those from first_small on
    size_t first_masked = 0;             ///< block
    std::vector<TriangleSource> masked;  ///< what the lanes from first_masked on show
    LaneArray corner[3][3];              ///< [corner][x, y, z]

    explicit TriangleBlocks(std::shared_ptr<const Scene> scene);
    /// False where the mask of a lane's triangle cuts a hole at barycentrics (u, v).
    bool solid_at(size_t lane, float u, float v) const {
        if (lane < first_masked * kLanes) return true;
        const TriangleSource& s = masked[lane - first_masked * kLanes];
        return scene->solid_at(s.mesh, s.triangle, u, v);
    }
    uint64_t bytes() const { return uint64_t{9} * blocks * kLanes * sizeof(float); }

private:
    void set_lane(size_t lane, const FlatTriangle& t);
    void add_groups(size_t first, size_t last);
};

/// Points with normals, placed and ordered; lanes beyond the last are copies of it that are never asked.
struct PointPackets {
    size_t points = 0, packets = 0;
    std::vector<uint32_t> order;  ///< number of the point in a lane
    std::vector<uint16_t> asked;  ///< lanes, per packet
    LaneArray x, y, z, nx, ny, nz;

    /// Throws std::invalid_argument for points farther from the scene than 1e9 times its size.
    PointPackets(const Placement& placement, std::span<const Vec3> position, std::span<const Vec3> normal,
                 const Control& control);
};

/// Packets that are traced together.
struct PacketRange {
    size_t first, packets;
};

/// Boxes of the nodes of one level along an axis: where their points are across it, and where along it their
/// rays start: upwards between `from_up` and `to_up`, downwards between `from_down` (higher) and `to_down`.
struct BoxLevel {
    size_t nodes = 0;
    LaneArray x0, x1, y0, y1, from_up, to_up, from_down, to_down;
};

/// How much work an axis was.
struct AlignedCounts {
    uint64_t blocks = 0;  ///< blocks of triangles turned to the axis
    uint64_t nodes = 0;   ///< tests of 16 boxes
    uint64_t pairs = 0;   ///< packets that met a block
    uint64_t tests = 0;   ///< tests of one triangle against 16 points or of one point against 16 triangles
    uint64_t exact = 0;   ///< pairs of triangle and point decided in double
    void merge(const AlignedCounts& c) {
        blocks += c.blocks, nodes += c.nodes, pairs += c.pairs, tests += c.tests, exact += c.exact;
    }
};

/// A packet turned to the axis: x and y across it, z along it.
struct alignas(64) TurnedPacket {
    float x[kLanes], y[kLanes], z[kLanes];
    uint16_t up;    ///< lanes whose ray runs along the axis, others run against it
    uint16_t free;  ///< lanes asked that nothing has blocked so far
};

/// One thread's view along one axis of so many packets at most.
struct AxisState {
    /// Per packet of all, lanes whose ray runs along the axis, and lanes asked; nullptr: by normals, all
    /// points.
    const uint16_t *up = nullptr, *asked = nullptr;
    std::vector<uint16_t> free;  ///< the answer: lanes asked that nothing blocks, per packet of the range
    std::vector<TurnedPacket> packets;
    std::vector<uint32_t> lane;    ///< which lane of all points a packed lane holds
    std::vector<BoxLevel> levels;  ///< 0: packets; each next level has one node per 16
    AlignedCounts counts;

    explicit AxisState(size_t most_packets);
};

}  // namespace viscache
