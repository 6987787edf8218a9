#include "viscache/visibility/exact.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "viscache/visibility/direction_bins.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

uint64_t count_bits(const BitMatrix& m) {
    uint64_t n = 0;
    for (size_t r = 0; r < m.rows(); ++r)
        for (Word w : m.row_span(r)) n += uint64_t(std::popcount(w));
    return n;
}

void ExactOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                        BitMatrix& visible, Counters& counters) {
    switch (order_) {
        case PacketOrder::kByLight: block_by_light(eyes, lights, wanted, visible); break;
        case PacketOrder::kByPixel: block_by_pixel(eyes, lights, wanted, visible); break;
    }
    GroupCounters& group = counters.group(lights.group);
    const uint64_t asked = count_bits(wanted);
    group.queries += asked, group.rays += asked, group.occluded += asked - count_bits(visible);
}

void ExactOracle::block_by_light(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                                 BitMatrix& visible) {
    for (size_t first = 0; first < wanted.rows(); first += 16) {
        check_cancelled();
        block_flag_.piece(
            [&](Coherence flag) { return rows16_by_light(first, eyes, lights, wanted, visible, flag); });
    }
}

/// Sixteen eye points towards all their lights, one light after another. Returns the number of rays.
size_t ExactOracle::rows16_by_light(size_t first, const EyeBlock& eyes, const FarEnds& lights,
                                    const BitMatrix& wanted, BitMatrix& visible, Coherence flag) {
    RayPacket16 origin, packet;
    uint16_t columns[64], answers[64];
    size_t rays = 0;
    const size_t n = std::min<size_t>(16, wanted.rows() - first);
    for (size_t i = 0; i < 16; ++i) {
        const Vec3 o = eyes.origin[first + std::min(i, n - 1)];
        origin.ox[i] = o.x, origin.oy[i] = o.y, origin.oz[i] = o.z;
    }
    for (size_t w = 0; w < wanted.row_words(); ++w) {
        columns16(wanted, first, w, columns);
        bool any = false;
        for (int j = 0; j < 64; ++j) {
            answers[j] = 0;
            if (!columns[j]) continue;
            any = true;
            // Aim the 16 eye points at light k
            const size_t k = w * kWordBits + size_t(j);
            std::memcpy(packet.ox, origin.ox, 3 * sizeof origin.ox);
            for (int i = 0; i < 16; ++i)
                packet.dx[i] = lights.tx[k], packet.dy[i] = lights.ty[k], packet.dz[i] = lights.tz[k];
            aim16(packet, lights, extent_);
            answers[j] = uint16_t(columns[j] & ~caster_.occluded16(columns[j], packet, flag));
            rays += size_t(std::popcount(columns[j]));
        }
        if (any) or_columns16(visible, first, w, answers);
    }
    return rays;
}

void ExactOracle::block_by_pixel(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                                 BitMatrix& visible) {
    for (size_t row = 0; row < wanted.rows(); ++row) {
        check_cancelled();
        block_flag_.piece(
            [&](Coherence flag) { return row_by_pixel(row, eyes, lights, wanted, visible, flag); });
    }
}

/// One eye point towards all its lights, sixteen neighbours of the list at a time. Returns the number of
/// rays.
size_t ExactOracle::row_by_pixel(size_t row, const EyeBlock& eyes, const FarEnds& lights,
                                 const BitMatrix& wanted, BitMatrix& visible, Coherence flag) {
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
        rays += size_t(used), used = 0;
    };
    for_each_bit(wanted.row_span(row), [&](size_t k) {
        set_lane(packet, used, shadow_ray(eyes, uint32_t(row), lights, k, extent_));
        lane_light[used++] = k;
        if (used == 16) flush();
    });
    flush();
    return rays;
}

/// Numbers of the traceable queries, by direction and then in the order asked: neighbours towards the same
/// side.
void ExactOracle::sort_by_direction(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                                    Counters& counters) {
    constexpr uint32_t kBinEdge = 16, kBins = kBinEdge * kBinEdge;
    constexpr uint16_t kLeftOut = 0xffff;
    bin_.resize(queries.size());
    begin_.assign(kBins + 1, 0);
    for (size_t i = 0; i < queries.size(); ++i) {
        const ShadowQuery& q = queries[i];
        const Vec3 far = is_direction(q.semantic) ? q.far : q.ray_end;
        if (!is_traceable(eyes.origin[q.eye]) || !is_traceable(far)) {
            bin_[i] = kLeftOut, ++counters.bypassed;
            continue;
        }
        bin_[i] =
            uint16_t(direction_bin<kBinEdge>(is_direction(q.semantic) ? far : far - eyes.origin[q.eye]));
        ++begin_[bin_[i] + 1u];
    }
    for (size_t b = 0; b < kBins; ++b) begin_[b + 1] += begin_[b];
    order_by_direction_.resize(begin_.back());
    for (size_t i = 0; i < queries.size(); ++i)
        if (bin_[i] != kLeftOut) order_by_direction_[begin_[bin_[i]]++] = uint32_t(i);
}

void ExactOracle::trace_sorted(std::span<const uint32_t> order, const EyeBlock& eyes,
                               std::span<const ShadowQuery> queries, std::span<Word> visible,
                               Coherence flag) {
    for (size_t at = 0; at < order.size(); at += 16) {
        const int n = int(std::min<size_t>(16, order.size() - at));
        RayPacket16 packet;
        for (int i = 0; i < n; ++i)
            set_lane(packet, i, shadow_ray(eyes, queries[order[at + size_t(i)]], extent_));
        pad_lanes(packet, n);
        const uint32_t mask = (1u << n) - 1;
        for (uint32_t seen = mask & ~uint32_t(caster_.occluded16(uint16_t(mask), packet, flag)); seen;
             seen &= seen - 1)
            set_bit(visible.data(), order[at + size_t(std::countr_zero(seen))]);
    }
}

void ExactOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                        Counters& counters) {
    constexpr size_t kPiece = 1024;
    sort_by_direction(eyes, queries, counters);
    const std::span<const uint32_t> order(order_by_direction_);
    for (size_t first = 0; first < order.size(); first += kPiece) {
        check_cancelled();
        pairs_flag_.piece([&](Coherence flag) {
            const auto piece = order.subspan(first, std::min(kPiece, order.size() - first));
            trace_sorted(piece, eyes, queries, visible, flag);
            return piece.size();
        });
    }
    for (size_t i = 0; i < queries.size(); ++i) {
        GroupCounters& group = counters.group(queries[i].group);
        group.queries += 1, group.rays += 1, group.occluded += !get_bit(visible.data(), i);
    }
}

}  // namespace viscache
