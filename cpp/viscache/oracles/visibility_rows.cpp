#include "viscache/oracles/visibility_rows.h"

#include "viscache/oracles/exact.h"
#include "viscache/visibility/row_blocks.h"

namespace viscache {

namespace {

constexpr size_t kPointsPerBlock = 256, kFewestPointsPerBlock = 4;

/// State of one thread.
class SkyWorker {
public:
    SkyWorker(const RayCaster& caster, float extent, const FarEnds& sky, std::optional<PacketOrder> order,
              const Control& control)
        : extent_(extent), sky_(sky), oracle_(caster, order) {
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
