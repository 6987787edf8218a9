#include "viscache/visibility/visibility_rows.h"

#include "viscache/visibility/row_blocks.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

namespace {

constexpr size_t kPointsPerBlock = 256, kFewestPointsPerBlock = 4;

/// Bits of the far ends above the plane through p with normal n; for directions, p is the origin.
void upper_hemisphere(const FarEnds& ends, Vec3 p, Vec3 n, std::span<Word> row) {
    for (size_t w = 0; w < words_for(ends.count); ++w) {
        uint8_t above[kWordBits];
        const size_t first = w * kWordBits;
        for (size_t j = 0; j < kWordBits; ++j)
            above[j] = (ends.x[first + j] - p.x) * n.x + (ends.y[first + j] - p.y) * n.y +
                           (ends.z[first + j] - p.z) * n.z >
                       0;
        Word bits = 0;
        for (size_t j = 0; j < kWordBits; ++j) bits |= Word{above[j]} << j;
        row[w] = bits;
    }
    // Padding columns are zero vectors, which may lie above a plane
    if (const size_t used = ends.count % kWordBits) row[ends.count / kWordBits] &= (Word{1} << used) - 1;
}

}  // namespace

FarEnds far_ends(std::span<const Vec3> directions, float t_max) {
    FarEnds sky;
    sky.semantic = Semantic::kDirection;
    sky.group = int(LightGroup::kAmbient);
    sky.count = directions.size();
    sky.t_max = t_max;
    for (auto* v : {&sky.x, &sky.y, &sky.z, &sky.nx, &sky.ny, &sky.nz, &sky.density})
        v->resize(row_words_for(sky.count) * kWordBits);
    for (size_t k = 0; k < sky.count; ++k) {
        sky.x[k] = directions[k].x;
        sky.y[k] = directions[k].y;
        sky.z[k] = directions[k].z;
    }
    sky.tx = sky.x;
    sky.ty = sky.y;
    sky.tz = sky.z;
    return sky;
}

void RowBlock::fill(const RowInput& input, const FarEnds& ends, std::span<const uint32_t> points,
                    float extent) {
    const bool along = is_direction(ends.semantic);
    eyes.clear();
    wanted.reset(points.size(), ends.count);
    for (size_t i = 0; i < points.size(); ++i) {
        const Vec3 position = input.position[points[i]], normal = input.normal[points[i]];
        eyes.position.push_back(position);
        eyes.normal.push_back(normal);
        eyes.origin.push_back(spawn(position, normal, extent));
        upper_hemisphere(ends, along ? Vec3{} : position, normal, wanted.row_span(i));
    }
}

namespace {

/// State of one thread.
class SkyWorker {
public:
    SkyWorker(const RayCaster& caster, float extent, const FarEnds& sky, std::optional<PacketOrder> order,
              const Control& control)
        : extent_(extent), sky_(sky), oracle_(caster, extent, order) {
        oracle_.watch(control);
    }
    /// The rows of some neighbouring points; row i is that of points[i].
    const BitMatrix& rows(const RowInput& input, std::span<const uint32_t> points) {
        block_.fill(input, sky_, points, extent_);
        oracle_.begin_tile(block_.eyes);
        return *oracle_.block({block_.eyes, sky_, block_.wanted}, counters_).bits;
    }
    uint64_t rays() const { return counters_.rays(); }

private:
    float extent_;
    const FarEnds& sky_;
    ExactOracle oracle_;
    RowBlock block_;
    Counters counters_;
};

}  // namespace

uint64_t visibility_rows(const RayCaster& caster, float extent, const RowInput& input, std::span<Word> rows,
                         std::optional<PacketOrder> order, int threads, const Control& control,
                         std::atomic<uint64_t>* done) {
    const FarEnds sky = far_ends(input.direction, input.t_max);
    const size_t n = input.position.size();
    threads = resolve_threads(threads);
    const size_t share = (n + size_t(threads) - 1) / size_t(threads);
    const size_t per_block = std::clamp(share, kFewestPointsPerBlock, kPointsPerBlock);
    std::vector<SkyWorker> workers;
    for (size_t t = 0; t < std::min((n + per_block - 1) / per_block, size_t(threads)); ++t)
        workers.emplace_back(caster, extent, sky, order, control);
    in_row_blocks(input.position, per_block, row_words_for(sky.count), rows, threads, control, done,
                  [&](std::span<const uint32_t> points, int t) -> const BitMatrix& {
                      return workers[size_t(t)].rows(input, points);
                  });
    uint64_t rays = 0;
    for (const SkyWorker& worker : workers) rays += worker.rays();
    return rays;
}

}  // namespace viscache
