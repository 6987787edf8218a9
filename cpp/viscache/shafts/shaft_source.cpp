#include "viscache/shafts/shaft_source.h"

#include "viscache/math/wall_clock.h"
#include "viscache/shafts/shaft_choice.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

/// Why packets answer the whole frame; empty if shafts are used.
std::string ShaftSource::reason_against(const FrameStart& frame) const {
    uint64_t points = 0;
    for (const FarEnds* lights : frame.lights())
        if (!is_direction(lights->semantic)) points += std::min(lights->count, frame.lights_per_point());
    if (points == 0) return "no light is a point that all eye points share";
    if (!shafts_.refusal().empty()) return shafts_.refusal();
    const uint64_t queries = points * frame.eye_points();
    if (options_.choose && !shafts_.has_tree() && queries < kLeastQueriesPerTriangle * shafts_.triangles())
        return "too few queries for the tree of the scene";
    return {};
}

void ShaftSource::prepare(FrameStart& frame, Control& control) {
    exact_.prepare(frame, control);
    no_shafts_ = reason_against(frame);
    if (!no_shafts_.empty()) return;
    const double start = wall_seconds();
    shafts_.tree(frame.threads(), control);
    tree_s_ = wall_seconds() - start;
}

std::unique_ptr<VisibilityOracle> ShaftSource::make() {
    if (!no_shafts_.empty()) return exact_.make();
    return std::make_unique<ShaftOracle>(shafts_, caster_, exact_.make(), options_, totals_);
}

void ShaftSource::report(Counters& counters, SourceReport& out) const {
    exact_.report(counters, out);
    const auto add = [&](const char* name, SourceReport::Value v) { out.engine.emplace_back(name, v); };
    if (!no_shafts_.empty()) {
        if (!options_.choose) add("no_shafts", no_shafts_);
        return;
    }
    const ShaftTotals::Sums sums = totals_.sums();
    add("shaft_queries", sums.queries);
    add("left_to_packets", sums.left_to_packets);
    add("shaft_nodes", sums.work.nodes);
    add("shaft_blocks", sums.work.blocks);
    add("shaft_lists", sums.work.lists);
    add("shaft_pairs", sums.work.pairs);
    add("shaft_doubted", sums.work.doubted);
    add("shaft_long_lists", sums.work.long_lists);
    add("shaft_asked_packets", sums.work.asked);
    add("shaft_traced_packets", sums.work.packets);
    out.timings.emplace_back("shaft_tree_s", tree_s_);
}

}  // namespace viscache
