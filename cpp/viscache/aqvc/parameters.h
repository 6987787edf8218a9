#pragma once
// Parameters of the quantized cache (Popov, Georgiev, Slusallek, Dachsbacher 2013, here "AQVC").
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "viscache/visibility/counters.h"

namespace viscache {

enum class NormalMode { kRound, kFloor, kOctahedral, kSingle };
enum class ResolutionRule { kEq7, kEq6 };
enum class EnvironmentRule { kDerived, kPrinted };
enum class CellDensity { kLight, kMixture };
enum class VplKey { kPoint, kSurface };
enum class Refinement { kAuto, kOn, kOff };
enum class LevelRule { kFinest, kLog2 };
enum class HashScheme { kScheme2, kScheme1, kScheme1Mixed };
enum class PixelOrder { kHaltonMorton, kScanline, kRandom };
enum class Form { kWaves, kPairs };
enum class Storage { kTable, kExact, kShared, kPaperTiles };

/// What each is, its range, and whether keys depend on it: parameter_table.h.
struct AqvcParameters {
    double c_e = 12;
    std::array<double, kLightGroups> c_e_groups{};  ///< <= 0: c_e
    double c_l = 1;
    int c_n = 8;
    double c_z = 4;
    double c_r = 1.2;
    bool scale_free = false;
    uint32_t grid_seed = 0;
    Refinement refinement = Refinement::kAuto;
    std::array<std::optional<Refinement>, kLightGroups> refinement_groups{};
    double level_step = 4;
    double c_finest = 4;
    bool by_contribution = false;
    uint64_t table_bytes = uint64_t{4} << 20;
    Form form = Form::kWaves;
    Storage storage = Storage::kTable;
    int batch = 0;
    int queue = 0;
    int c_w = 31;
    PixelOrder order = PixelOrder::kHaltonMorton;
    double c_pg = 3.7;
    HashScheme hash = HashScheme::kScheme2;
    int digest_bits = 31;
    NormalMode normal_mode = NormalMode::kRound;
    bool grid_offset = true;
    bool tangent_neighbours = true;
    ResolutionRule res_rule = ResolutionRule::kEq7;
    EnvironmentRule env_rule = EnvironmentRule::kDerived;
    CellDensity cell_density = CellDensity::kMixture;
    VplKey vpl_key = VplKey::kPoint;
    LevelRule level_rule = LevelRule::kFinest;

    double group_c_e(int group) const {
        const double own = c_e_groups[size_t(group)];
        return own > 0 ? own : c_e;
    }
    /// Throws std::invalid_argument that says what must hold and what was given.
    void validate() const;
};

namespace detail {
template <class Value>
void require(bool holds, const std::string& what, Value given) {
    if (!holds) throw std::invalid_argument(what + ", got " + std::to_string(given));
}
}  // namespace detail

/// True if Alg. 2 refines the connections of this light group at `spp` samples per pixel. Auto: lights shared
/// by all pixels, unless clusters are smaller than a pixel anyway (AQVC Sec. 3.6).
inline bool refines(const AqvcParameters& p, int group, int spp) {
    const Refinement chosen = p.refinement_groups[size_t(group)].value_or(p.refinement);
    if (chosen != Refinement::kAuto) return chosen == Refinement::kOn;
    const auto g = LightGroup(group);
    const bool shared = g == LightGroup::kPoint || g == LightGroup::kDirectional || g == LightGroup::kVpl;
    const double c_e = p.group_c_e(group);
    return shared && c_e * c_e > spp;
}

/// C_E of every level, coarse to fine: c₀ = lift·C_E, then c / level_step down to c_finest. At most kMaxLevels.
// Differs: AQVC halves C_E down to 1–2 eye samples; the default stops at 4 in steps of 4, which costs 1.7
// times fewer rays for 15 % more error. LevelRule::kLog2 with level_step 2 is the paper's list.
inline std::vector<double> level_list(const AqvcParameters& p, int group, int spp, double lift = 1) {
    std::vector<double> levels = {lift * p.group_c_e(group)};
    if (!refines(p, group, spp)) return levels;
    const size_t limit = size_t(kMaxLevels);
    if (p.level_rule == LevelRule::kLog2) {
        for (double power = 2; power < levels[0] && levels.size() < limit; power *= 2)
            levels.push_back(levels.back() / p.level_step);
    } else {
        while (levels.back() >= 2 * p.c_finest && levels.size() < limit)
            levels.push_back(std::max(p.c_finest, levels.back() / p.level_step));
    }
    return levels;
}

}  // namespace viscache
