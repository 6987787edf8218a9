#include "viscache/visibility/exact.h"

#include "viscache/visibility/shadow_ray.h"

namespace viscache {

uint64_t count_bits(const BitMatrix& m) {
    uint64_t n = 0;
    for (size_t r = 0; r < m.rows(); ++r)
        for (Word w : m.row_span(r)) n += uint64_t(std::popcount(w));
    return n;
}

void ExactOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
                        Counters& counters) {
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
    RayPacket16 origin, packet;
    uint16_t columns[64], answers[64];
    for (size_t first = 0; first < wanted.rows(); first += 16) {
        check_cancelled();
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
                aim16(packet, lights.semantic, extent_);
                answers[j] = uint16_t(columns[j] & ~caster_.occluded16(columns[j], packet, coherence_));
            }
            if (any) or_columns16(visible, first, w, answers);
        }
    }
}

void ExactOracle::block_by_pixel(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                                 BitMatrix& visible) {
    RayPacket16 packet;
    size_t lane_light[16];
    for (size_t row = 0; row < wanted.rows(); ++row) {
        check_cancelled();
        int used = 0;
        auto flush = [&] {
            if (!used) return;
            pad_lanes(packet, used);
            const uint16_t mask = uint16_t(used == 16 ? 0xffff : (1 << used) - 1);
            const uint16_t blocked = caster_.occluded16(mask, packet, Coherence::kIncoherent);
            for (int i = 0; i < used; ++i)
                if (!(blocked >> i & 1)) visible.set(row, lane_light[i]);
            used = 0;
        };
        for_each_bit(wanted.row_span(row), [&](size_t k) {
            set_lane(packet, used, shadow_ray(eyes, uint32_t(row), lights, k, extent_));
            lane_light[used++] = k;
            if (used == 16) flush();
        });
        flush();
    }
}

void ExactOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                        Counters& counters) {
    for (size_t first = 0; first < queries.size(); first += 16) {
        if (first % 4096 == 0) check_cancelled();
        const int n = int(std::min<size_t>(16, queries.size() - first));
        RayPacket16 packet;
        uint16_t mask = 0;
        for (int i = 0; i < n; ++i) {
            const ShadowQuery& q = queries[first + size_t(i)];
            const Ray ray = shadow_ray(eyes, q, extent_);
            const bool ok = is_traceable(eyes.origin[q.eye]) && is_traceable(is_direction(q.semantic) ? q.far : q.ray_end);
            counters.bypassed += !ok;
            set_lane(packet, i, ok ? ray : Ray{{0, 0, 0}, 0, {0, 0, 1}, 1});
            mask |= uint16_t(uint16_t(ok) << i);
        }
        pad_lanes(packet, n);
        const uint16_t seen = uint16_t(mask & ~caster_.occluded16(mask, packet, Coherence::kIncoherent));
        for (int i = 0; i < n; ++i) {
            const bool is_visible = seen >> i & 1;
            if (is_visible) set_bit(visible.data(), first + size_t(i));
            GroupCounters& group = counters.group(queries[first + size_t(i)].group);
            group.queries += 1, group.rays += 1, group.occluded += !is_visible;
        }
    }
}

}  // namespace viscache
