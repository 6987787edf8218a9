// What oracles say: one answer to samples and to the queries that they stand for, and answers with
// corrections.
#include <random>

#include "check.h"
#include "small_scene.h"
#include "viscache/aqvc/aqvc_source.h"
#include "viscache/oracles/exact_source.h"
#include "viscache/oracles/residual_source.h"
#include "viscache/oracles/roulette_oracle.h"
#include "viscache/oracles/unoccluded_source.h"
#include "viscache/visibility/local_samples.h"

namespace viscache::test::answers_tests {
namespace {

constexpr size_t kEyes = 60, kSamplesPerEye = 7;

/// Eye points on the floor, each with samples of the area above the board.
struct Example {
    std::shared_ptr<const Scene> world = lit_board();
    Control control;
    BspCaster caster{world, {}, 1, control};
    float extent = world->offset_extent();
    EyeBlock eyes;
    LocalSamples samples;
    FarEnds lights;
    BitMatrix all{kEyes, kSamplesPerEye};

    Example() {
        std::mt19937 random(3);
        std::uniform_real_distribution<float> u(-1.5f, 1.5f);
        samples.semantic = Semantic::kSurface;
        samples.group = int(LightGroup::kArea);
        for (uint32_t i = 0; i < kEyes; ++i) {
            const Vec3 p{u(random), 0, u(random)}, up{0, 1, 0};
            eyes.position.push_back(p);
            eyes.normal.push_back(up);
            eyes.origin.push_back(spawn(p, up, extent));
            eyes.density.push_back(100);
            for (size_t k = 0; k < kSamplesPerEye; ++k) {
                const Vec3 y{u(random), 1.5f, u(random)};
                samples.add(y, 50, 50);
                samples.normal.push_back({0, -1, 0});
                samples.ray_end.push_back(spawn(y, {0, -1, 0}, extent));
                all.set(i, k);
            }
            samples.close(i);
        }
        lights.count = kSamplesPerEye;
        for (auto* v : {&lights.x, &lights.y, &lights.z, &lights.nx, &lights.ny, &lights.nz, &lights.density})
            v->resize(512);
        for (size_t k = 0; k < lights.count; ++k) {
            lights.x[k] = 0.4f * float(k) - 1.2f;
            lights.y[k] = 1;
        }
        lights.tx = lights.x;
        lights.ty = lights.y;
        lights.tz = lights.z;
    }
    std::unique_ptr<VisibilityOracle> exact() { return std::make_unique<ExactOracle>(caster); }
};

std::vector<Word> copy_of(std::span<const Word> bits) { return {bits.begin(), bits.end()}; }

void samples_are_answered_like_their_queries() {
    Example e;
    VoxelVisibility voxels(e.world->bounds(), NeePlusPlusSettings{.n_voxels = 3});
    for (uint32_t pair = 0; pair < 20; ++pair) voxels.add(pair % 3, pair, pair % 4 == 0);
    AqvcParameters p;
    p.exact_groups = LightGroupSet{};
    p.form = Form::kPairs;
    p.c_e = 3;
    AqvcSource cache(*e.world, e.caster, p, 1);
    const std::pair<const char*, std::function<std::unique_ptr<VisibilityOracle>()>> every[] = {
        {"rays", [&] { return e.exact(); }},
        {"no shadows", [&] { return std::make_unique<UnoccludedOracle>(); }},
        {"roulette", [&] { return std::make_unique<RouletteOracle>(voxels, e.caster, 5); }},
        {"learning", [&] { return std::make_unique<LearningOracle>(voxels, e.caster); }},
        {"the cache", [&] { return cache.make(); }},
        {"corrections", [&] {
             return std::make_unique<ResidualOracle>(cache.make(), e.caster, ResidualSettings{.share = 0.3});
         }}};
    for (const auto& [name, make] : every) {
        std::vector<ShadowQuery> made;
        Counters of_samples, of_queries;
        const auto one = make(), other = make();
        one->begin_tile(e.eyes);
        other->begin_tile(e.eyes);
        const PairsAsk ask{.eyes = e.eyes, .samples = &e.samples};
        const Answer a = one->pairs(ask, of_samples);
        const Answer b = other->pairs({e.eyes, ask.as_queries(made)}, of_queries);
        check_equal(a.bits->columns(), kEyes * kSamplesPerEye, std::string("pairs, ") + name);
        check(copy_of(a.row(0)) == copy_of(b.row(0)), std::string("equal bits, ") + name);
        check(std::ranges::equal(a.weights, b.weights), std::string("equal weights, ") + name);
        check_equal(of_samples.rays(), of_queries.rays(), std::string("rays, ") + name);
        check_equal(of_samples.queries(), of_queries.queries(), std::string("queries, ") + name);
    }
}

void corrections_of_all_answers_give_those_of_rays() {
    Example e;
    const auto exact = e.exact();
    ResidualOracle corrected(std::make_unique<UnoccludedOracle>(), e.caster, {.share = 1});
    ResidualOracle needless(e.exact(), e.caster, {.share = 1});
    Counters counters, none;
    for (VisibilityOracle* oracle :
         std::initializer_list<VisibilityOracle*>{exact.get(), &corrected, &needless})
        oracle->begin_tile(e.eyes);
    const BlockAsk ask{e.eyes, e.lights, e.all};
    const Answer rays = exact->block(ask, none), right = corrected.block(ask, counters);
    size_t blocked = 0;
    for (size_t i = 0; i < kEyes; ++i) {
        check(copy_of(rays.row(i)) == copy_of(right.row(i)), "bits of rays");
        check(right.weights_of(i).empty() && right.corrections_of(i).empty(), "bits are changed in place");
        blocked += kSamplesPerEye - count_bits(right.row(i));
    }
    check(blocked > 20, "some lights are hidden");
    check_equal(counters.wrong, uint64_t(blocked), "wrong answers");
    check(rays.is_exact(e.lights.group) && !right.is_exact(e.lights.group), "only rays are exact");
    Counters spared;
    check(needless.block(ask, spared).is_exact(e.lights.group), "exact answers stay exact");
    check_equal(spared.corrections, uint64_t{0}, "and are not corrected");
}

void corrected_weights_join_bits_weights_and_corrections() {
    BitMatrix bits(2, 4);
    bits.set(1, 0);
    bits.set(1, 1);
    const float weights[] = {2, 3, 4, 5};
    const uint32_t row_of[] = {0, 0}, begin[] = {0, 0, 3};
    const Correction changes[] = {{1, -3, 0.5f}, {2, 1.5f, 0.5f}, {3, 0, 0.5f}};
    const Answer answer{.bits = &bits,
                        .weights = weights,
                        .weight_row = row_of,
                        .corrections = changes,
                        .correction_begin = begin};
    std::vector<float> scratch;
    check(std::ranges::equal(answer.corrected_weights(0, scratch), weights), "a row without corrections");
    const float expected[] = {2, 0, 1.5f, 0};
    check(std::ranges::equal(answer.corrected_weights(1, scratch), expected), "a row with corrections");
    check_equal(bits.row(1)[0], Word{0b0101}, "bits follow the weights");
}

const Suite suite{
    {"answers: samples are answered like their queries", samples_are_answered_like_their_queries},
    {"answers: corrections of all answers give those of rays", corrections_of_all_answers_give_those_of_rays},
    {"answers: corrected weights join bits, weights and corrections",
     corrected_weights_join_bits_weights_and_corrections},
};

}  // namespace
}  // namespace viscache::test::answers_tests
