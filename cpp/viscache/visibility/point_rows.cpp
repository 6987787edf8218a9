#include "viscache/visibility/point_rows.h"

#include "viscache/visibility/row_blocks.h"

namespace viscache {

namespace {

constexpr size_t kPointsPerRowBlock = 4096;

class RowsStart final : public FrameStart {
public:
    RowsStart(const FarEnds& ends, uint64_t points, int threads)
        : ends_{&ends}, points_(points), threads_(threads) {}
    std::span<const FarEnds* const> lights() const override { return ends_; }
    uint64_t eye_points() const override { return points_; }
    int threads() const override { return threads_; }
    Counters ask_small(size_t, OracleSource&, Control&) override {
        throw std::logic_error("rows are exact: there is nothing to learn");
    }

private:
    std::array<const FarEnds*, 1> ends_;
    uint64_t points_;
    int threads_;
};

/// State of one thread.
struct RowWorker {
    std::unique_ptr<VisibilityOracle> oracle;
    RowBlock block;
    Counters counters;
};

}  // namespace

PointRows point_rows(OracleSource& source, float extent, const RowInput& input, const FarEnds& ends,
                     std::span<Word> rows, int threads, Control& control) {
    threads = resolve_threads(threads);
    RowsStart start(ends, input.position.size(), threads);
    source.prepare(start, control);
    std::vector<RowWorker> workers(static_cast<size_t>(threads));
    in_row_blocks(input.position, kPointsPerRowBlock, row_words_for(ends.count), rows, threads, control,
                  &control.done, [&](std::span<const uint32_t> points, int t) -> const BitMatrix& {
                      RowWorker& own = workers[size_t(t)];
                      if (!own.oracle) {
                          own.oracle = source.make();
                          own.oracle->watch(control);
                      }
                      own.block.fill(input, ends, points, extent);
                      own.oracle->begin_tile(own.block.eyes);
                      const BlockAsk ask{own.block.eyes, ends, own.block.wanted};
                      return *own.oracle->block(ask, own.counters).bits;
                  });
    PointRows out;
    Counters counters;
    for (const RowWorker& worker : workers) counters.merge(worker.counters);
    source.report(counters, out.report);
    out.rays = counters.rays();
    return out;
}

}  // namespace viscache
