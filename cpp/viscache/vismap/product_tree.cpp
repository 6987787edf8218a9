#include "viscache/vismap/product_tree.h"

#include <algorithm>
#include <cstring>

#include "viscache/math/morton.h"
#include "viscache/math/octahedral.h"

namespace viscache {

namespace {

constexpr uint32_t nodes_at(int level) { return uint32_t{1} << (2 * level); }

/// The largest double below 1
constexpr double kBelowOne = 0x1.fffffffffffffp-1;

/// Chooses one of four masses with a point and rescales the point to the unit square: rows by y, then
/// columns by x. A mass of zero is never chosen.
///
///     | 0 | 1 |     u.y chooses the row by its mass and is rescaled to [0, 1) inside it;
///     | 2 | 3 |     u.x then chooses the column.
///
/// Rescaling keeps what a choice has left of the point, so stratified points stay stratified.
uint32_t pick(const double* mass, Point2& u) {
    const auto choose = [](double first, double second, double& v) -> uint32_t {
        const double t = v * (first + second);
        // Rounding may give t = first; a second part without mass is then out of the question.
        if (t < first || !(second > 0)) {
            v = std::min(t / first, kBelowOne);
            return 0;
        }
        v = std::min((t - first) / second, kBelowOne);
        return 1;
    };
    const uint32_t row = choose(mass[0] + mass[1], mass[2] + mass[3], u.y);
    return 2 * row + choose(mass[2 * row], mass[2 * row + 1], u.x);
}

}  // namespace

void ProductTree::build(const EnvironmentPyramid& light, const Reflection& reflection, int m) {
    light_ = &light;
    m_ = m;
    dense_ = std::max(m, kBaseLevel);
    guided_ = false;
    for (int l = 0; l <= dense_; ++l) mass_[size_t(l)].resize(nodes_at(l));
    // Nothing to sample: only the root's mass must be right.
    if (reflection.black() || !(light.total() > 0)) {
        mass_[0][0] = 0;
        leaves_ = 0;
        return;
    }
    sample_base(reflection);
    refine(reflection);
    raise_to_floor(reflection);
    multiply();
}

ProductTree::Leaf ProductTree::base_leaf(uint32_t code) const {
    return {{red_[code], green_[code], blue_[code]}, b_[code], spread_[code], children_[code]};
}

/// Samples B at the 4096 centres of level 6: four per leaf of level 5, sixteen at a time.
void ProductTree::sample_base(const Reflection& reflection) {
    const size_t n = nodes_at(kBaseLevel);
    touched_.resize(n);
    children_.assign(n, -1);
    deep_.clear();
    leaves_ = int(n);
    greatest_ = 0;
    b_.assign(n, 0);
    spread_.assign(n, 0);
    red_.assign(n, 0);
    green_.assign(n, 0);
    blue_.assign(n, 0);
    reflection.touched(kBaseLevel, 0, touched_);
    RgbBlock block;
    for (uint32_t first = 0; first < n; first += 4) {
        // Four leaves that lie below the horizon cost no sample: half of the sphere and more.
        if (!(touched_[first] | touched_[first + 1] | touched_[first + 2] | touched_[first + 3])) continue;
        reflection.sample(kBaseLevel + kSampleLevels, 4 * first, block);
        const float most = product_kernels().gather(block, &red_[first], &green_[first], &blue_[first],
                                                    &b_[first], &spread_[first]);
        greatest_ = std::max(greatest_, most);
    }
}

/// Splits the leaves in which B̃ is most wrong, weighted by light: the error of a leaf is the range of its
/// samples times its light. B̃ becomes fine around highlights under bright parts of the sky, and only there.
void ProductTree::refine(const Reflection& reflection) {
    const double* light = light_->sums(kBaseLevel);
    const ProductKernels& kernels = product_kernels();
    // Compared with the product's integral: errors below a thousandth of it are not worth a split.
    const double threshold = kMinSplitError * kernels.weigh(b_.data(), light, b_.size());
    const auto less = [](const Candidate& a, const Candidate& b) {
        // Equal errors are split by code, so that the tree does not depend on the heap's order.
        return a.error != b.error ? a.error < b.error : a.code > b.code;
    };
    heap_.clear();
    uint8_t flags[nodes_at(kBaseLevel)];
    kernels.flag(spread_.data(), light, threshold, flags, b_.size());
    for (uint32_t first = 0; first < nodes_at(kBaseLevel); first += 8) {
        // Eight flags are one word: eight leaves without a flag cost one test.
        uint64_t any;
        std::memcpy(&any, &flags[first], sizeof any);
        for (uint32_t z = first; any != 0 && z < first + 8; ++z)
            if (flags[z]) heap_.push_back({double(spread_[z]) * light[z], kBaseLevel, z, -1});
    }
    std::make_heap(heap_.begin(), heap_.end(), less);
    for (int splits = 0; splits < kMostSplits && !heap_.empty(); ++splits) {
        std::pop_heap(heap_.begin(), heap_.end(), less);
        const Candidate c = heap_.back();
        heap_.pop_back();
        const size_t before = deep_.size();
        split(reflection, c);
        // Leaves end here; below, the density follows the light.
        if (c.level + 1 == kDeepestLevel) continue;
        for (uint32_t k = 0; k < 4; ++k) {
            const uint32_t code = 4 * c.code + k;
            const double e = double(deep_[before + k].spread) * light_->sums(c.level + 1)[code];
            if (!(e > threshold)) continue;
            heap_.push_back({e, c.level + 1, code, int32_t(before + k)});
            std::push_heap(heap_.begin(), heap_.end(), less);
        }
    }
}

void ProductTree::split(const Reflection& reflection, const Candidate& c) {
    // Four children in a row, so that one index names them.
    (c.index < 0 ? children_[c.code] : deep_[size_t(c.index)].children) = int32_t(deep_.size());
    RgbBlock block;
    reflection.sample(c.level + 1 + kSampleLevels, 16 * c.code, block);
    float r[4], g[4], b[4], lum[4], spread[4];
    greatest_ = std::max(greatest_, product_kernels().gather(block, r, g, b, lum, spread));
    for (int k = 0; k < 4; ++k) deep_.push_back({{r[k], g[k], b[k]}, lum[k], spread[k], -1});
    // One leaf becomes four.
    leaves_ += 3;
}

// B̃ comes from few samples, and may be 0 where B is not. A floor wherever B can be positive keeps the
// estimate unbiased (p > 0), and bounds B/B̃.
void ProductTree::raise_to_floor(const Reflection& reflection) {
    // If all samples are zero, any positive number will do
    const float floor = greatest_ > 0 ? kFloor * greatest_ : 1.f;
    // First the base, whose split leaves are no longer used, then the leaves below.
    product_kernels().raise(touched_.data(), floor, red_.data(), green_.data(), blue_.data(), b_.data(),
                            b_.size());
    if (deep_.empty()) return;
    for (uint32_t z = 0; z < nodes_at(kBaseLevel); ++z)
        if (children_[z] >= 0) raise_children(reflection, kBaseLevel, z, children_[z], floor);
}

void ProductTree::raise_children(const Reflection& reflection, int level, uint32_t code, int32_t first,
                                 float floor) {
    uint8_t touched[4];
    reflection.touched(level + 1, 4 * code, touched);
    for (uint32_t k = 0; k < 4; ++k) {
        Leaf& leaf = deep_[size_t(first) + k];
        if (touched[k] && leaf.b < floor) {
            leaf.colour += Rgb{1, 1, 1} * (floor - leaf.b);
            leaf.b = floor;
        }
        if (leaf.children >= 0) raise_children(reflection, level + 1, 4 * code + k, leaf.children, floor);
    }
}

/// Sum over the leaves below a node, in the same order for the stored masses and for the warp.
double ProductTree::mass(int level, uint32_t code, const Leaf& leaf) const {
    if (leaf.children < 0) return double(leaf.b) * light_->sums(level)[code];
    double m[4];
    for (uint32_t k = 0; k < 4; ++k) m[k] = mass(level + 1, 4 * code + k, deep_[size_t(leaf.children) + k]);
    return (m[0] + m[1]) + (m[2] + m[3]);
}

double ProductTree::colour_mass(int channel, int level, uint32_t code, const Leaf& leaf) const {
    if (leaf.children < 0) return double(leaf.colour[channel]) * light_->colour_sums(channel, level)[code];
    double m[4];
    for (uint32_t k = 0; k < 4; ++k)
        m[k] = colour_mass(channel, level + 1, 4 * code + k, deep_[size_t(leaf.children) + k]);
    return (m[0] + m[1]) + (m[2] + m[3]);
}

/// Stores the masses of a node with split leaves: descends to the dense level, or fills it below an earlier
/// leaf.
void ProductTree::multiply_split(int level, uint32_t code, const Leaf& leaf) {
    // At the dense level, or at a leaf above it: B̃ of the leaf times the light of each dense node.
    if (level == dense_ || leaf.children < 0) {
        const int below = dense_ - level;
        for (uint32_t z = code << (2 * below); z < (code + 1) << (2 * below); ++z) {
            mass_[size_t(dense_)][z] = mass(dense_, z, leaf);
            for (int c = 0; c < 3; ++c) dense_colour_[size_t(c)][z] = colour_mass(c, dense_, z, leaf);
        }
        return;
    }
    for (uint32_t k = 0; k < 4; ++k)
        multiply_split(level + 1, 4 * code + k, deep_[size_t(leaf.children) + k]);
}

void ProductTree::multiply() {
    const ProductKernels& kernels = product_kernels();
    // Dense nodes in each leaf of the base: 1, 4 or 16
    const size_t n = nodes_at(kBaseLevel), span = nodes_at(dense_ - kBaseLevel);
    const std::array<const float*, 3> channels{red_.data(), green_.data(), blue_.data()};
    // First as if no leaf were split: one long product. Nodes of split leaves are written again below.
    kernels.scale(b_.data(), light_->sums(dense_), mass_[size_t(dense_)].data(), n, span);
    for (int c = 0; c < 3; ++c) {
        dense_colour_[size_t(c)].resize(nodes_at(dense_));
        kernels.scale(channels[size_t(c)], light_->colour_sums(c, dense_), dense_colour_[size_t(c)].data(), n,
                      span);
    }
    for (uint32_t z = 0; z < n && !deep_.empty(); ++z)
        if (children_[z] >= 0) multiply_split(kBaseLevel, z, base_leaf(z));
    // All levels up to the root, whose mass is L_ns.
    for (int l = dense_; l-- > 0;)
        kernels.sum_fours(mass_[size_t(l) + 1].data(), mass_[size_t(l)].data(), nodes_at(l));
    // For m = 4, the cells of maps are one level above the dense one.
    if (m_ == dense_) return;
    for (int c = 0; c < 3; ++c) {
        map_colour_[size_t(c)].resize(nodes_at(m_));
        kernels.sum_fours(dense_colour_[size_t(c)].data(), map_colour_[size_t(c)].data(), nodes_at(m_));
    }
}

void ProductTree::guide(std::span<const double> density) {
    for (int l = 0; l <= m_; ++l) guided_mass_[size_t(l)].resize(nodes_at(l));
    for (size_t z = 0; z < nodes_at(m_); ++z) guided_mass_[size_t(m_)][z] = mass_[size_t(m_)][z] * density[z];
    for (int l = m_; l-- > 0;)
        product_kernels().sum_fours(guided_mass_[size_t(l) + 1].data(), guided_mass_[size_t(l)].data(),
                                    nodes_at(l));
    guided_ = true;
}

ProductTree::Sample ProductTree::sample(Point2 u) const {
    // First through the stored levels, then through deeper leaves, then through the environment alone
    uint32_t z = 0;
    int level = 0;
    for (; level < dense_; ++level) z = 4 * z + pick(&density(level + 1)[4 * z], u);
    // The leaf of the base in which z lies, and from there down by two bits of z per level, which the dense
    // level has already decided.
    Leaf leaf = base_leaf(z >> (2 * (dense_ - kBaseLevel)));
    for (int l = kBaseLevel; l < dense_ && leaf.children >= 0; ++l)
        leaf = deep_[size_t(leaf.children) + (z >> (2 * (dense_ - l - 1)) & 3)];
    for (; leaf.children >= 0; ++level) {
        double m[4];
        for (uint32_t k = 0; k < 4; ++k) m[k] = mass(level + 1, 4 * z + k, deep_[size_t(leaf.children) + k]);
        const uint32_t k = pick(m, u);
        z = 4 * z + k;
        leaf = deep_[size_t(leaf.children) + k];
    }
    for (; level < light_->levels(); ++level) z = 4 * z + pick(&light_->sums(level + 1)[4 * z], u);
    // Nodes along an edge: 4^level / 2^level
    const double cells = double(nodes_at(level) >> level);
    // Uniform inside the texel: its radiance is constant.
    const Vec2 p{float((gather2(z) + u.x) / cells), float((gather2(z >> 1) + u.y) / cells)};
    return {z, equal_area_to_direction(p), leaf.b, leaf.colour};
}

std::vector<double> ProductTree::texel_masses() const {
    std::vector<double> out(nodes_at(light_->levels()));
    for (uint32_t z = 0; z < out.size(); ++z)
        out[z] = double(leaf_of(z).b) * light_->sums(light_->levels())[z];
    return out;
}

ProductTree::Leaf ProductTree::leaf_of(uint32_t texel) const {
    int level = kBaseLevel;
    // Two bits of the texel's code name the child at each level.
    const auto code = [&] { return texel >> (2 * (light_->levels() - level)); };
    Leaf leaf = base_leaf(code());
    while (leaf.children >= 0) {
        ++level;
        leaf = deep_[size_t(leaf.children) + (code() & 3)];
    }
    return leaf;
}

}  // namespace viscache
