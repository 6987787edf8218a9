#pragma once
// The interface for "does X see Y?". An oracle may answer without a ray.
//
// One oracle object serves one worker thread and one tile at a time: begin_tile, then any number of calls of
// block and pairs for the eye points of that tile. Each call gets an ask and gives an Answer: all that the
// oracle says about it. A wrapper takes the Answer of its inner oracle and gives its own.
//
// An oracle keeps nothing after the tile, so that answers do not depend on the number of threads. A table
// that the oracles of a frame share must ensure this itself.
#include <bitset>
#include <cstdint>
#include <optional>
#include <span>
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

/// Eye points of a tile × one light group.
struct BlockAsk {
    const EyeBlock& eyes;
    const FarEnds& lights;
    const BitMatrix& wanted;                       ///< its set bits are the queries
    const Contributions* contributions = nullptr;  ///< an oracle can distribute its rays by them
    QueryLog* log = nullptr;                       ///< gets who answered each query (Answer::logged)
};

/// Connections whose far ends belong to single eye points of a tile: queries in any order, or samples of one
/// light group, eye point by eye point.
struct PairsAsk {
    const EyeBlock& eyes;
    std::span<const ShadowQuery> queries{};
    const LocalSamples* samples = nullptr;  ///< in place of `queries`
    std::span<const Rgb> contributions{};   ///< unoccluded, of each connection; empty: unknown

    size_t size() const;
    /// The connections as queries. `made` holds those that are made of samples.
    std::span<const ShadowQuery> as_queries(std::vector<ShadowQuery>& made) const;
};

/// Order in which an oracle should get the connections of a tile. Empty: any order.
struct PairOrder {
    std::span<const uint32_t> eye;  ///< the tile's eye points in processing order
    /// Ends of runs in `eye`. The connections of one run belong in one call of `pairs`.
    std::span<const uint32_t> run_end;
};

/// A change of an answer: the weight of a column's contribution, added to that of its bit. The answer was
/// checked with probability `share`.
struct Correction {
    uint32_t column;
    float weight;
    float share;
};

using LightGroupSet = std::bitset<kLightGroups>;

/// What an oracle says about an ask, as rows × columns. A block has a row for each eye point and a column for
/// each light. Pairs have one row, and connection i is column i.
///
/// All members point into the oracle and are valid until its next call. Whoever gets an answer may change its
/// bits.
struct Answer {
    BitMatrix* bits = nullptr;  ///< 1 = visible; 0 where nothing was asked
    /// For oracles that skip connections at random: weights 1/probability of visible columns, row by row.
    /// Empty: all weights are 1.
    std::span<const float> weights{};
    /// The row of `weights` that serves each row; empty: its own.
    std::span<const uint32_t> weight_row{};
    /// By row and column. The weights of pairs include them; those of blocks do not.
    std::span<const Correction> corrections{};
    std::span<const uint32_t> correction_begin{};  ///< by row, and the end; empty: all are of the first row
    /// Answers that are less certain than others: a quantized cache found that its cells disagree. nullptr:
    /// the oracle cannot tell.
    const BitMatrix* doubts = nullptr;
    LightGroupSet exact{};  ///< the light groups whose answers are those of exact rays
    bool logged = false;    ///< the log of the ask has every query

    std::span<Word> row(size_t r) const { return bits->row_span(r); }
    bool is_exact(int group) const { return exact.test(size_t(group)); }
    std::span<const float> weights_of(size_t r) const {
        if (weights.empty()) return {};
        return weights.subspan((weight_row.empty() ? r : weight_row[r]) * bits->columns(), bits->columns());
    }
    std::span<const Correction> corrections_of(size_t r) const {
        if (correction_begin.empty()) return r == 0 ? corrections : std::span<const Correction>();
        return corrections.subspan(correction_begin[r], correction_begin[r + 1] - correction_begin[r]);
    }
    /// The weights of a row of a block with their corrections, for who wants all in one row. Sets the bits of
    /// corrected columns by their weight. Empty: all weights are 1. `scratch` holds the row.
    std::span<const float> corrected_weights(size_t r, std::vector<float>& scratch) const;
};

class VisibilityOracle {
public:
    VisibilityOracle() = default;
    VisibilityOracle(VisibilityOracle&&) = default;
    virtual ~VisibilityOracle() = default;
    /// Long calls throw `Cancelled` soon after `control` requests it. `control` must outlive the oracle.
    virtual void watch(const Control& control) {
        control_ = &control;
        for (VisibilityOracle* oracle : wrapped_) oracle->watch(control);
    }
    /// Discards the previous tile and reads the eye points of the next one.
    virtual void begin_tile(const EyeBlock& /*eyes*/) {}
    /// The order in which `pairs` should get connections of this tile: samples of a light group, or queries
    /// if there is no group. Valid until the next call.
    virtual PairOrder order(const EyeBlock& /*eyes*/, std::optional<int> /*group*/) { return {}; }
    /// Answers a block.
    virtual Answer block(const BlockAsk& ask, Counters& counters) = 0;
    /// Answers connections of single eye points.
    virtual Answer pairs(const PairsAsk& ask, Counters& counters) = 0;

protected:
    /// Control is handed on to this oracle, which is a part of this one.
    void wrap(VisibilityOracle& oracle) { wrapped_.push_back(&oracle); }
    const Control& control() const { return *control_; }
    /// Call this every few milliseconds of work.
    void check_cancelled() const { control_->check(); }
    /// The bits of the next answer, all 0.
    BitMatrix& new_bits(size_t rows, size_t columns) {
        bits_.reset(rows, columns);
        return bits_;
    }

private:
    static inline const Control unwatched_{};
    const Control* control_ = &unwatched_;
    std::vector<VisibilityOracle*> wrapped_;
    BitMatrix bits_;
};

}  // namespace viscache
