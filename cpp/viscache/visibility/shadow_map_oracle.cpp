#include "viscache/visibility/shadow_map_oracle.h"

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

void ShadowMapOracle::watch(const Control& control) {
    VisibilityOracle::watch(control);
    exact_.watch(control);
}

void ShadowMapOracle::block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                            BitMatrix& visible, Counters& counters) {
    const uint64_t queries = count_bits(wanted);
    if (!maps_.covers(lights)) {
        exact_.block(eyes, lights, wanted, visible, counters);
        counters.bypassed += queries;
        return;
    }
    for (size_t first = 0; first < wanted.rows(); first += 16) {
        check_cancelled();
        const Receivers16 receivers = receivers_of(eyes, first);
        for (size_t w = 0; w < wanted.row_words(); ++w) {
            uint16_t columns[64];
            columns16(wanted, first, w, columns);
            for (size_t j = 0; j < 64; ++j)
                if (columns[j]) columns[j] &= maps_.lit16(lights, w * kWordBits + j, receivers);
            or_columns16(visible, first, w, columns);
        }
    }
    GroupCounters& group = counters.group(lights.group);
    group.queries += queries;
    group.occluded += queries - count_bits(visible);
    counters.lookups += queries;
}

void ShadowMapOracle::pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                            std::span<Word> visible, Counters& counters) {
    const uint64_t before = counters.bypassed;
    exact_.pairs(eyes, queries, visible, counters);
    counters.bypassed = before + queries.size();
}

}  // namespace viscache
