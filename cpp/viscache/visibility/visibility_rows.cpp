#include "viscache/visibility/visibility_rows.h"

#include <cstring>

#include "viscache/math/morton.h"

namespace viscache {

namespace {

constexpr size_t kPointsPerBlock = 256, kFewestPointsPerBlock = 4;
constexpr size_t kTrialPeriod = 128;  // blocks between trials of packet orders

/// Bits of the directions above the plane with normal n. Padding columns are zero vectors and never above
/// it.
void upper_hemisphere(const FarEnds& sky, Vec3 n, std::span<Word> row) {
    for (size_t w = 0; w < row.size(); ++w) {
        uint8_t above[kWordBits];
        const size_t first = w * kWordBits;
        for (size_t j = 0; j < kWordBits; ++j)
            above[j] = sky.x[first + j] * n.x + sky.y[first + j] * n.y + sky.z[first + j] * n.z > 0;
        Word bits = 0;
        for (size_t j = 0; j < kWordBits; ++j) bits |= Word{above[j]} << j;
        row[w] = bits;
    }
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

void RowBlock::fill(const RowInput& input, const FarEnds& sky, std::span<const uint32_t> points,
                    float extent) {
    eyes.clear();
    wanted.reset(points.size(), sky.count);
    for (size_t i = 0; i < points.size(); ++i) {
        const Vec3 position = input.position[points[i]], normal = input.normal[points[i]];
        eyes.position.push_back(position);
        eyes.normal.push_back(normal);
        eyes.origin.push_back(spawn(position, normal, extent));
        upper_hemisphere(sky, normal, wanted.row_span(i));
    }
}

namespace {

/// State of one thread.
class Worker {
public:
    Worker(const RayCaster& caster, float extent, const FarEnds& sky, std::optional<PacketOrder> order,
           const Control& control)
        : extent_(extent),
          sky_(sky),
          by_light_(caster, extent, PacketOrder::kByLight),
          by_pixel_(caster, extent, PacketOrder::kByPixel),
          order_({PacketOrder::kByLight, PacketOrder::kByPixel}, order, kTrialPeriod) {
        by_light_.watch(control);
        by_pixel_.watch(control);
    }
    /// The rows of some neighbouring points; row i is that of points[i].
    const BitMatrix& rows(const RowInput& input, std::span<const uint32_t> points) {
        block_.fill(input, sky_, points, extent_);
        visible_.reset(points.size(), sky_.count);
        order_.piece([&](PacketOrder order) {
            ExactOracle& oracle = order == PacketOrder::kByLight ? by_light_ : by_pixel_;
            const uint64_t before = counters_.rays();
            oracle.begin_tile(block_.eyes);
            oracle.block(block_.eyes, sky_, block_.wanted, visible_, counters_);
            return size_t(counters_.rays() - before);
        });
        return visible_;
    }
    uint64_t rays() const { return counters_.rays(); }

private:
    float extent_;
    const FarEnds& sky_;
    ExactOracle by_light_, by_pixel_;
    Trial<PacketOrder> order_;
    RowBlock block_;
    BitMatrix visible_;
    Counters counters_;
};

}  // namespace

uint64_t visibility_rows(const RayCaster& caster, float extent, const RowInput& input, std::span<Word> rows,
                         std::optional<PacketOrder> order, int threads, const Control& control,
                         std::atomic<uint64_t>* done) {
    const FarEnds sky = far_ends(input.direction, input.t_max);
    const size_t words = row_words_for(sky.count), n = input.position.size();
    // Spatial neighbours share packets, regardless of the order of the rows
    const std::vector<uint32_t> along = morton_order(input.position);
    threads = resolve_threads(threads);
    const size_t share = (n + size_t(threads) - 1) / size_t(threads);
    const size_t per_block = std::clamp(share, kFewestPointsPerBlock, kPointsPerBlock);
    const size_t blocks = (n + per_block - 1) / per_block;
    std::vector<Worker> workers;
    for (size_t t = 0; t < std::min(blocks, size_t(threads)); ++t)
        workers.emplace_back(caster, extent, sky, order, control);
    parallel_for(blocks, threads, [&](size_t block, int t) {
        control.check();
        const size_t first = block * per_block, count = std::min(per_block, n - first);
        const auto points = std::span(along).subspan(first, count);
        const BitMatrix& found = workers[size_t(t)].rows(input, points);
        for (size_t i = 0; i < count; ++i)
            std::memcpy(&rows[points[i] * words], found.row(i), words * sizeof(Word));
        if (done) *done += count;
    });
    uint64_t rays = 0;
    for (const Worker& worker : workers) rays += worker.rays();
    return rays;
}

}  // namespace viscache
