#include "viscache/shafts/shaft_matrix.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "viscache/math/morton.h"
#include "viscache/math/wall_clock.h"
#include "viscache/shafts/shaft_choice.h"
#include "viscache/visibility/point_order.h"
#include "viscache/visibility/segment_packets.h"
#include "viscache/visibility/visible_matrix.h"

namespace viscache {

namespace {

// Tiles are large enough for shafts to share work; rounds bound the memory of prepared tiles
constexpr size_t kPointsPerMatrixTile = 4096, kTilesPerRound = 64;
constexpr size_t kPointsPerPiece = 128;  // of a tile that packets answer

/// The segments of a tile towards one target.
class TileSegments final : public ShaftRays {
public:
    TileSegments(const RayCaster& caster, std::span<const Vec3> points, std::span<const uint32_t> order,
                 Vec3 target)
        : segments_(caster), points_(points), order_(order), target_(target) {}

    uint32_t occluded(size_t packet, uint32_t mask) override {
        RayPacket16 rays;
        for (size_t i = 0; i < kShaftLanes; ++i) {
            // Lanes beyond the end repeat the last point; their mask is 0
            rays.start(i, points_[order_[std::min(packet * kShaftLanes + i, order_.size() - 1)]]);
            // SegmentPackets takes ends here and makes directions itself
            rays.aim(i, target_);
        }
        return segments_.occluded(uint16_t(mask), rays);
    }

private:
    SegmentPackets segments_;
    std::span<const Vec3> points_;
    std::span<const uint32_t> order_;
    Vec3 target_;
};

struct Question {
    const ShaftScene& scene;
    const RayCaster& caster;
    std::span<const Vec3> points, targets;
    std::span<Word> rows;
    const ShaftOptions& options;
    size_t words() const { return words_for(targets.size()); }
};

/// Some neighbouring points, sorted for packets.
struct Tile {
    std::vector<uint32_t> order;  ///< indices of the points
    ShaftEyes eyes;
    bool by_shafts = false;
    Word tried = 0;  ///< targets of the first word that a trial has answered
};

/// Memory of one thread.
class MatrixWorker {
public:
    explicit MatrixWorker(const Question& q, const Control& control) : q_(q), control_(control) {}

    /// Sorts the points `some` along a tree, and tries a few targets if shafts are a choice.
    void prepare(Tile& tile, std::span<const uint32_t> some) {
        std::vector<Vec3> places(some.size());
        std::ranges::transform(some, places.begin(), [&](uint32_t i) { return q_.points[i]; });
        tile.order = packet_order(places);
        for (uint32_t& i : tile.order) i = some[i];
        // Answers are ORed into rows, word by word
        for (const uint32_t i : some) std::fill_n(&q_.rows[i * q_.words()], q_.words(), Word{0});
        // A point far outside of the scene has coordinates for which no bound of rounding holds
        tile.by_shafts = std::ranges::all_of(places, [&](Vec3 p) { return q_.scene.is_near(p); });
        tile.tried = 0;
        if (!tile.by_shafts) return;
        tile.eyes.build(q_.points, {}, tile.order, q_.scene.scale());
        if (!q_.options.choose) return;
        // The trial counts its own work; what it answers is kept
        const ShaftCounts before = memory_.counts;
        tile.tried = kTrialLights & near_targets(0);
        answer(tile, 0, tile.tried);
        ShaftCounts trial;
        trial.asked = memory_.counts.asked - before.asked;
        trial.packets = memory_.counts.packets - before.packets;
        tile.by_shafts = shafts_pay(trial);
    }

    /// Answers all points for the targets of a word that no trial has answered.
    void answer_rest(const Tile& tile, size_t word) {
        const Word rest = targets_of_word(q_.targets.size(), word) & (word == 0 ? ~tile.tried : ~Word{0});
        // Targets too far away for the bounds are left to packets
        const Word near = tile.by_shafts ? near_targets(word) & rest : 0;
        if (near) answer(tile, word, near);
        if (rest & ~near) trace(tile, word, rest & ~near);
    }
    ShaftTotals::Sums sums() const { return {queries_, left_, memory_.counts}; }

private:
    Word near_targets(size_t word) const {
        Word near = 0;
        for (Word rest = targets_of_word(q_.targets.size(), word); rest; rest &= rest - 1) {
            const int k = std::countr_zero(rest);
            near |= Word{q_.scene.is_near(q_.targets[word * kWordBits + size_t(k)])} << k;
        }
        return near;
    }
    void trace(const Tile& tile, size_t word, Word some) {
        for (size_t first = 0; first < tile.order.size(); first += kPointsPerPiece) {
            control_.check();
            const auto piece =
                std::span(tile.order).subspan(first, std::min(kPointsPerPiece, tile.order.size() - first));
            trace_matrix_tile(q_.caster, q_.points, piece, q_.targets, word, some, q_.rows);
        }
        left_ += tile.order.size() * uint64_t(std::popcount(some));
    }
    void answer(const Tile& tile, size_t word, Word some) {
        // All points ask for the same targets
        columns_.read(some, tile.eyes);
        for (Word rest = some; rest; rest &= rest - 1) {
            control_.check();
            const size_t j = size_t(std::countr_zero(rest));
            answer(tile, j, q_.targets[word * kWordBits + j]);
        }
        visible_.reset(tile.order.size(), kWordBits);
        columns_.write(visible_, 0);
        for (size_t i = 0; i < tile.order.size(); ++i)
            q_.rows[tile.order[i] * q_.words() + word] |= visible_.row(i)[0];
        queries_ += tile.order.size() * uint64_t(std::popcount(some));
    }
    /// One target, column j.
    void answer(const Tile& tile, size_t j, Vec3 target) {
        const ShaftTree& tree = q_.scene.tree(1, control_);
        const Vec3 at = target * q_.scene.scale();
        constexpr float kShare = kSegmentUlps * kUlp;
        // Segments without normals leave out a share of their length that grows with coordinates
        // (segment_epsilon); its bounds for this tile
        const float most = std::max(max_abs(at), tile.eyes.magnitude());
        TileSegments rays(q_.caster, q_.points, tile.order, target);
        const ShaftLight light{.tree = tree,
                               .eyes = tile.eyes,
                               .columns = columns_,
                               .column = j,
                               .light = {at.x, at.y, at.z},
                               .ends = {kShare * most, kShare, kShare},
                               .slack = 4e-6f * std::max(tree.bounds.magnitude(), most),
                               .bounds = q_.options.bounds,
                               .wanted = columns_.wanted(j),
                               .visible = columns_.visible(j)};
        // The measure of `shafts_pay`: packets that were asked against those that were traced
        memory_.counts.asked += tile.eyes.packets();
        shaft_kernel(q_.options.isa)(light, memory_, rays);
    }

    const Question& q_;
    const Control& control_;
    ShaftColumns columns_;
    ShaftMemory memory_;
    BitMatrix visible_;
    uint64_t queries_ = 0, left_ = 0;
};

/// Why packets answer everything; empty if shafts are used.
std::string reason_against(const Question& q) {
    if (!q.scene.refusal().empty()) return q.scene.refusal();
    if (q.points.empty() || q.targets.empty()) return "there are no queries";
    if (!q.options.choose) return {};
    if (q.targets.size() < kLeastLightsPerPoint) return "too few targets";
    const uint64_t queries = uint64_t{q.points.size()} * q.targets.size();
    // A tree that is there costs nothing more
    if (!q.scene.has_tree() && queries < kLeastQueriesPerTriangle * q.scene.triangles())
        return "too few queries for the tree of the scene";
    return {};
}

}  // namespace

ShaftMatrixWork shaft_matrix(const ShaftScene& scene, const RayCaster& caster, std::span<const Vec3> points,
                             std::span<const Vec3> targets, std::span<Word> rows, const ShaftOptions& options,
                             int threads, Control& control) {
    const Question q{scene, caster, points, targets, rows, options};
    ShaftMatrixWork work;
    work.no_shafts = reason_against(q);
    if (!work.no_shafts.empty()) {
        work.sums.left_to_packets = uint64_t{points.size()} * targets.size();
        visible_matrix(caster, points, targets, rows, threads, control);
        return work;
    }
    // Before the workers, which all need it, and with all threads
    if (!scene.has_tree()) {
        const double start = wall_seconds();
        scene.tree(threads, control);
        work.tree_s = wall_seconds() - start;
    }
    threads = resolve_threads(threads);
    std::vector<std::optional<MatrixWorker>> workers(static_cast<size_t>(threads));
    const auto worker = [&](int t) -> MatrixWorker& {
        std::optional<MatrixWorker>& own = workers[size_t(t)];
        return own ? *own : own.emplace(q, control);
    };
    // Tiles of neighbours, whatever the order of the caller
    const std::vector<uint32_t> along = morton_order(points);
    const size_t tiles = (points.size() + kPointsPerMatrixTile - 1) / kPointsPerMatrixTile;
    std::vector<Tile> round(std::min(tiles, kTilesPerRound));
    control.total = tiles * q.words();
    for (size_t next = 0; next < tiles; next += round.size()) {
        const size_t count = std::min(round.size(), tiles - next);
        parallel_for(count, threads, [&](size_t i, int t) {
            control.check();
            const size_t first = (next + i) * kPointsPerMatrixTile;
            worker(t).prepare(round[i], std::span(along).subspan(
                                            first, std::min(kPointsPerMatrixTile, points.size() - first)));
        });
        // A work item is a tile and one word of targets; its words belong to no other item
        parallel_for(count * q.words(), threads, [&](size_t item, int t) {
            worker(t).answer_rest(round[item / q.words()], item % q.words());
            ++control.done;
        });
    }
    ShaftTotals totals;
    for (const auto& own : workers)
        if (own) totals.add(own->sums());
    work.sums = totals.sums();
    return work;
}

}  // namespace viscache
