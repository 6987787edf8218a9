#include "viscache/oracles/shadow_map_oracle.h"

namespace viscache {

namespace {

/// Rows [first, first + 16) as arrays; the last row is repeated beyond the end.
Receivers16 receivers_of(const EyeBlock& eyes, size_t first) {
    Receivers16 r;
    for (size_t i = 0; i < 16; ++i) {
        const size_t eye = std::min(first + i, eyes.size() - 1);
        const Vec3 p = eyes.position[eye], n = eyes.normal[eye];
        r.x[i] = p.x;
        r.y[i] = p.y;
        r.z[i] = p.z;
        r.nx[i] = n.x;
        r.ny[i] = n.y;
        r.nz[i] = n.z;
    }
    return r;
}

}  // namespace

Answer ShadowMapOracle::block(const BlockAsk& ask, Counters& counters) {
    const BitMatrix& wanted = ask.wanted;
    const uint64_t queries = count_bits(wanted);
    if (!maps_.covers(ask.lights)) {
        counters.bypassed += queries;
        return {.bits = exact_.block(ask, counters).bits};
    }
    BitMatrix& visible = new_bits(wanted.rows(), wanted.columns());
    for (size_t first = 0; first < wanted.rows(); first += 16) {
        check_cancelled();
        const Receivers16 receivers = receivers_of(ask.eyes, first);
        for (size_t w = 0; w < wanted.row_words(); ++w) {
            uint16_t columns[64];
            columns16(wanted, first, w, columns);
            for (size_t j = 0; j < 64; ++j)
                if (columns[j]) columns[j] &= maps_.lit16(ask.lights, w * kWordBits + j, receivers);
            or_columns16(visible, first, w, columns);
        }
    }
    GroupCounters& group = counters.group(ask.lights.group);
    group.queries += queries;
    group.occluded += queries - count_bits(visible);
    counters.lookups += queries;
    return {.bits = &visible};
}

Answer ShadowMapOracle::pairs(const PairsAsk& ask, Counters& counters) {
    const uint64_t bypassed = counters.bypassed + ask.size();
    const Answer exact = exact_.pairs(ask, counters);
    counters.bypassed = bypassed;
    return {.bits = exact.bits};
}

}  // namespace viscache
