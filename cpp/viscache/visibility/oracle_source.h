#pragma once
// Where the oracles of one frame come from.
//
// A source is made for one frame. The frame lets it prepare (shadow maps are traced, visibilities are
// learned), asks it for one oracle per thread and tells it of its course. What oracles learn is handed over
// between rounds, in the order of the items, so that answers do not depend on threads.
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/visibility/counters.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

class OracleSource;

/// What a source may ask of a frame before the first item.
class FrameStart {
public:
    virtual ~FrameStart() = default;
    /// The light groups that all eye points share. They stay as they are for the whole frame.
    virtual std::span<const FarEnds* const> lights() const = 0;
    /// Asks the queries of a small version of the frame, with about `pixels` eye samples, to the oracles of
    /// another source. Returns what it counted; the frame adds these rays to its own.
    virtual Counters ask_small(size_t pixels, OracleSource& source, Control& control) = 0;
    virtual int threads() const = 0;
};

/// What a source adds to a frame's account of itself.
struct SourceReport {
    using Value = std::variant<uint64_t, double, std::string>;
    std::vector<std::pair<std::string, uint64_t>> counters;
    std::vector<std::pair<std::string, double>> timings;
    std::vector<std::pair<std::string, Value>> engine;  ///< which engine traced how much
};

class OracleSource {
public:
    virtual ~OracleSource() = default;
    /// Called once, before the first oracle is made.
    virtual void prepare(FrameStart& /*frame*/, Control& /*control*/) {}
    /// The oracle of one worker thread; called from that thread.
    virtual std::unique_ptr<VisibilityOracle> make() = 0;
    /// Not 0: tiles have this edge in pixels, and tile i belongs to thread i mod threads.
    virtual int dealt_tile_edge() const { return 0; }
    // Items are tiles, or samples of tiles in bidirectional path tracing. A frame of tiles is one round.
    virtual void begin_round(size_t /*items*/) {}
    /// Called after each item, from its thread.
    virtual void end_item(VisibilityOracle&, size_t /*item*/) {}
    /// Called after a round, from one thread.
    virtual void end_round(Counters&) {}
    /// Called once, when the frame is done: rays of the preparation are added to `counters`.
    virtual void report(Counters& /*counters*/, SourceReport& /*out*/) const {}
};

}  // namespace viscache
