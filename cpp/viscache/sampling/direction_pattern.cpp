#include "viscache/sampling/direction_pattern.h"

#include <algorithm>
#include <array>
#include <span>

#include "viscache/math/octahedral.h"
#include "viscache/sampling/rng.h"

namespace viscache {

namespace {

constexpr int kIterations = 20;
constexpr int kSubCells = 8;                        // sub-cells along the edge of a cell
constexpr size_t kSamples = kSubCells * kSubCells;  // samples that represent the area of a cell
constexpr int kReach = 2;  // radius, in cells, of the search for the nearest direction
constexpr float kMargin =
    1e-3f;  // margin in cells, so that rounding cannot move a direction into the next cell

/// Several places represent the same direction across the borders; returns the one nearest to `to`.
// The point itself, and the places where it appears when the square is continued across its left, right,
// upper and lower side. The map is glued to itself there, turned by 180°.
Vec2 unfolded(Vec2 p, Vec2 to) {
    const std::array<Vec2, 5> places{p, Vec2{-p.x, 1 - p.y}, Vec2{2 - p.x, 1 - p.y}, Vec2{1 - p.x, -p.y},
                                     Vec2{1 - p.x, 2 - p.y}};
    return *std::min_element(places.begin(), places.end(), [&](Vec2 a, Vec2 b) {
        const auto distance = [&](Vec2 q) {
            return (q.x - to.x) * (q.x - to.x) + (q.y - to.y) * (q.y - to.y);
        };
        return distance(a) < distance(b);
    });
}

class Lloyd {
public:
    Lloyd(int size, std::vector<Vec3> directions) : size_(size), directions_(std::move(directions)) {
        // Centres of 8 × 8 sub-cells; all stand for the same solid angle, since the map is equal-area.
        const float step = 1.f / float(size * kSubCells);
        for (size_t i = 0; i < directions_.size() * kSamples; ++i) {
            const int cell = int(i / kSamples), sub = int(i % kSamples);
            samples_.push_back(
                equal_area_to_direction({(float(cell % size * kSubCells + sub % kSubCells) + 0.5f) * step,
                                         (float(cell / size * kSubCells + sub / kSubCells) + 0.5f) * step}));
        }
    }

    std::vector<Vec3> run() {
        for (int i = 0; i < kIterations; ++i) iterate();
        return std::move(directions_);
    }

private:
    /// One Lloyd step: moves every direction towards the centroid of the samples nearest to it.
    /// All samples are assigned before any direction moves.
    void iterate() {
        sum_.assign(directions_.size(), {});
        for (int y = 0; y < size_; ++y)
            for (int x = 0; x < size_; ++x) assign_cell({x, y});
        for (int y = 0; y < size_; ++y)
            for (int x = 0; x < size_; ++x) move(y * size_ + x, {x, y});
    }

    void assign_cell(MapCell cell) {
        std::array<int, (2 * kReach + 1) * (2 * kReach + 1)> near;
        size_t n = 0;
        for (int dy = -kReach; dy <= kReach; ++dy)
            for (int dx = -kReach; dx <= kReach; ++dx) {
                // Neighbours on the sphere, across the border of the square, too.
                const MapCell c = folded({cell.x + dx, cell.y + dy}, size_);
                near[n++] = c.y * size_ + c.x;
            }
        const size_t first = size_t(cell.y * size_ + cell.x) * kSamples;
        for (const Vec3& d : std::span(samples_).subspan(first, kSamples)) {
            int best = near[0];
            float best_cos = -2;
            for (int i : near)
                if (const float c = dot(d, directions_[size_t(i)]); c > best_cos) {
                    best_cos = c;
                    best = i;
                }
            sum_[size_t(best)] += d;
        }
    }

    void move(int index, MapCell cell) {
        const Vec3 middle = normalize(sum_[size_t(index)]);
        // No sample is nearest to this direction: it stays.
        if (middle == Vec3{}) return;
        const float n = float(size_);
        const Vec2 centre{(float(cell.x) + 0.5f) / n, (float(cell.y) + 0.5f) / n};
        const Vec2 p = unfolded(direction_to_equal_area(middle), centre);
        // A direction stays in its cell: the pattern remains stratified, and bits keep their place in the
        // quadtree.
        const float half = (0.5f - kMargin) / n;
        directions_[size_t(index)] =
            equal_area_to_direction({std::clamp(p.x, centre.x - half, centre.x + half),
                                     std::clamp(p.y, centre.y - half, centre.y + half)});
    }

    int size_;
    std::vector<Vec3> samples_;  // kSamples per cell
    std::vector<Vec3> directions_, sum_;
};

}  // namespace

std::vector<Vec3> direction_pattern(int map_size, PatternKind kind, uint64_t seed) {
    std::vector<Vec3> directions;
    for (int y = 0; y < map_size; ++y)
        for (int x = 0; x < map_size; ++x) {
            Vec2 in{0.5f, 0.5f};
            // Centres need no random numbers.
            if (kind != PatternKind::kCentres) {
                in = Rng(seed, Purpose::kDirectionPattern, uint64_t(directions.size()), 0).next2();
                in = {kMargin + (1 - 2 * kMargin) * in.x, kMargin + (1 - 2 * kMargin) * in.y};
            }
            directions.push_back(equal_area_to_direction(
                {(float(x) + in.x) / float(map_size), (float(y) + in.y) / float(map_size)}));
        }
    return kind == PatternKind::kLloyd ? Lloyd(map_size, std::move(directions)).run() : directions;
}

}  // namespace viscache
