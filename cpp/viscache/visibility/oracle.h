#pragma once
// The seam for "does X see Y?". An oracle may answer without a ray.
//
// One oracle object serves one worker thread and one tile at a time: begin_tile, then any number of
// block and pairs calls about that tile's eye points. What an oracle remembers does not outlive the tile,
// so that answers do not depend on threads; a table that a frame's oracles share takes care of that itself.
#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"
#include "viscache/visibility/counters.h"
#include "viscache/visibility/query_log.h"

namespace viscache {

/// What the far end of a connection is; the numbers are the paper's semantic index (AQVC Sec. 3.5).
enum class Semantic : uint8_t { kPoint = 0, kDirection = 1, kSurface = 2, kSolidAngle = 3 };

/// The near ends of a tile in processing order: along the tile's Morton order, so that 16 neighbours lie
/// close together. "Eye point" = sample × mirror/glass branch × side of the surface.
struct EyeBlock {
    std::vector<Vec3> position;              ///< on the surface
    std::vector<Vec3> normal;                ///< unit geometric normal on the side the connections leave from
    std::vector<Vec3> origin;                ///< spawn(position, normal): where rays start
    std::vector<float> density;              ///< D_e = N_S·P_e: eye samples per unit area at the point
    std::vector<uint32_t> order_x, order_y;  ///< sample position inside the tile, for Halton–Morton order
    uint32_t tile_width = 0, tile_height = 0;  ///< extent of order_x, order_y
    size_t tile = 0;                           ///< number of the tile in its frame
    size_t size() const { return position.size(); }
    void clear() {
        position.clear(), normal.clear(), origin.clear(), density.clear(), order_x.clear(), order_y.clear();
    }
};

/// One light group whose members are shared by all eye points: the columns of a block.
struct FarEnds {
    Semantic semantic = Semantic::kPoint;
    std::vector<float> x, y, z;  ///< positions, or unit directions towards the light; padded to 512 columns
    std::vector<float> nx, ny, nz;  ///< surface normals (kSurface only, else zeros); padded
    std::vector<float> tx, ty,
        tz;  ///< where shadow rays end: position spawned off its own surface; = x, y, z for the rest
    std::vector<float>
        density;       ///< D_l = M·P_l: light samples per m² (kSurface) or per sr (kSolidAngle); else 0
    size_t count = 0;  ///< columns in use
    float t_max = kInfinity;  ///< how far directions look; unused for positions
    int group = 0;            ///< index of the light group: selects C_E and refinement
};

/// One connection whose far end belongs to one eye point alone.
struct ShadowQuery {
    uint32_t eye = 0;  ///< index into the EyeBlock
    Semantic semantic = Semantic::kPoint;
    uint8_t group = 0;
    Vec3 far;         ///< position, or unit direction
    Vec3 far_normal;  ///< kSurface only
    Vec3 ray_end;     ///< where the shadow ray ends (position spawned off its surface); unused for directions
    float density = 0;        ///< D_l at the far end
    float t_max = kInfinity;  ///< how far a direction looks (ambient occlusion); unused for positions
};

/// In which order an oracle likes to be asked by `pairs`. Empty: any.
struct PairOrder {
    std::span<const uint32_t> eye;  ///< the tile's eye points in processing order
    std::span<const uint32_t>
        run_end;  ///< ends of runs in `eye`: the queries of one run belong into one call of `pairs`
};

struct LocalSamples;

/// What eye points would receive from the columns of a block if nothing stood between.
class Contributions {
public:
    virtual ~Contributions() = default;
    /// Row i gets the bits of the columns whose contribution to the eye point is at most shares[i] times the
    /// mean of its positive ones.
    virtual void at_most(uint32_t eye, std::span<const float> shares, std::span<Word* const> rows) const = 0;
    /// What each column brings to the eye point's pixel; nothing where that is not known.
    virtual void values(uint32_t /*eye*/, std::span<Rgb> /*columns*/) const {}
};

class VisibilityOracle {
public:
    virtual ~VisibilityOracle() = default;
    /// Says what the columns of the next `block` are worth, or nullptr. An oracle may spend rays by it.
    virtual void weigh(const Contributions*) {}
    /// Says what each of the next `samples` brings unoccluded.
    virtual void weigh_samples(std::span<const Rgb>) {}
    /// The next blocks tell `log` who answered each query, or nobody where it is nullptr. Throws
    /// std::invalid_argument where an oracle cannot tell.
    virtual void log(QueryLog* log) {
        if (log) throw std::invalid_argument("this oracle cannot tell who answered a query");
    }
    /// Long calls end with `Cancelled` soon after this says so. `control` must outlive the oracle.
    virtual void watch(const Control& control) { control_ = &control; }
    /// Forgets the tile before and learns the eye points of the next one.
    virtual void begin_tile(const EyeBlock& eyes) = 0;
    /// Eye points × one light group; only the set bits of `wanted` are asked. `visible` arrives zeroed, of
    /// equal size.
    virtual void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                       BitMatrix& visible, Counters& counters) = 0;
    /// The order in which `pairs` should be asked about this tile; valid until the next begin_tile.
    virtual PairOrder pair_order(const EyeBlock&) { return {}; }
    /// Any connections of the tile's eye points. Bit i of `visible` (zeroed on entry) answers queries[i].
    virtual void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                       Counters& counters) = 0;
    /// Of oracles that leave connections out at random: what the seen columns of an eye point count for in
    /// the block just answered, 1/probability. Empty: 1 each. Where two rows have one address, they are
    /// equal.
    virtual std::span<const float> block_weights(uint32_t /*eye*/) const { return {}; }
    /// The same of the queries of the last `pairs`, or of `samples` by way of it.
    virtual std::span<const float> pair_weights() const { return {}; }
    /// The order in which `samples` should be asked about this tile and light group; valid until the next
    /// call of it and until the next begin_tile.
    virtual PairOrder sample_order(const EyeBlock& eyes, [[maybe_unused]] int group) {
        return pair_order(eyes);
    }
    /// Samples of a run of the tile's eye points, each eye point's own. Bit i of `visible` (zeroed on entry)
    /// answers sample i. Unless an oracle knows better, they are `pairs`.
    virtual void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                         Counters& counters);

protected:
    /// To be called every few milliseconds of work.
    void check_cancelled() const {
        if (control_) control_->check();
    }

private:
    const Control* control_ = nullptr;
};

}  // namespace viscache
