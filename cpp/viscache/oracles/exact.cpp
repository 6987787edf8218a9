#include "viscache/oracles/exact.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "viscache/visibility/direction_bins.h"
#include "viscache/visibility/local_samples.h"

namespace viscache {

/// The order in which the rows of a block are traced: rows that ask the same columns stand together, and in
/// space if that is worth it. Sorting in space costs about as much as tracing 20 columns; the later groups of
/// a tile use the same order. Empty: as in the tile.
std::span<const uint32_t> ExactOracle::order_of(const EyeBlock& eyes, const FarEnds& lights) {
    constexpr size_t kFewColumns = 64;
    const size_t sets = lights.sets();
    if (order_given_ == PacketOrder::kByPixel || eyes.size() <= 16) return {};
    // An earlier group of the tile may have paid for the order already
    const bool sorted = order_.size() == eyes.size();
    const bool in_space = sorted || lights.count / sets >= kFewColumns;
    if (in_space && !sorted) order_ = packet_order(eyes.origin);
    if (sets == 1) return in_space ? std::span<const uint32_t>(order_) : std::span<const uint32_t>();
    // A stable counting sort by set: within a set, the order in space remains
    std::vector<uint32_t> begin(sets + 1);
    for (size_t eye = 0; eye < eyes.size(); ++eye) ++begin[lights.set_of(eyes, eye) + 1];
    for (size_t set = 0; set < sets; ++set) begin[set + 1] += begin[set];
    order_by_set_.resize(eyes.size());
    for (size_t i = 0; i < eyes.size(); ++i) {
        const uint32_t eye = in_space ? order_[i] : uint32_t(i);
        order_by_set_[begin[lights.set_of(eyes, eye)]++] = eye;
    }
    return order_by_set_;
}

Answer ExactOracle::block(const BlockAsk& ask, Counters& counters) {
    const EyeBlock& eyes = ask.eyes;
    const FarEnds& lights = ask.lights;
    const BitMatrix& wanted = ask.wanted;
    BitMatrix& visible = new_bits(wanted.rows(), wanted.columns());
    uint64_t queries = 0;
    const std::span<const uint32_t> order = order_of(eyes, lights);
    if (!order.empty()) {
        // Rows are moved to where they are traced and back, which costs little beside the rays:
        // packets are then rows that follow each other
        gather_rows(wanted, order, wanted_in_order_);
        visible_in_order_.reset(wanted.rows(), wanted.columns());
        queries = trace_rows(eyes, order, lights, wanted_in_order_, visible_in_order_);
        scatter_rows(visible_in_order_, order, visible);
    } else {
        queries = trace_rows(eyes, {}, lights, wanted, visible);
    }
    if (ask.log)
        for (uint32_t i = 0; i < wanted.rows(); ++i)
            for_each_bit(wanted.row_span(i), [&](size_t k) {
                // Each query is a cluster of its own, whose representative is the eye point itself
                ask.log->answered(i, uint32_t(k), {i * uint64_t(lights.count) + k, i, 0, true});
            });
    GroupCounters& group = counters.group(lights.group);
    group.queries += queries;
    group.rays += queries;
    group.occluded += queries - count_bits(visible);
    return {.bits = &visible, .exact = LightGroupSet().set(), .logged = ask.log != nullptr};
}

/// Traces a block whose row i belongs to eye point order[i], or i without an order. Returns the number of
/// rays.
uint64_t ExactOracle::trace_rows(const EyeBlock& eyes, std::span<const uint32_t> order, const FarEnds& lights,
                                 const BitMatrix& wanted, BitMatrix& visible) {
    uint64_t queries = 0;
    for (size_t first = 0; first < wanted.rows(); first += 16) {
        check_cancelled();
        if ((order_given_ ? *order_given_ : order_of_rows(wanted, first)) == PacketOrder::kByLight)
            queries += rows16_by_light(first, eyes, order, lights, wanted, visible);
        else
            for (size_t row = first; row < std::min(first + 16, wanted.rows()); ++row)
                queries += row_by_pixel(row, order.empty() ? uint32_t(row) : order[row], eyes, lights, wanted,
                                        visible);
    }
    return queries;
}

/// Traces 16 eye points towards all their lights, one light after another. Returns the number of rays.
size_t ExactOracle::rows16_by_light(size_t first, const EyeBlock& eyes, std::span<const uint32_t> order,
                                    const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible) {
    RayPacket16 origin, packet;
    uint16_t columns[64], answers[64];
    size_t rays = 0;
    const size_t n = std::min<size_t>(16, wanted.rows() - first);
    for (size_t i = 0; i < 16; ++i) {
        // Lanes past the end repeat the last eye point; their columns have no bits
        const size_t row = first + std::min(i, n - 1);
        origin.start(i, eyes.origin[order.empty() ? row : order[row]]);
    }
    // By the spread of the origins: one answer for all lights
    const Coherence flag = flag_given_.value_or(flag_from(caster_, origin));
    for (size_t w = 0; w < words_for(lights.count); ++w) {
        // Rows of eye points become masks of 16, one per light
        columns16(wanted, first, w, columns);
        bool any = false;
        for (int j = 0; j < 64; ++j) {
            answers[j] = 0;
            if (!columns[j]) continue;
            any = true;
            // Aim the 16 eye points at light k
            const size_t k = w * kWordBits + size_t(j);
            std::memcpy(packet.ox, origin.ox, 3 * sizeof origin.ox);
            for (int i = 0; i < 16; ++i) {
                packet.dx[i] = lights.tx[k];
                packet.dy[i] = lights.ty[k];
                packet.dz[i] = lights.tz[k];
            }
            aim16(packet, lights);
            answers[j] = uint16_t(columns[j] & ~caster_.occluded16(columns[j], packet, flag));
            rays += size_t(std::popcount(columns[j]));
        }
        if (any) or_columns16(visible, first, w, answers);
    }
    return rays;
}

/// Traces one eye point towards all its lights, 16 consecutive lights at a time. Returns the number of rays.
size_t ExactOracle::row_by_pixel(size_t row, uint32_t eye, const EyeBlock& eyes, const FarEnds& lights,
                                 const BitMatrix& wanted, BitMatrix& visible) {
    // Rays to different lights go apart
    const Coherence flag = flag_given_.value_or(Coherence::kIncoherent);
    RayPacket16 packet;
    size_t lane_light[16];
    size_t rays = 0;
    int used = 0;
    auto flush = [&] {
        if (!used) return;
        pad_lanes(packet, used);
        const uint16_t mask = uint16_t(used == 16 ? 0xffff : (1 << used) - 1);
        const uint16_t blocked = caster_.occluded16(mask, packet, flag);
        for (int i = 0; i < used; ++i)
            if (!(blocked >> i & 1)) visible.set(row, lane_light[i]);
        rays += size_t(used);
        used = 0;
    };
    for_each_bit(wanted.row_span(row), [&](size_t k) {
        packet.set(size_t(used), shadow_ray(eyes, eye, lights, k));
        lane_light[used++] = k;
        if (used == 16) flush();
    });
    flush();
    return rays;
}

namespace {

/// Connections of a call of `pairs`.
struct QuerySource {
    std::span<const ShadowQuery> queries;
    size_t size() const { return queries.size(); }
    uint32_t eye(size_t i) const { return queries[i].eye; }
    bool is_direction(size_t i) const { return viscache::is_direction(queries[i].semantic); }
    Vec3 target(size_t i) const { return is_direction(i) ? queries[i].far : queries[i].ray_end; }
    Ray ray(const EyeBlock& eyes, size_t i) const { return shadow_ray(eyes, queries[i]); }
};

struct SampleSource {
    const LocalSamples& samples;
    std::span<const uint32_t> eye_of;
    size_t size() const { return samples.size(); }
    uint32_t eye(size_t i) const { return eye_of[i]; }
    bool is_direction(size_t) const { return samples.is_direction(); }
    Vec3 target(size_t i) const { return samples.target(i); }
    Ray ray(const EyeBlock& eyes, size_t i) const { return samples.ray(eyes, eye_of[i], i); }
};

}  // namespace

/// Sorts the indices of the traceable connections by direction; the order within a direction bin is kept. So
/// neighbouring rays have similar directions.
template <class Source>
void ExactOracle::sort_by_direction(const Source& source, const EyeBlock& eyes, Counters& counters) {
    constexpr uint32_t kBinEdge = 16, kBins = kBinEdge * kBinEdge;
    // Bins have fewer numbers than this
    constexpr uint16_t kLeftOut = 0xffff;
    bin_.resize(source.size());
    begin_.assign(kBins + 1, 0);
    for (size_t i = 0; i < source.size(); ++i) {
        const Vec3 origin = eyes.origin[source.eye(i)], target = source.target(i);
        if (!is_traceable(origin) || !is_traceable(target)) {
            bin_[i] = kLeftOut;
            // Embree may abort on coordinates that are not finite, so such connections stay blocked
            // without a ray
            ++counters.bypassed;
            continue;
        }
        bin_[i] = uint16_t(direction_bin<kBinEdge>(source.is_direction(i) ? target : target - origin));
        ++begin_[bin_[i] + 1u];
    }
    // Counting sort: one pass counts, one places
    for (size_t b = 0; b < kBins; ++b) begin_[b + 1] += begin_[b];
    order_by_direction_.resize(begin_.back());
    for (size_t i = 0; i < source.size(); ++i)
        if (bin_[i] != kLeftOut) order_by_direction_[begin_[bin_[i]]++] = uint32_t(i);
}

template <class Source>
void ExactOracle::trace_all(const Source& source, const EyeBlock& eyes, std::span<Word> visible,
                            Counters& counters) {
    constexpr size_t kPiece = 1024;  // rays between checks for cancellation
    sort_by_direction(source, eyes, counters);
    const std::span<const uint32_t> order(order_by_direction_);
    for (size_t at = 0; at < order.size(); at += 16) {
        if (at % kPiece == 0) check_cancelled();
        const int n = int(std::min<size_t>(16, order.size() - at));
        RayPacket16 packet;
        bool to_points = true;
        for (int i = 0; i < n; ++i) {
            const uint32_t connection = order[at + size_t(i)];
            packet.set(size_t(i), source.ray(eyes, connection));
            to_points &= !source.is_direction(connection);
        }
        pad_lanes(packet, n);
        // Directions of a bin differ too much for coherent traversal, samples of an area light do not
        const Coherence flag =
            flag_given_.value_or(to_points ? flag_between(caster_, packet) : Coherence::kIncoherent);
        const uint32_t mask = (1u << n) - 1;
        for (uint32_t seen = mask & ~uint32_t(caster_.occluded16(uint16_t(mask), packet, flag)); seen;
             seen &= seen - 1)
            set_bit(visible.data(), order[at + size_t(std::countr_zero(seen))]);
    }
}

Answer ExactOracle::pairs(const PairsAsk& ask, Counters& counters) {
    BitMatrix& bits = new_bits(1, ask.size());
    const std::span<Word> visible = bits.row_span(0);
    if (const LocalSamples* samples = ask.samples) {
        eye_of_sample_.resize(samples->size());
        for_each_sample(*samples, [&](uint32_t eye, size_t i) { eye_of_sample_[i] = eye; });
        trace_all(SampleSource{*samples, eye_of_sample_}, ask.eyes, visible, counters);
        GroupCounters& group = counters.group(samples->group);
        group.queries += samples->size();
        group.rays += samples->size();
        group.occluded += samples->size() - count_bits(visible);
    } else {
        trace_all(QuerySource{ask.queries}, ask.eyes, visible, counters);
        for (size_t i = 0; i < ask.queries.size(); ++i) {
            GroupCounters& group = counters.group(ask.queries[i].group);
            group.queries += 1;
            group.rays += 1;
            // Queries may be of any group, so they are counted one by one
            group.occluded += !get_bit(visible.data(), i);
        }
    }
    return {.bits = &bits, .exact = LightGroupSet().set()};
}

}  // namespace viscache
