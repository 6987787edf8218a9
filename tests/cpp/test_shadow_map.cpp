// Shadow maps: look-ups stay inside their maps for any receiver, and the texels are the same for any number
// of threads.
#include <cmath>
#include <random>
#include <stdexcept>

#include "check.h"
#include "viscache/oracles/shadow_map.h"

namespace viscache::test::shadow_map_tests {
namespace {

/// The plane y = 0.
class Floor final : public RayCaster {
public:
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override {
        for (size_t i = 0; i < rays.size(); ++i) {
            const float t = -rays[i].o.y / rays[i].d.y;
            hits[i] = t > rays[i].t_min && t < rays[i].t_max ? Hit{.t = t, .mesh = 0, .triangle = 0} : Hit{};
        }
    }
    void occluded(std::span<const Ray>, std::span<uint8_t>) const override {
        throw std::logic_error("not asked");
    }
    uint16_t occluded16(uint16_t, RayPacket16&, Coherence) const override {
        throw std::logic_error("not asked");
    }
};

FarEnds lights_at(Semantic semantic, std::vector<Vec3> places) {
    FarEnds l;
    l.semantic = semantic;
    l.count = places.size();
    l.group = int(semantic == Semantic::kPoint ? LightGroup::kPoint : LightGroup::kDirectional);
    for (const Vec3 p : places) {
        l.x.push_back(p.x);
        l.y.push_back(p.y);
        l.z.push_back(p.z);
        l.tx.push_back(p.x);
        l.ty.push_back(p.y);
        l.tz.push_back(p.z);
    }
    return l;
}

const FarEnds kLamps = lights_at(Semantic::kPoint, {{0, 1, 0}, {0.3f, 0.5f, -0.2f}});
const FarEnds kSuns = lights_at(Semantic::kDirection, {{0, 1, 0}, {0.6f, 0.8f, 0}});

ShadowMaps maps_of_floor(int resolution, int threads) {
    const FarEnds* both[] = {&kLamps, &kSuns};
    Control control;
    return ShadowMaps(Floor(), {{}, 1}, {.resolution = resolution}, both, threads, control);
}

void any_receiver_gets_an_answer() {
    std::mt19937 random(3);
    const auto odd = [&] {
        const float special[] = {0.f, -0.f, 1.f, -1.f, NAN, INFINITY, -INFINITY, 1e-40f, 1e16f, -1e30f};
        if (random() % 3 == 0) return special[random() % 10];
        return std::uniform_real_distribution<float>(-2, 2)(random);
    };
    for (const int resolution : {1, 2, 3, 17, 64}) {
        const ShadowMaps maps = maps_of_floor(resolution, 1);
        uint32_t seen = 0;
        for (int repeat = 0; repeat < 500; ++repeat) {
            Receivers16 r;
            for (int i = 0; i < 16; ++i) {
                r.x[i] = odd();
                r.y[i] = odd();
                r.z[i] = odd();
                r.nx[i] = odd();
                r.ny[i] = odd();
                r.nz[i] = odd();
            }
            for (const FarEnds* lights : {&kLamps, &kSuns})
                for (size_t k = 0; k < lights->count; ++k) seen |= maps.lit16(*lights, k, r);
        }
        check_equal(seen, 0xffffu, "every lane is lit sometimes");
    }
}

void points_above_the_floor_are_lit_and_points_below_are_not() {
    const ShadowMaps maps = maps_of_floor(64, 2);
    Receivers16 r{};
    for (int i = 0; i < 16; ++i) {
        r.x[i] = 0.05f * float(i) - 0.4f;
        r.z[i] = 0.1f;
        r.ny[i] = 1;
        r.y[i] = i % 2 ? 0.f : -0.3f;
    }
    for (const FarEnds* lights : {&kLamps, &kSuns})
        for (size_t k = 0; k < lights->count; ++k)
            check_equal(maps.lit16(*lights, k, r), uint16_t(0xaaaa), "odd lanes lie on the floor");
}

void threads_trace_the_same_texels() {
    const ShadowMaps one = maps_of_floor(37, 1), many = maps_of_floor(37, 8);
    check_equal(one.rays(), uint64_t(2 * 6 + 2) * 37 * 37, "texels");
    for (const FarEnds* lights : {&kLamps, &kSuns})
        for (size_t k = 0; k < lights->count; ++k) {
            const auto a = one.depths(*lights, k), b = many.depths(*lights, k);
            check(std::equal(a.begin(), a.end(), b.begin(), b.end()), "depths of one and of 8 threads");
        }
}

void maps_that_do_not_fit_are_refused() {
    const FarEnds* both[] = {&kLamps, &kSuns};
    Control control;
    check_throws<std::invalid_argument>(
        [&] { ShadowMaps(Floor(), {{}, 1}, {.resolution = 9, .max_bytes = 4000}, both, 1, control); },
        "4 · 14 · 81 bytes");
    control.cancel = true;
    check_throws<Cancelled>([&] { ShadowMaps(Floor(), {{}, 1}, {.resolution = 9}, both, 2, control); },
                            "cancelled");
}

const Suite suite{
    {"any receiver gets an answer", any_receiver_gets_an_answer},
    {"points above the floor are lit", points_above_the_floor_are_lit_and_points_below_are_not},
    {"threads trace the same texels", threads_trace_the_same_texels},
    {"maps that do not fit are refused", maps_that_do_not_fit_are_refused},
};

}  // namespace
}  // namespace viscache::test::shadow_map_tests
