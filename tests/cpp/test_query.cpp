// visibility/query.h: offsets against self-intersection.
#include <cmath>

#include "check.h"
#include "viscache/visibility/query.h"

namespace viscache::test::query_tests {
namespace {

void spawned_points_leave_the_surface() {
    for (float size : {1e-6f, 1.f, 1e6f})
        for (Vec3 n : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{0.6f, 0, 0.8f}}) {
            const Vec3 p{size, -size, 0.5f * size};
            const Vec3 q = spawn(p, n, size);
            check(dot(q - p, n) > 0,
                  "a spawned point lies on the side of the normal, also far from the origin");
            check(length(q - p) < 1e-4f * size, "a spawned point stays near the surface");
        }
}

void offsets_scale_with_the_scene() {
    const Vec3 p{0.25f, -0.5f, 0.75f};
    // A power of two changes no mantissa, so the offset scales exactly.
    check_equal(spawn_offset(p * 1024.f, 2048.f), 1024.f * spawn_offset(p, 2.f), "offset of a scaled scene");
    check(spawn_offset({0, 0, 0}, 1.f) > 0, "a point at the origin is offset by the scene's extent");
}

void segments_stop_short_of_their_end() {
    const Vec3 origin{0, 0, 0}, light{3, 4, 0};
    const Ray ray = segment_to_point(origin, light, 1.f);
    check(ray.t_min == 0 && ray.t_max < 1 && ray.t_max > 0.999f, "a segment ends just before its light");
    check(segment_to_point(light, light, 1.f).t_max == 0, "a segment without length is empty");
    const float inside = segment_to_point(origin, {1e-9f, 0, 0}, 1.f).t_max;
    check_equal(inside, 0.f, "a light nearer than the offset leaves no segment");
}

void relative_epsilon_grows_with_distance_from_the_origin() {
    check(segment_epsilon({1e5f, 0, 0}, {1e5f + 1, 0, 0}) > 1e4f * segment_epsilon({0, 0, 0}, {1, 0, 0}),
          "the relative epsilon of a unit segment grows with its coordinates");
    check(std::isinf(segment_epsilon({1, 2, 3}, {1, 2, 3})), "coincident points have no segment");
}

const Suite suite{
    {"query: spawned points leave the surface", spawned_points_leave_the_surface},
    {"query: offsets scale with the scene", offsets_scale_with_the_scene},
    {"query: segments stop short of their end", segments_stop_short_of_their_end},
    {"query: the relative epsilon grows with the coordinates",
     relative_epsilon_grows_with_distance_from_the_origin},
};

}  // namespace
}  // namespace viscache::test::query_tests
