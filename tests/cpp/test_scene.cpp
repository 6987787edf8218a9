// scene/camera.h: the pinhole camera's frame.
#include "check.h"
#include "viscache/scene/camera.h"

namespace viscache::test {
namespace {

void cameras_have_orthonormal_frames() {
    const Vec3 origin{1, 2, 3};
    for (Vec3 target :
         {Vec3{4, 5, 6}, Vec3{1, 9, 3}, Vec3{1, -9, 3}, Vec3{1, 2, -4}}) {  // two look along `up`
        const Camera c = look_at(origin, target, {0, 1, 0}, 1.f);
        check_near(length(c.right), 1, 1e-6, "|right|");
        check_near(length(c.up), 1, 1e-6, "|up|");
        check_near(dot(c.right, c.up), 0, 1e-6, "right · up");
        check_near(dot(c.right, c.forward), 0, 1e-6, "right · forward");
        check_near(dot(c.forward, normalize(target - origin)), 1, 1e-6, "forward points at the target");
        check_near(dot(cross(c.right, c.up), c.forward), -1, 1e-6, "right × up points against forward");
    }
}

const Suite suite{
    {"camera: frames are orthonormal, also when looking along up", cameras_have_orthonormal_frames}};

}  // namespace
}  // namespace viscache::test
