#include "viscache/visibility/shaft_source.h"

#include "viscache/math/wall_clock.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

void ShaftSource::prepare(FrameStart& frame, Control& control) {
    exact_.prepare(frame, control);
    const double start = wall_seconds();
    bool has_points = false;
    for (const FarEnds* lights : frame.lights())
        has_points = has_points || (lights->count && !is_direction(lights->semantic));
    if (has_points && shafts_.refusal().empty()) shafts_.tree(control);
    tree_s_ = wall_seconds() - start;
}

void ShaftSource::report(Counters& counters, SourceReport& out) const {
    exact_.report(counters, out);
    const ShaftTotals::Sums sums = totals_.sums();
    const auto add = [&](const char* name, SourceReport::Value v) { out.engine.emplace_back(name, v); };
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
    if (!shafts_.refusal().empty()) add("no_shafts", shafts_.refusal());
    out.timings.emplace_back("shaft_tree_s", tree_s_);
}

}  // namespace viscache
