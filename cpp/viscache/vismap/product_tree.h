#pragma once
// Product importance sampling after Clarberg and Akenine-Möller, "Practical Product Importance Sampling for
// Direct Illumination" (2008). A quadtree of B̃ is built for a point and multiplied by the sums of the
// environment. Points of the square are warped through it and stay stratified.
#include <array>
#include <vector>

#include "viscache/sampling/zero_two.h"
#include "viscache/vismap/environment_pyramid.h"
#include "viscache/vismap/node_directions.h"
#include "viscache/vismap/reflection.h"

namespace viscache {

/// L·B̃ over the sphere for one point. B̃ is constant in each leaf. Wherever B may be positive, B̃ is at
/// least `kFloor` times its maximum, so that every contributing direction can be sampled.
///
/// The nodes of levels up to `dense_level()` are always stored. Below them, leaves end at kDeepestLevel and
/// the warp follows the environment alone. The density and the control variate use the same numbers.
class ProductTree {
public:
    static constexpr float kFloor = 1e-3f;  ///< ε_B
    static constexpr int kMostSplits = 64;  ///< maximum number of split leaves, at the base level and below
    static constexpr double kMinSplitError =
        1.0 / 1024;  ///< minimum error of a leaf that is split, as a fraction of L_ns

    /// A direction sampled from the tree.
    struct Sample {
        uint32_t texel;  ///< Morton code among the pyramid's texels
        Vec3 wi;
        float b;     ///< luminance of B̃ there; the density per texel is λ·b·D/L_ns
        Rgb colour;  ///< B̃
    };

    /// Builds the tree. Maps of visibility have 2^m × 2^m cells, 4 <= m <= 7. `light` must outlive the tree.
    void build(const EnvironmentPyramid& light, const Reflection& reflection, int m);
    /// L_ns = ∫ L·B̃ of luminances; 0: nothing to sample.
    double total() const { return mass_[0][0]; }
    int map_level() const { return m_; }
    int dense_level() const { return dense_; }
    /// ∫ λ·b over the nodes of a level up to `dense_level`.
    std::span<const double> masses(int level) const { return mass_[size_t(level)]; }
    /// ∫ λ·b·D over the nodes of a level up to `map_level`: the masses used for sampling.
    std::span<const double> density_masses(int level) const {
        return (guided_ ? guided_mass_ : mass_)[size_t(level)];
    }
    /// ∫ L·B̃ of one channel over the cells of maps.
    std::span<const double> cell_colours(int channel) const {
        return (m_ == dense_ ? dense_colour_ : map_colour_)[size_t(channel)];
    }
    int leaves() const { return leaves_; }

    /// Multiplies the density by D >= 0, constant in each cell of the maps, until the next `build`.
    void guide(std::span<const double> density);
    void unguide() { guided_ = false; }
    bool guided() const { return guided_; }
    /// Maps a point of the square to a direction; total() must be > 0.
    Sample sample(Point2 u) const;
    /// λ·b of every texel, along the Morton curve; slow.
    std::vector<double> texel_masses() const;
    /// B̃ of a texel.
    Rgb colour(uint32_t texel) const { return leaf_of(texel).colour; }
    float b(uint32_t texel) const { return leaf_of(texel).b; }

private:
    struct Leaf {
        Rgb colour;
        float b = 0;
        float spread = 0;       ///< maximum minus minimum of the leaf's samples
        int32_t children = -1;  ///< index of the first of four children in `deep_`; -1: none
    };
    struct Candidate {
        double error;
        int32_t level;
        uint32_t code;
        int32_t index;  ///< index in `deep_`; -1: a leaf of the base level
    };
    void sample_base(const Reflection& reflection);
    void refine(const Reflection& reflection);
    void split(const Reflection& reflection, const Candidate& c);
    void raise_to_floor(const Reflection& reflection);
    void raise_children(const Reflection& reflection, int level, uint32_t code, int32_t first, float floor);
    void multiply();
    void multiply_split(int level, uint32_t code, const Leaf& leaf);
    double mass(int level, uint32_t code, const Leaf& leaf) const;
    double colour_mass(int channel, int level, uint32_t code, const Leaf& leaf) const;
    Leaf base_leaf(uint32_t code) const;
    Leaf leaf_of(uint32_t texel) const;
    const double* density(int level) const {
        return (guided_ && level <= m_ ? guided_mass_ : mass_)[size_t(level)].data();
    }

    const EnvironmentPyramid* light_ = nullptr;
    int m_ = 5, dense_ = 5, leaves_ = 0;
    bool guided_ = false;
    float greatest_ = 0;
    // Buffers keep their size from point to point: building allocates only at first.
    std::vector<uint8_t> touched_;
    // Leaves of the base level as arrays, and deeper leaves in groups of four
    std::vector<float> b_, red_, green_, blue_, spread_;
    std::vector<int32_t> children_;
    std::vector<Leaf> deep_;
    std::vector<Candidate> heap_;
    std::array<std::vector<double>, kDeepestLevel + 1> mass_, guided_mass_;
    std::array<std::vector<double>, 3> dense_colour_, map_colour_;
};

}  // namespace viscache
