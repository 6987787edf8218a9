#pragma once
// Data of aligned rays: triangles in blocks of 16, points in packets of 16, and the state of one thread
// along one axis.
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "viscache/casters/flat_triangles.h"
#include "viscache/math/bounds.h"
#include "viscache/math/frame.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"

namespace viscache {

constexpr size_t kLanes = 16;           ///< triangles per block, points per packet, children per node
constexpr size_t kGroupsPerCheck = 16;  ///< groups between two checks for cancellation
/// Largest distance of points from the scene, in units of its size. There, floats are farther apart than the
/// scene is large, and products of three coordinates still fit into a float.
constexpr float kFarthest = 1e9f;

/// Number of runs of 16 that n elements fill. The last one may need padding.
inline size_t in_lanes(size_t n) { return (n + kLanes - 1) / kLanes; }

/// An array of floats aligned to 64 bytes.
/// A cache line, and the widest vector: no load of 16 floats crosses a line.
class LaneArray {
public:
    /// Resizes the array; the contents are lost.
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

/// Indices of the points in an order in which runs of 16, 256 and 4096 points are compact. The points are
/// split at medians of the longest side of their bounding box, at multiples of these sizes.
std::vector<uint32_t> kd_order(std::span<const Vec3> points, const Control& control);

/// Translation and scale applied to triangles and points before rotation: centred, with a size between one
/// half and one. Rounding errors then scale with the scene, and no product leaves the range of float.
struct Placement {
    Vec3 centre;
    float scale = 1;  ///< a power of two
    static Placement of(const Bounds& bounds);
    Vec3 apply(Vec3 p) const { return (p - centre) * scale; }
};

/// Up to 16 blocks that are close to each other.
struct BlockGroup {
    size_t first, blocks;
    Vec3 centre, half;  ///< centre and half size of the bounding box of their corners
};

/// Triangles, transformed and sorted: large ones first, those with alpha masks last. Each class has its own
/// blocks, compact in space. The last block of a class is padded with degenerate triangles, which nothing
/// hits.
struct TriangleBlocks {
    std::shared_ptr<const Scene> scene;
    Placement placement;
    size_t triangles = 0, blocks = 0;
    size_t first_small = 0;              ///< first block after those of large triangles
    std::vector<BlockGroup> groups;      ///< groups of the blocks from first_small on
    size_t first_masked = 0;             ///< first block of triangles with alpha masks
    std::vector<TriangleSource> masked;  ///< sources of the triangles in the lanes from first_masked on
    LaneArray corner[3][3];              ///< [corner][x, y, z]

    explicit TriangleBlocks(std::shared_ptr<const Scene> scene);
    /// False where the alpha mask of a lane's triangle cuts a hole at the barycentric coordinates (u, v).
    bool solid_at(size_t lane, float u, float v) const {
        if (lane < first_masked * kLanes) return true;
        const TriangleSource& s = masked[lane - first_masked * kLanes];
        return scene->solid_at(s.mesh, s.triangle, u, v);
    }
    /// Nine coordinates per lane.
    uint64_t bytes() const { return uint64_t{9} * blocks * kLanes * sizeof(float); }

private:
    void set_lane(size_t lane, const FlatTriangle& t);
    void add_groups(size_t first, size_t last);
};

/// Points with normals, transformed and sorted. Lanes past the last point are copies of it; they are never
/// requested.
struct PointPackets {
    size_t points = 0, packets = 0;
    std::vector<uint32_t> order;  ///< index of the point in each lane
    std::vector<uint16_t> asked;  ///< mask of the requested lanes of each packet
    LaneArray x, y, z, nx, ny, nz;

    /// `given` is the order of the points; if it is empty, they are sorted. Throws std::invalid_argument for
    /// points farther from the scene than 1e9 times its size.
    PointPackets(const Placement& placement, std::span<const Vec3> position, std::span<const Vec3> normal,
                 const Control& control, std::span<const uint32_t> given = {});
};

/// Packets that are traced together.
struct PacketRange {
    size_t first, packets;
};

/// Bounding boxes of the nodes of one level along an axis. Across the axis they bound the points. Along it
/// they bound the starts of the rays: of upward rays between `from_up` and `to_up`, of downward rays between
/// `from_down` (the higher one) and `to_down`.
///
///     z                                from_down  ---  highest start
///     ^   to_up    ---                             |  rays run down
///     |   from_up  ---  lowest start   to_down    ---
///     |      rays run up
///
/// Something between the depths `low` and `high` may block an upward ray of the node only if high > from_up,
/// and a downward one only if low < from_down. A node without upward rays has from_up = ∞ and to_up = −∞, so
/// that no comparison finds any; downward rays likewise.
struct BoxLevel {
    size_t nodes = 0;
    LaneArray x0, x1, y0, y1, from_up, to_up, from_down, to_down;
};

/// Amount of work done for an axis.
struct AlignedCounts {
    uint64_t blocks = 0;  ///< blocks of triangles rotated to the axis
    uint64_t nodes = 0;   ///< tests of 16 boxes
    uint64_t pairs = 0;   ///< pairs of a packet and a block that overlap
    uint64_t tests = 0;   ///< tests of one triangle against 16 points, or of one point against 16 triangles
    uint64_t wide = 0;    ///< tests of one point against 16 triangles, which are also in `tests`
    uint64_t exact = 0;   ///< pairs of triangle and point decided in double
    void merge(const AlignedCounts& c) {
        blocks += c.blocks;
        nodes += c.nodes;
        pairs += c.pairs;
        tests += c.tests;
        wide += c.wide;
        exact += c.exact;
    }
};

/// A packet rotated to the axis: x and y across it, z along it.
/// Three cache lines of coordinates and one of masks.
struct alignas(64) TurnedPacket {
    float x[kLanes], y[kLanes], z[kLanes];
    uint16_t up;    ///< lanes whose ray runs along the axis; the others run against it
    uint16_t free;  ///< requested lanes that nothing has blocked so far
};

/// State of one thread along one axis, for a limited number of packets.
struct AxisState {
    /// For every packet: lanes whose ray runs along the axis, and requested lanes. nullptr: side of the
    /// normal, and all points.
    const uint16_t *up = nullptr, *asked = nullptr;
    std::vector<uint16_t>
        free;  ///< result: for each packet of the range, requested lanes that nothing blocks
    std::vector<TurnedPacket> packets;
    std::vector<uint32_t> lane;    ///< original lane of each packed lane
    std::vector<BoxLevel> levels;  ///< 0: packets; each higher level has one node per 16 nodes
    AlignedCounts counts;

    explicit AxisState(size_t most_packets);
};

}  // namespace viscache
