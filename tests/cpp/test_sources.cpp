// Sources of oracles: preparation, tables and reports do not depend on the number of threads, and corrected
// answers are unbiased.
#include <cmath>
#include <cstring>
#include <random>

#include "check.h"
#include "small_scene.h"
#include "viscache/aqvc/aqvc_source.h"
#include "viscache/oracles/exact_source.h"
#include "viscache/oracles/residual_source.h"
#include "viscache/oracles/roulette_source.h"
#include "viscache/oracles/shadow_map_source.h"
#include "viscache/render/frame.h"
#include "viscache/render/taps.h"
#include "viscache/visibility/ask.h"

namespace viscache::test::sources_tests {
namespace {

struct Setup {
    std::shared_ptr<const Scene> world = lit_board();
    Control control;
    BspCaster caster{world, {}, 1, control};
    Camera camera = look_at({0, 2, 4}, {0, 0.3f, 0}, {0, 1, 0}, 0.9f);

    FrameResult render(OracleSource& source, int threads = 2) {
        IntegratorSettings integrator;
        integrator.n_area = 4;
        const FrameSettings frame{.width = 40, .height = 30, .threads = threads};
        return render_frame(*world, caster, camera, integrator, frame, source, control);
    }
    FrameResult exact() {
        ExactSource source(*world, caster);
        return render(source);
    }
};

bool same_pixels(const FrameResult& a, const FrameResult& b) {
    return std::memcmp(a.color.data(), b.color.data(), a.color.size() * sizeof(Rgb)) == 0;
}

double mean_of(const FrameResult& f) {
    double sum = 0;
    for (const Rgb& c : f.color) sum += double(c.x) + c.y + c.z;
    return sum / double(f.color.size());
}

uint64_t reported(const FrameResult& f, const std::string& name) {
    for (const auto& [key, value] : f.source.counters)
        if (key == name) return value;
    fail("the report lacks " + name);
    return 0;
}

void shadow_maps_are_traced_once_for_all_threads() {
    Setup setup;
    const ShadowMapSettings settings{.resolution = 64};
    ShadowMapSource one(*setup.world, setup.caster, settings), four(*setup.world, setup.caster, settings);
    const FrameResult a = setup.render(one, 1), b = setup.render(four, 4);
    check(same_pixels(a, b), "same pixels");
    check_equal(reported(a, "shadow_maps"), uint64_t{3}, "maps of two lamps and a sun");
    check_equal(reported(a, "shadow_map_rays"), uint64_t{(2 * 6 + 1) * 64 * 64}, "texels");
    check_equal(a.counters.groups[size_t(LightGroup::kPoint)].rays, uint64_t{2 * 6 * 64 * 64}, "lamps' rays");
}

void roulette_learns_before_the_frame() {
    Setup setup;
    const NeePlusPlusSettings settings{.n_voxels = 4, .learn_pixels = 300};
    RouletteSource one(*setup.world, setup.caster, settings, {.seed = 7}),
        four(*setup.world, setup.caster, settings, {.seed = 7});
    const FrameResult a = setup.render(one, 1), b = setup.render(four, 4);
    check(same_pixels(a, b), "same pixels");
    const uint64_t learned = reported(a, "learning_rays");
    check(learned > 0, "rays were traced to learn");
    check_equal(a.counters.rays() - learned + reported(a, "discarded"), a.counters.queries(),
                "each query is traced or discarded");
}

void means_of_voxels_are_exact_with_a_share_of_one() {
    Setup setup;
    const NeePlusPlusSettings settings{.n_voxels = 4, .learn_pixels = 300};
    const auto source = [&](double share) {
        RouletteOptions options;
        options.correct = MeanSettings{.share = share, .seed = 3};
        return RouletteSource(*setup.world, setup.caster, settings, options);
    };
    RouletteSource all = source(1.0), one = source(0.2), four = source(0.2);
    const FrameResult exact = setup.exact(), right = setup.render(all);
    check(same_pixels(exact, right), "all queries traced");
    check_equal(reported(right, "corrections"), right.counters.queries(), "corrections");
    const FrameResult a = setup.render(one, 1), b = setup.render(four, 4);
    check(same_pixels(a, b), "same pixels");
    check(!same_pixels(a, exact), "a share of the queries is traced");
    check(reported(a, "discarded") > 0, "the others are not");
}

void kept_voxels_take_back_what_a_lost_frame_added() {
    Setup setup;
    const NeePlusPlusSettings settings{.n_voxels = 4, .learn_pixels = 300, .relearn_pixels = 100};
    KeptVoxels kept;
    const auto frame = [&] {
        RouletteSource source(*setup.world, setup.caster, settings, {.seed = 7, .keep = &kept});
        return setup.render(source, 3);
    };
    const auto tested = [&] {
        uint64_t sum = 0;
        for (size_t i = 0; kept.map() && i < kept.map()->size(); ++i) sum += kept.map()->at(i).tested;
        return sum;
    };
    frame();
    kept.roll_back();
    check_equal(tested(), uint64_t{0}, "counts without a finished frame");
    const uint64_t first = reported(frame(), "learning_rays");
    kept.commit();
    const uint64_t before = tested();
    check_equal(before, first, "counts of the first frame");
    const uint64_t later = reported(frame(), "learning_rays");
    check(later > 0 && later < first, "a later frame learns less");
    check_equal(tested(), before + later, "counts of two frames");
    kept.roll_back();
    check_equal(tested(), before, "counts after a lost frame");
    check_equal(kept.frames(), uint64_t{1}, "finished frames");
}

void a_kept_table_passes_bits_to_the_next_frame() {
    Setup setup;
    AqvcParameters p;
    p.exact_groups = LightGroupSet{};
    p.c_e = 6;
    p.form = Form::kPairs;
    p.scale_free = true;
    KeptTable table(1 << 16, p.digest_bits, p.hash);
    uint64_t rays[2];
    for (uint64_t& r : rays) {
        KeptTableSource source(*setup.world, setup.caster, p, 1, table, {});
        r = setup.render(source, 3).counters.rays();
    }
    check(rays[1] < rays[0], "the second frame needs fewer rays");
    check_equal(table.frames(), uint64_t{2}, "frames");
}

void a_share_of_one_is_exact() {
    Setup setup;
    AqvcParameters p;
    p.exact_groups = LightGroupSet{};
    p.c_e = 40;
    AqvcSource inner(*setup.world, setup.caster, p, 1), alone(*setup.world, setup.caster, p, 1);
    ResidualSource source(*setup.world, setup.caster, inner, {.share = 1, .seed = 3});
    const FrameResult exact = setup.exact(), wrong = setup.render(alone), right = setup.render(source);
    check(!same_pixels(exact, wrong), "the cache has errors at this C_E");
    check(same_pixels(exact, right), "all queries corrected");
    check_equal(reported(right, "corrections"), right.counters.queries(), "corrections");
    check(reported(right, "wrong") > 0, "some answers were wrong");
}

/// Mean brightness over seeds, with its standard error.
std::pair<double, double> corrected_mean(Setup& setup, bool weighted) {
    AqvcParameters p;
    p.exact_groups = LightGroupSet{};
    p.c_e = 60;
    p.refinement.fill(Refinement::kOff);
    double sum = 0, squares = 0;
    constexpr int kSeeds = 40;
    for (int seed = 0; seed < kSeeds; ++seed) {
        AqvcSource inner(*setup.world, setup.caster, p, 1);
        ResidualSource source(*setup.world, setup.caster, inner,
                              {.share = 0.2, .seed = uint64_t(seed), .weighted = weighted});
        const double mean = mean_of(setup.render(source));
        sum += mean;
        squares += mean * mean;
    }
    const double mean = sum / kSeeds;
    return {mean, std::sqrt((squares / kSeeds - mean * mean) / (kSeeds - 1))};
}

void corrected_frames_are_right_in_expectation() {
    Setup setup;
    const double exact = mean_of(setup.exact());
    const auto [mean, error] = corrected_mean(setup, true);
    check(error < 0.01 * exact, "an error of one percent is detectable");
    check_near(mean, exact, 3.5 * error, "mean of corrected frames");
    const auto [wrong, wrong_error] = corrected_mean(setup, false);
    check(std::fabs(wrong - exact) > 5 * wrong_error, "the bias without weights is detected");
}

EyeBlock random_eyes(const Setup& setup, size_t n) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> u(-1.8f, 1.8f);
    EyeBlock eyes;
    for (size_t i = 0; i < n; ++i) {
        const Vec3 p{u(random), 0, u(random)};
        eyes.position.push_back(p);
        eyes.normal.push_back({0, 1, 0});
        eyes.origin.push_back(spawn(p, {0, 1, 0}, setup.world->offset_extent()));
        eyes.density.push_back(100);
    }
    return eyes;
}

SharedLights lamps() {
    SharedLights lights;
    for (int k = 0; k < 70; ++k) {
        const Vec3 p{0.05f * float(k) - 1.7f, 1.f + 0.01f * float(k % 7), 0.3f};
        lights.add(p, {}, p, {1, 1, 1}, 0);
    }
    lights.ends.semantic = Semantic::kPoint;
    lights.pad();
    return lights;
}

void queries_by_arrays_equal_rays() {
    Setup setup;
    const EyeBlock eyes = random_eyes(setup, 3000);
    const SharedLights lights = lamps();
    const auto ask = [&](OracleSource& source, size_t most, int threads, bool log = false) {
        const EyeTiles tiles = EyeTiles::along_curve(eyes, most);
        return ask_block(source, tiles, {.lights = &lights.ends, .log_end = log ? lights.ends.count : 0},
                         threads, setup.control);
    };
    AqvcParameters p;
    p.exact_groups = LightGroupSet{};
    p.c_e = 1e-3;
    ExactSource first(*setup.world, setup.caster), second(*setup.world, setup.caster);
    AqvcSource tiny(*setup.world, setup.caster, p, 1);
    const BlockAnswer exact = ask(first, 1 << 14, 1);
    check(exact.bits == ask(second, 500, 4).bits, "same bits for any tiles and threads");
    check(exact.bits == ask(tiny, 700, 3).bits, "vanishing cells");
    check_equal(exact.counters.rays(), uint64_t{3000 * 70}, "rays");
    p.c_e = 8;
    AqvcSource one(*setup.world, setup.caster, p, 1), four(*setup.world, setup.caster, p, 1);
    const BlockAnswer a = ask(one, 1000, 1, true), b = ask(four, 1000, 4, true);
    check(a.bits == b.bits, "same bits on any threads");
    check_equal(a.log.size(), size_t{3000 * 70}, "every query is logged once");
    uint64_t traced = 0;
    for (const AskedQuery& q : a.log) {
        traced += q.traced;
        const size_t word = q.row * a.words + q.column / 64;
        const size_t source = q.representative * a.words + q.column / 64;
        const bool own = a.bits[word] >> (q.column % 64) & 1,
                   other = exact.bits[source] >> (q.column % 64) & 1;
        if (own != other) return fail("a query has the answer of its representative");
    }
    check(traced > 0 && traced <= a.counters.rays(), "rays that answered their own query");
}

void given_answers_make_the_same_frame() {
    Setup setup;
    TapSource taps;
    setup.render(taps, 3);
    GivenAnswers given;
    std::vector<std::vector<Word>> kept;
    EyeTiles tiles;
    for (const TileTap& tile : taps.tiles()) {
        given.first_row.push_back(tiles.size);
        tiles.eyes.push_back(tile.eyes);
        auto& row = tiles.row.emplace_back(tile.eyes.size());
        for (uint32_t& number : row) number = uint32_t(tiles.size++);
    }
    kept.reserve(taps.lights().size());
    for (const FarEnds& ends : taps.lights()) {
        ExactSource source(*setup.world, setup.caster);
        BlockAnswer answer = ask_block(source, tiles, {.lights = &ends}, 2, setup.control);
        kept.push_back(std::move(answer.bits));
        given.blocks[ends.group] = {answer.words, kept.back().data(), nullptr, ends.count};
    }
    GivenSource source(given);
    const FrameResult a = setup.exact(), b = setup.render(source, 2);
    for (const LightGroup g : {LightGroup::kPoint, LightGroup::kDirectional}) {
        const auto &x = a.groups[size_t(g)], &y = b.groups[size_t(g)];
        check(std::memcmp(x.data(), y.data(), x.size() * sizeof(Rgb)) == 0, "same pixels of a group");
    }
}

const Suite suite{
    {"shadow maps are traced once for all threads", shadow_maps_are_traced_once_for_all_threads},
    {"roulette learns before the frame", roulette_learns_before_the_frame},
    {"means of voxels are exact with a share of one", means_of_voxels_are_exact_with_a_share_of_one},
    {"kept voxels take back what a lost frame added", kept_voxels_take_back_what_a_lost_frame_added},
    {"a kept table passes bits to the next frame", a_kept_table_passes_bits_to_the_next_frame},
    {"a share of one is exact", a_share_of_one_is_exact},
    {"corrected frames are right in expectation", corrected_frames_are_right_in_expectation},
    {"queries by arrays equal rays", queries_by_arrays_equal_rays},
    {"given answers make the same frame", given_answers_make_the_same_frame},
};

}  // namespace
}  // namespace viscache::test::sources_tests
