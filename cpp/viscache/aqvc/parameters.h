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

/// Bins of normals: Eq. 4 rounded or, as in the paper, floored; on the octahedral map; one for all.
enum class NormalMode { kRound, kFloor, kOctahedral, kSingle };
enum class ResolutionRule { kEq7, kEq6 };           ///< cells of surface-surface connections
enum class EnvironmentRule { kDerived, kPrinted };  ///< Eq. 9
/// D_l that the light cells of an eye point's own samples follow: of light sampling alone, the same for all
/// eye points, or of all techniques together (Σ M_t p_t), which with the BRDF among them differs.
enum class CellDensity { kLight, kMixture };
enum class VplKey { kPoint, kSurface };
enum class Refinement { kAuto, kOn, kOff };
enum class LevelRule { kFinest, kLog2 };
enum class HashScheme { kScheme2, kScheme1, kScheme1Mixed };
enum class PixelOrder { kHaltonMorton, kScanline, kRandom };
enum class Form { kWaves, kRows, kPairs };  ///< how groups of shared lights are processed
/// Of `pairs`: the lossy table of Sec. 4.1, a map of full keys, (one table for a frame alone) the lossy table
/// that threads race for, or the lossy table of a thread, kept over the tiles of 32² pixels it works on.
enum class Storage { kTable, kExact, kShared, kPaperTiles };

struct AqvcParameters {
    double c_e = 12;                               ///< a cluster spans about C_E × C_E eye samples
    std::array<double, kLightGroups> c_e_group{};  ///< C_E of single light groups; <= 0: c_e
    double c_l = 1;                                ///< and about C_L × C_L light samples at the other end
    int c_n = 8;                                   ///< normal bins per axis
    double c_z = 4;                                ///< cells are this much thinner along the normal
    double c_r = 1.2;                              ///< ratio of the ladder of resolutions
    NormalMode normal_mode = NormalMode::kRound;
    bool grid_offset = true;  ///< shift the grids, so that no plane of a scene lies on a cell face
    bool scale_free = false;  ///< cells of C_R^k units, from the origin: they do not depend on the scene
    uint32_t grid_seed = 0;   ///< another shift, and another random order, per number
    bool tangent_neighbours = true;  ///< neighbour cells follow the tangent plane
    bool jitter = false;             ///< move points by up to half a cell along the surface before quantizing
    ResolutionRule res_rule = ResolutionRule::kEq7;
    EnvironmentRule env_rule = EnvironmentRule::kDerived;
    CellDensity cell_density = CellDensity::kMixture;
    VplKey vpl_key = VplKey::kPoint;
    Refinement refinement = Refinement::kAuto;
    std::array<std::optional<Refinement>, kLightGroups> refinement_group{};  ///< of single light groups
    double nil_refine = 0;  ///< share of cells that refine where two or more of four neighbours are unknown
    LevelRule level_rule = LevelRule::kFinest;  ///< kLog2: C_MSR = max(1, ceil(log2 C_E)) levels
    double level_step = 4;
    double c_finest = 4;
    int max_levels = 0;               ///< cuts the list of levels; 0: no limit
    bool by_contribution = false;     ///< C_E of each connection by what it carries (contribution_levels.h)
    double contribution_power = 2.5;  ///< p of C_E·(mean f / f)^(1/p)
    double contribution_lift = 2;     ///< the coarsest level is this many C_E
    int contribution_slack = 1;       ///< levels a connection may be refined past its own
    HashScheme hash = HashScheme::kScheme2;
    int digest_bits = 31;
    uint64_t table_bytes = uint64_t{4} << 20;
    PixelOrder order = PixelOrder::kHaltonMorton;
    double c_pg = 3.7;  ///< growth of the order's segments
    Form form = Form::kWaves;
    Storage storage = Storage::kTable;
    int batch = 0;  ///< eye points per batch; 0: 1024 for pairs, 256 for rows; 1: one query
    int queue =
        0;  ///< of `pairs`: length of the queue of postponed rays (Sec. 4.4), the paper's 64; 0: batches
    int c_w = 31;  ///< fewer missing rays than this among queue/2 queries are postponed

    double group_c_e(int group) const {
        const double own = c_e_group[size_t(group)];
        return own > 0 ? own : c_e;
    }
    /// Throws std::invalid_argument that says what must hold and what was given.
    void validate() const;
};

namespace detail {
template <class Value>
void require(bool holds, const char* what, Value given) {
    if (!holds) throw std::invalid_argument(std::string(what) + ", got " + std::to_string(given));
}
}  // namespace detail

inline void AqvcParameters::validate() const {
    using detail::require;
    const auto positive = [](double v) { return v > 0 && std::isfinite(v); };
    require(positive(c_e), "c_e must be > 0 and finite", c_e);
    for (double v : c_e_group) require(std::isfinite(v), "c_e_group must be finite", v);
    require(c_l >= 1e-3 && c_l <= 1e3, "c_l must be in [0.001, 1000]", c_l);
    require(c_n >= 1, "c_n must be >= 1", c_n);
    require(c_n <= 64, "c_n must be <= 64", c_n);
    require(c_z >= 0.01 && c_z <= 1024, "c_z must be in [0.01, 1024]", c_z);
    require(c_r >= 1.001 && c_r <= 16, "c_r must be in [1.001, 16]", c_r);
    require(level_step >= 1.1 && std::isfinite(level_step), "level_step must be >= 1.1 and finite",
            level_step);
    require(positive(c_finest), "c_finest must be > 0 and finite", c_finest);
    require(max_levels >= 0 && max_levels <= kMaxLevels, "max_levels must be in [0, 32]", max_levels);
    require(digest_bits >= 1 && digest_bits <= 31, "digest_bits must be in [1, 31]", digest_bits);
    require(table_bytes >= 4, "table_bytes must be >= 4", table_bytes);
    require(table_bytes <= uint64_t{1} << 33, "table_bytes must be <= 2^33", table_bytes);
    require(c_pg >= 1.1 && std::isfinite(c_pg), "c_pg must be >= 1.1 and finite", c_pg);
    require(contribution_power >= 0.1 && contribution_power <= 100,
            "contribution_power must be in [0.1, 100]", contribution_power);
    require(contribution_lift >= 1 && contribution_lift <= 1024, "contribution_lift must be in [1, 1024]",
            contribution_lift);
    require(contribution_slack >= 0 && contribution_slack <= kMaxLevels,
            "contribution_slack must be in [0, 32]", contribution_slack);
    require(nil_refine >= 0 && nil_refine <= 1, "nil_refine must be in [0, 1]", nil_refine);
    if (jitter && res_rule == ResolutionRule::kEq6)
        throw std::invalid_argument("jitter must be off with res_rule eq6 (the default of Bdpt), got true");
    require(batch >= 0, "batch must be >= 0", batch);
    require(queue >= 0 && queue <= 1024 && queue % 2 == 0, "queue must be even and in [0, 1024]", queue);
    require(c_w >= 1 && c_w <= 1024, "c_w must be in [1, 1024]", c_w);
}

/// True if Alg. 2 refines the connections of this light group at `spp` samples per pixel. Auto: lights shared
/// by all pixels, unless clusters are smaller than a pixel anyway (AQVC Sec. 3.6).
inline bool refines(const AqvcParameters& p, int group, int spp) {
    const Refinement chosen = p.refinement_group[size_t(group)].value_or(p.refinement);
    if (chosen != Refinement::kAuto) return chosen == Refinement::kOn;
    const auto g = LightGroup(group);
    const bool shared = g == LightGroup::kPoint || g == LightGroup::kDirectional || g == LightGroup::kVpl;
    const double c_e = p.group_c_e(group);
    return shared && c_e * c_e > spp;
}

/// C_E of every level, coarse to fine: c₀ = lift·C_E, then c / level_step down to c_finest.
// Differs: AQVC halves C_E down to 1–2 eye samples; the default stops at 4 in steps of 4, which costs 1.7
// times fewer rays for 15 % more error. LevelRule::kLog2 with level_step 2 is the paper's list.
inline std::vector<double> level_list(const AqvcParameters& p, int group, int spp, double lift = 1) {
    std::vector<double> levels = {lift * p.group_c_e(group)};
    if (!refines(p, group, spp)) return levels;
    const size_t limit = size_t(p.max_levels ? p.max_levels : kMaxLevels);
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
