#include "viscache/visibility/visible_matrix.h"

#include <algorithm>

#include "viscache/math/morton.h"

namespace viscache {

namespace {

constexpr size_t kPointsPerTile = 128, kLanes = 16;

/// Traces 64 targets from neighbouring points. The lanes of a packet are points for one target. With fewer
/// than 16 points, a packet also holds the next targets.
void trace_tile(const RayCaster& caster, std::span<const Vec3> points, std::span<const uint32_t> some,
                std::span<const Vec3> targets, size_t word, size_t row_words, std::span<Word> rows) {
    const size_t first = word * kWordBits, columns = std::min(kWordBits, targets.size() - first);
    const size_t pairs = some.size() * columns;
    for (uint32_t i : some) rows[i * row_words + word] = 0;
    for (size_t begin = 0; begin < pairs; begin += kLanes) {
        const size_t lanes = std::min(kLanes, pairs - begin);
        RayPacket16 packet{};
        for (size_t lane = 0; lane < lanes; ++lane) {
            const size_t pair = begin + lane;
            const Ray ray =
                segment_between(points[some[pair % some.size()]], targets[first + pair / some.size()]);
            packet.ox[lane] = ray.o.x;
            packet.oy[lane] = ray.o.y;
            packet.oz[lane] = ray.o.z;
            packet.dx[lane] = ray.d.x;
            packet.dy[lane] = ray.d.y;
            packet.dz[lane] = ray.d.z;
            packet.t_min[lane] = ray.t_min;
            packet.t_max[lane] = ray.t_max;
        }
        const auto mask = uint16_t((1u << lanes) - 1u);
        const uint16_t occluded = caster.occluded16(mask, packet, Coherence::kCoherent);
        for (size_t lane = 0; lane < lanes; ++lane) {
            const size_t pair = begin + lane;
            const Word free = (occluded >> lane & 1u) ^ 1u;
            rows[some[pair % some.size()] * row_words + word] |= free << (pair / some.size());
        }
    }
}

}  // namespace

void visible_matrix(const RayCaster& caster, std::span<const Vec3> points, std::span<const Vec3> targets,
                    std::span<Word> rows, int threads, Control& control) {
    const size_t row_words = words_for(targets.size());
    const std::vector<uint32_t> along = morton_order(points);  // neighbours in space share packets
    const size_t tiles = (points.size() + kPointsPerTile - 1) / kPointsPerTile;
    control.total = tiles * row_words;
    // A work item is 128 points and one word of targets; its words belong to no other item
    parallel_for(tiles * row_words, threads, [&](size_t item, int) {
        control.check();
        const size_t first = item / row_words * kPointsPerTile;
        const auto some = std::span(along).subspan(first, std::min(kPointsPerTile, points.size() - first));
        trace_tile(caster, points, some, targets, item % row_words, row_words, rows);
        ++control.done;
    });
}

}  // namespace viscache
