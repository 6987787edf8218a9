#pragma once
// The interface for "does X see Y?". An oracle may answer without a ray.
//
// One oracle object serves one worker thread and one tile at a time: begin_tile, then any number of calls of
// block, pairs and samples for the eye points of that tile. An oracle keeps nothing after the tile, so that
// answers do not depend on the number of threads. A table that the oracles of a frame share must ensure this
// itself.
#include <algorithm>
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

/// Type of the far end of a connection. The numbers are the semantic index of the paper (AQVC Sec. 3.5).
enum class Semantic : uint8_t { kPoint = 0, kDirection = 1, kSurface = 2, kSolidAngle = 3 };

/// The near ends of a tile, in the Morton order of the tile, so that 16 consecutive ones lie close together.
/// An eye point is a sample × mirror or glass branch × side of the surface.
struct EyeBlock {
    std::vector<Vec3> position;                ///< on the surface
    std::vector<Vec3> normal;                  ///< unit geometric normal on the side of the connections
    std::vector<Vec3> origin;                  ///< spawn(position, normal): where rays start
    std::vector<float> density;                ///< D_e = N_S·P_e: eye samples per unit area at the point
    std::vector<uint32_t> order_x, order_y;    ///< sample position in the tile, for Halton–Morton order
    uint32_t tile_width = 0, tile_height = 0;  ///< extent of order_x, order_y
    // Of frames; empty for arrays of points
    std::vector<uint64_t> place;  ///< key of the pixel and the branch of mirrors and glass
    std::vector<uint32_t> turn;   ///< number of the sample at this place, over all frames that go on
    size_t tile = 0;              ///< index of the tile in its frame
    size_t size() const { return position.size(); }
    void clear() {
        position.clear();
        normal.clear();
        origin.clear();
        density.clear();
        order_x.clear();
        order_y.clear();
        place.clear();
        turn.clear();
    }
};

/// Columns [first, last) of a block.
struct ColumnRange {
    size_t first, last;
    size_t size() const { return last - first; }
};

/// A light group that all eye points share: the columns of a block.
struct FarEnds {
    Semantic semantic = Semantic::kPoint;
    std::vector<float> x, y, z;  ///< positions, or unit directions towards the light; padded to 512 columns
    std::vector<float> nx, ny, nz;  ///< surface normals (kSurface only, else zeros); padded
    /// Ends of shadow rays: positions offset from their own surface; otherwise the same as x, y, z.
    std::vector<float> tx, ty, tz;
    /// D_l = M·P_l: light samples per m² (kSurface) or per sr (kSolidAngle); otherwise 0.
    std::vector<float> density;
    size_t count = 0;         ///< columns in use
    float t_max = kInfinity;  ///< length of rays to directions; unused for positions
    int group = 0;            ///< index of the light group: selects C_E and refinement
    /// Ends of sets of columns: an eye point of turn t asks those of set t mod size alone. Empty: all eye
    /// points ask all columns.
    std::vector<uint32_t> set_end;

    size_t sets() const { return set_end.empty() ? 1 : set_end.size(); }
    /// The set that an eye point asks.
    size_t set_of(const EyeBlock& eyes, size_t eye) const {
        return set_end.empty() ? 0 : eyes.turn[eye] % set_end.size();
    }
    /// Its columns.
    ColumnRange columns_of(const EyeBlock& eyes, size_t eye) const {
        if (set_end.empty()) return {0, count};
        const size_t set = set_of(eyes, eye);
        return {set ? set_end[set - 1] : 0, set_end[set]};
    }
};

/// A connection whose far end belongs to one eye point.
struct ShadowQuery {
    uint32_t eye = 0;  ///< index into the EyeBlock
    Semantic semantic = Semantic::kPoint;
    uint8_t group = 0;
    Vec3 far;           ///< position, or unit direction
    Vec3 far_normal;    ///< kSurface only
    Vec3 ray_end;       ///< end of the shadow ray (position offset from its surface); unused for directions
    float density = 0;  ///< D_l at the far end
    float t_max = kInfinity;  ///< length of the ray (ambient occlusion); unused for positions
};

/// Order in which `pairs` should get the queries. Empty: any order.
struct PairOrder {
    std::span<const uint32_t> eye;  ///< the tile's eye points in processing order
    /// Ends of runs in `eye`. The queries of one run belong in one call of `pairs`.
    std::span<const uint32_t> run_end;
};

struct LocalSamples;

/// Unoccluded contributions of the columns of a block to eye points.
class Contributions {
public:
    virtual ~Contributions() = default;
    /// Sets row i to the bits of the columns whose contribution to the eye point is at most shares[i] times
    /// the mean of its positive contributions.
    virtual void at_most(uint32_t eye, std::span<const float> shares, std::span<Word* const> rows) const = 0;
    /// The light from which shares of corrections count (reference_light), in the same means. `seen`: columns
    /// that are thought to be visible. 0: not known.
    virtual float reference(uint32_t /*eye*/, const Word* /*seen*/) const { return 0; }
    /// Contribution of each column to the pixel of the eye point. Does nothing if it is unknown.
    virtual void values(uint32_t /*eye*/, std::span<Rgb> /*columns*/) const {}
};

/// A change of an answer: the weight of a column's contribution, added to that of its bit. The answer was
/// checked with probability `share`.
struct Correction {
    uint32_t column;
    float weight;
    float share;
};

class VisibilityOracle {
public:
    virtual ~VisibilityOracle() = default;
    /// Passes the contributions of the columns of the next `block`, or nullptr. An oracle can distribute its
    /// rays by them.
    virtual void weigh(const Contributions*) {}
    /// Passes the unoccluded contribution of each of the next `samples`.
    virtual void weigh_samples(std::span<const Rgb>) {}
    /// The next blocks log the answer of each query; nullptr turns this off. Throws std::invalid_argument if
    /// the oracle does not support it.
    virtual void log(QueryLog* log) {
        if (log) throw std::invalid_argument("this oracle cannot tell who answered a query");
    }
    /// Long calls throw `Cancelled` soon after `control` requests it. `control` must outlive the oracle.
    virtual void watch(const Control& control) { control_ = &control; }
    /// Discards the previous tile and reads the eye points of the next one.
    virtual void begin_tile(const EyeBlock& eyes) = 0;
    /// Answers eye points × one light group. Only the set bits of `wanted` are queries. `visible` has the
    /// same size and is zeroed.
    virtual void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                       BitMatrix& visible, Counters& counters) = 0;
    /// The order in which `pairs` should get queries of this tile; valid until the next begin_tile.
    virtual PairOrder pair_order(const EyeBlock&) { return {}; }
    /// Answers any connections of the eye points of the tile. Bit i of `visible` (zeroed on entry) belongs to
    /// queries[i].
    virtual void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                       Counters& counters) = 0;
    /// For oracles that skip connections at random: weights 1/probability of the visible columns of an eye
    /// point in the latest block. Empty: all weights are 1. Two rows at the same address are equal.
    virtual std::span<const float> block_weights(uint32_t /*eye*/) const { return {}; }
    /// Corrections of the answers to an eye point in the latest block, by column.
    virtual std::span<const Correction> block_corrections(uint32_t /*eye*/) const { return {}; }
    /// Answers of the latest block that are less certain than others, as eye points × columns: a quantized
    /// cache found that its cells disagree. nullptr if the oracle does not tell.
    virtual const BitMatrix* block_doubts() const { return nullptr; }
    /// True if the answers to blocks of these lights are those of exact rays.
    virtual bool is_exact(const FarEnds&) const { return false; }
    /// The same for far ends of single eye points in a light group.
    virtual bool is_exact_own(int /*group*/) const { return false; }
    /// Weights, as `block_weights`, for the queries of the latest `pairs`, or of `samples` if it calls
    /// `pairs`.
    virtual std::span<const float> pair_weights() const { return {}; }
    /// What `pair_weights` has of corrections, for estimates of their variance: by query or sample.
    virtual std::span<const Correction> pair_corrections() const { return {}; }
    /// The order in which `samples` should get samples of this tile and light group; valid until the next
    /// call or begin_tile.
    virtual PairOrder sample_order(const EyeBlock& eyes, [[maybe_unused]] int group) {
        return pair_order(eyes);
    }
    /// Answers the samples of a run of eye points; each eye point has its own. Bit i of `visible` (zeroed on
    /// entry) belongs to sample i. The default converts them to `pairs`.
    virtual void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                         Counters& counters);

    /// The weights of an eye point's columns with their corrections, for who wants all in one row. Sets the
    /// bits of corrected columns by their weight. Empty: all weights are 1. `scratch` holds the row.
    std::span<const float> corrected_weights(uint32_t eye, Word* visible, size_t columns,
                                             std::vector<float>& scratch) const {
        const std::span<const float> weights = block_weights(eye);
        const std::span<const Correction> corrections = block_corrections(eye);
        if (corrections.empty()) return weights;
        scratch.assign(columns, 1.f);
        std::copy_n(weights.begin(), std::min(weights.size(), columns), scratch.begin());
        for (const Correction& c : corrections) {
            float& weight = scratch[c.column];
            weight = (get_bit(visible, c.column) ? weight : 0.f) + c.weight;
            weight != 0 ? set_bit(visible, c.column) : clear_bit(visible, c.column);
        }
        return scratch;
    }

protected:
    /// Call this every few milliseconds of work.
    void check_cancelled() const {
        if (control_) control_->check();
    }

private:
    const Control* control_ = nullptr;
};

}  // namespace viscache
