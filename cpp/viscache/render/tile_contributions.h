#pragma once
// Contributions of shared lights to the eye points of a tile, for oracles and audits that ask for them.
#include <algorithm>
#include <vector>

#include "viscache/render/eye_paths.h"
#include "viscache/render/glossy_sums.h"
#include "viscache/render/light_pick.h"

namespace viscache {

/// Unoccluded contributions of a group of shared lights to the eye points of a tile.
class TileContributions : public Contributions {
public:
    TileContributions(const SharedLights& lights, const EyeTile& eyes, const TilePicks& picks)
        : lights_(lights), eyes_(eyes), picks_(picks) {}
    void at_most(uint32_t eye, std::span<const float> shares, std::span<Word* const> rows) const override {
        const ShadingPoint& sp = eyes_.shading[eye];
        at_most_rows(lights_, {eyes_.block.position[eye], sp.ng, sp.ns}, shares, rows, scratch_);
    }
    void values(uint32_t eye, std::span<Rgb> columns) const override {
        const ShadingPoint& sp = eyes_.shading[eye];
        if (is_black(sp)) return;
        const EyeShade shade{eyes_.block.position[eye], sp.ng, sp.ns};
        std::vector<Word> wanted(row_words_for(lights_.ends.count)), one(wanted.size());
        wanted_row(lights_, shade, lights_.ends.columns_of(eyes_.block, eye), wanted.data());
        for_each_bit(wanted, [&](size_t k) {
            if (k >= columns.size()) return;
            set_bit(one.data(), k);
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
        for (const PickedLight& p : picked)
            if (p.column < columns.size()) kept[p.column] = columns[p.column] * p.weight;
        std::copy(kept.begin(), kept.end(), columns.begin());
    }

    const SharedLights& lights_;
    const EyeTile& eyes_;
    const TilePicks& picks_;
    mutable std::vector<float> scratch_;
};

}  // namespace viscache
