#pragma once
// Contributions of shared lights to the eye points of a tile, for oracles and audits that ask for them.
#include <algorithm>
#include <vector>

#include "viscache/oracles/exact.h"
#include "viscache/render/eye_paths.h"
#include "viscache/render/glossy_sums.h"
#include "viscache/render/light_pick.h"
#include "viscache/render/mean_light.h"
#include "viscache/visibility/reference_light.h"

namespace viscache {

/// Unoccluded contributions of a group of shared lights to the eye points of a tile.
class TileContributions : public Contributions {
public:
    /// `wanted`: the columns that each eye point asks for.
    TileContributions(const SharedLights& lights, const EyeTile& eyes, const TilePicks& picks,
                      const BitMatrix& wanted)
        : lights_(lights), eyes_(eyes), picks_(picks), wanted_(wanted), light_(eyes.size(), -1.f) {}
    /// What the wanted columns would bring to the pixel of an eye point without shadows, as a mean of
    /// channels.
    float unoccluded(uint32_t eye) const {
        if (light_[eye] < 0) tell(eye);
        return light_[eye];
    }
    /// Adds this of all eye points to their pixels.
    void add_to(std::span<const uint32_t> pixel_of, std::span<float> pixels) const {
        for (size_t i = 0; i < eyes_.size(); ++i) pixels[pixel_of[i]] += unoccluded(uint32_t(i));
    }
    void at_most(uint32_t eye, std::span<const float> shares, std::span<Word* const> rows) const override {
        // Oracles ask by eye point, several times in a row: the row of the last one is kept
        tell(eye);
        bounds_.clear();
        // ∞·0 would be NaN for an eye point without light
        for (const float s : shares) bounds_.push_back(s < kInfinity ? s * mean_ : kInfinity);
        at_most_rows(told_, bounds_, rows);
    }
    /// Unknown for picked lights, whose weights their contributions do not have.
    float reference(uint32_t eye, const Word* seen) const override {
        const float factor = to_pixel(eyes_, eye);
        if (!(lights_.mean_light > 0 && factor > 0) || !picks_.of(eye).empty()) return 0;
        tell(eye);
        if (!(mean_ > 0)) return 0;
        // Light that the oracle thinks is seen, among all that was asked, in units of the pixel
        const float all = masked_sum(told_, wanted_.row(eye));
        const float light =
            reference_light(factor * masked_sum(told_, seen), factor * all, lights_.mean_light);
        // Back to the means of contributions in which shares are asked
        return light / (factor * mean_);
    }
    void values(uint32_t eye, std::span<Rgb> columns) const override {
        const ShadingPoint& sp = eyes_.shading[eye];
        if (is_black(sp)) return;
        const EyeShade shade{eyes_.block.position[eye], sp.ng, sp.ns};
        // Every connection that contributes, also those that this oracle was not asked for
        std::vector<Word> wanted(row_words_for(lights_.ends.count)), one(wanted.size());
        wanted_row(lights_, shade, lights_.ends.columns_of(eyes_.block, eye), wanted.data());
        for_each_bit(wanted, [&](size_t k) {
            if (k >= columns.size()) return;
            set_bit(one.data(), k);
            // By the functions that shade the frame, one column at a time: values and frame agree
            // to the last bit
            const Rgb value = sp.kind == MaterialKind::kGlossy
                                  ? sum_row_glossy(lights_, shade, sp, one.data())
                                  : sum_row(lights_, shade, one.data()) * (sp.base * (1 / kPi));
            columns[k] = eyes_.throughput[eye] * value;
            clear_bit(one.data(), k);
        });
        keep_picked(picks_.of(eye), columns);
    }

private:
    /// Weights what the eye point picked, and clears the rest.
    static void keep_picked(std::span<const PickedLight> picked, std::span<Rgb> columns) {
        if (picked.empty()) return;
        std::vector<Rgb> kept(columns.size());
        // Sums over picks estimate the sum over all lights, so each has its inverse probability
        for (const PickedLight& p : picked)
            if (p.column < columns.size()) kept[p.column] = columns[p.column] * p.weight;
        std::copy(kept.begin(), kept.end(), columns.begin());
    }

    static constexpr uint32_t kNone = ~uint32_t{0};
    /// Fills `told_` and `mean_`.
    void tell(uint32_t eye) const {
        if (eye == eye_) return;
        const ColumnRange all{0, words_for(lights_.ends.count) * kWordBits};
        mean_ = reflected_row(lights_, eyes_, eye, all, wanted_.row(eye), told_);
        eye_ = eye;
        const std::span<const PickedLight> picked = picks_.of(eye);
        float sum = 0;
        for (const PickedLight& p : picked) sum += p.weight * told_[p.column];
        // Without picks the sum is the mean times the number of what was asked: no second pass over
        // the row
        if (picked.empty()) sum = mean_ * float(count_bits(wanted_.row_span(eye)));
        light_[eye] = to_pixel(eyes_, eye) * sum;
    }

    const SharedLights& lights_;
    const EyeTile& eyes_;
    const TilePicks& picks_;
    const BitMatrix& wanted_;
    // The eye point that was asked for last. Mutable, because asking changes no answer
    mutable uint32_t eye_ = kNone;
    mutable std::vector<float> told_, bounds_;
    mutable float mean_ = 0;
    mutable std::vector<float> light_;  ///< unoccluded, of each eye point; -1: not asked for yet
};

}  // namespace viscache
