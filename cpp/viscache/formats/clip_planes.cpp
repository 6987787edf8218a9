#include "viscache/formats/clip_planes.h"

#include <array>

#include "viscache/scene/film_camera.h"

namespace viscache {

namespace {

/// The half space dot(normal, p) + offset >= 0.
struct HalfSpace {
    Vec3 normal;
    float offset = 0;
    float at(Vec3 p) const { return dot(normal, p) + offset; }
};

/// A polygon of at most 8 corners: a triangle that is cut by 5 planes.
struct Polygon {
    std::array<Vec3, 8> corners;
    size_t count = 0;
    void add(Vec3 p) { corners[count++] = p; }
};

Polygon clipped(const Polygon& polygon, const HalfSpace& side) {
    Polygon kept;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Vec3 a = polygon.corners[i], b = polygon.corners[(i + 1) % polygon.count];
        const float from = side.at(a), to = side.at(b);
        if (from >= 0) kept.add(a);
        if ((from >= 0) != (to >= 0)) kept.add(a + (b - a) * (from / (from - to)));
    }
    return kept;
}

/// What the picture shows, in coordinates along right, up and forward from the camera's origin.
class View {
public:
    View(const Camera& camera, const ClipPlanes& planes) : camera_(camera), planes_(planes) {
        const FilmCamera film(camera, camera.width, camera.height);
        const float x = 2 * camera.shift_x, y = 2 * camera.shift_y;
        const bool flat = camera.is_orthographic();
        const auto side = [&](Vec3 inwards, float reach) {
            return HalfSpace{inwards + Vec3{0, 0, flat ? 0 : reach}, flat ? reach : 0};
        };
        sides_ = {side({1, 0, 0}, (1 - x) * film.half_width), side({-1, 0, 0}, (1 + x) * film.half_width),
                  side({0, 1, 0}, (1 - y) * film.half_height), side({0, -1, 0}, (1 + y) * film.half_height)};
    }
    Vec3 operator()(Vec3 p) const {
        const Vec3 d = p - camera_.origin;
        return {dot(d, camera_.right), dot(d, camera_.up), dot(d, camera_.forward)};
    }
    void note(const std::array<Vec3, 3>& p, CutGeometry& cut) const {
        const float nearest = std::min({p[0].z, p[1].z, p[2].z}),
                    farthest = std::max({p[0].z, p[1].z, p[2].z});
        if (!cut.before && nearest < planes_.near && farthest > 0)
            cut.before = shows(p, {{0, 0, -1}, planes_.near});
        if (!cut.behind && farthest > planes_.far) cut.behind = shows(p, {{0, 0, 1}, -planes_.far});
    }

private:
    bool shows(const std::array<Vec3, 3>& triangle, const HalfSpace& part) const {
        Polygon rest;
        for (Vec3 p : triangle) rest.add(p);
        rest = clipped(rest, part);
        if (camera_.is_orthographic()) rest = clipped(rest, {{0, 0, 1}, 0});
        for (const HalfSpace& side : sides_) rest = clipped(rest, side);
        return rest.count >= 3;
    }

    const Camera& camera_;
    const ClipPlanes& planes_;
    std::array<HalfSpace, 4> sides_;
};

void note_mesh(const Mesh& mesh, const Affine* to_world, const View& view, CutGeometry& cut) {
    const auto placed = [&](uint32_t i) {
        return view(to_world ? to_world->point(mesh.vertices[i]) : mesh.vertices[i]);
    };
    for (Vec3u t : mesh.triangles) {
        if (cut.before && cut.behind) return;
        view.note({placed(t.x), placed(t.y), placed(t.z)}, cut);
    }
}

}  // namespace

CutGeometry cut_geometry(const SceneDescription& scene, const Camera& camera, const ClipPlanes& planes) {
    CutGeometry cut;
    const View view(camera, planes);
    for (const Mesh& mesh : scene.meshes)
        if (mesh.in_world) note_mesh(mesh, nullptr, view, cut);
    for (const Instance& instance : scene.instances)
        for (int mesh : instance.meshes) note_mesh(scene.meshes[size_t(mesh)], &instance.to_world, view, cut);
    return cut;
}

}  // namespace viscache
