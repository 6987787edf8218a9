#pragma once
// Sources of the oracles of one frame.
//
// A source is made for one frame. The frame calls `prepare` (which can trace shadow maps or learn
// visibilities), takes one oracle per thread, and reports its progress. What oracles learn is merged between
// rounds in the order of the items, so that answers do not depend on the number of threads.
#include <limits>
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

/// The part of a frame that a source can use before the first item.
class FrameStart {
public:
    virtual ~FrameStart() = default;
    /// The light groups that all eye points share. They do not change during the frame.
    virtual std::span<const FarEnds* const> lights() const = 0;
    /// Largest number of lights of a group that an eye point asks for.
    virtual size_t lights_per_point() const { return std::numeric_limits<size_t>::max(); }
    /// Runs the queries of a small version of the frame, with about `pixels` eye samples, through the oracles
    /// of another source. Returns its counters; the frame adds these rays to its own.
    virtual Counters ask_small(size_t pixels, OracleSource& source, Control& control) = 0;
    /// Eye points of the whole frame.
    virtual uint64_t eye_points() const = 0;
    virtual int threads() const = 0;
};

/// What a source adds to the report of a frame.
struct SourceReport {
    using Value = std::variant<uint64_t, double, std::string>;
    std::vector<std::pair<std::string, uint64_t>> counters;
    std::vector<std::pair<std::string, double>> timings;
    std::vector<std::pair<std::string, Value>> engine;  ///< use of the engines
};

class OracleSource {
public:
    virtual ~OracleSource() = default;
    /// Called once, before the first oracle is made.
    virtual void prepare(FrameStart& /*frame*/, Control& /*control*/) {}
    /// The oracle of one worker thread; called from that thread.
    virtual std::unique_ptr<VisibilityOracle> make() = 0;
    /// Tells the source, before all else, that the answers of its oracles will be corrected.
    virtual void expect_corrections() {}
    /// Not 0: tiles have this edge in pixels, and tile i belongs to thread i mod threads.
    virtual int dealt_tile_edge() const { return 0; }
    /// True if its oracles correct a random share of their answers.
    virtual bool corrects() const { return false; }
    // Items are tiles, or samples of tiles in bidirectional path tracing. A frame of tiles is one round.
    virtual void begin_round(size_t /*items*/) {}
    /// Called after each item, from its thread.
    virtual void end_item(VisibilityOracle&, size_t /*item*/) {}
    /// Called after a round, from one thread.
    virtual void end_round(Counters&) {}
    /// Called once at the end of the frame. Rays of the preparation are added to `counters`.
    virtual void report(Counters& /*counters*/, SourceReport& /*out*/) const {}
};

}  // namespace viscache
