#include "viscache/correlation/surface_points.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

#include "viscache/correlation/spatial_groups.h"
#include "viscache/math/any_length.h"
#include "viscache/sampling/rng.h"
#include "viscache/sampling/warp.h"
#include "viscache/scene/film_camera.h"
#include "viscache/visibility/surface_hit.h"

namespace viscache {

namespace {

constexpr size_t kRaysPerChunk = 4096;
constexpr double kLeastShare = 1.0 / 1024;  // smallest fraction of strata that must hold a point

/// Passes of Purpose::kSurfacePoint.
enum Pass : uint64_t { kPlace, kThin, kShuffle };

struct Candidate {
    Vec3 position, normal, shading_normal;
    uint32_t stratum;
};

/// One candidate for each stratum that has a valid one, in the order of the strata.
struct Candidates {
    std::vector<Candidate> points;
    uint32_t width = 0, height = 0;
    uint64_t bad_normals = 0, misses = 0;

    size_t strata() const { return size_t(width) * height; }
    void append(const Candidates& more) {
        points.insert(points.end(), more.points.begin(), more.points.end());
        bad_normals += more.bad_normals;
        misses += more.misses;
    }
    /// Adds a hit. The normal is turned to `side`; without a side it follows the winding.
    void add(const SurfacePoint& s, uint32_t stratum, std::optional<Vec3> side) {
        if (!(length2(s.ng) > 0) || !is_finite(s.position)) {
            ++bad_normals;
            return;
        }
        const bool back = side && dot(s.ng, *side) < 0;
        points.push_back({s.position, back ? -s.ng : s.ng, back ? -s.ns : s.ns, stratum});
    }
};

/// Increases the number of strata until there are n candidates: propose(strata) → Candidates.
/// Strata without a point (sky, holes) make the needed number unknown beforehand. Each attempt starts anew,
/// so the result depends only on its number of strata.
template <class Propose>
Candidates at_least(size_t n, const char* what, Propose propose) {
    const double most = double(n) / kLeastShare;
    for (double strata = double(n);;) {
        Candidates c = propose(size_t(strata));
        const size_t found = c.points.size();
        if (found >= n) return c;
        if (strata >= most)
            throw std::invalid_argument(std::string(what) + ", got " + std::to_string(found) +
                                        " points from " + std::to_string(c.strata()) + " strata");
        // By the share that was found, and 2 % more: the next attempt is mostly the last.
        const double growth = found ? 1.02 * double(n) / double(found) : 32.0;
        strata = std::min(most, strata * std::max(1.02, growth) + 1);
    }
}

/// Keyed by the stratum: the same for any number of threads and any order of points.
uint64_t random_key(uint64_t seed, uint32_t stratum, Pass pass) {
    Rng rng(seed, Purpose::kSurfacePoint, stratum, pass);
    const uint64_t high = rng.next_u32();
    return high << 32 | rng.next_u32();
}

/// Keeps n randomly chosen candidates, in their order.
void thin(std::vector<Candidate>& points, size_t n, uint64_t seed) {
    using Keyed = std::pair<uint64_t, uint32_t>;
    std::vector<Keyed> keys(points.size());
    // The n smallest keys are a uniform choice without replacement.
    for (uint32_t i = 0; i < points.size(); ++i) keys[i] = {random_key(seed, points[i].stratum, kThin), i};
    if (n < keys.size()) std::nth_element(keys.begin(), keys.begin() + ptrdiff_t(n), keys.end());
    // Back to the order of the strata
    std::sort(keys.begin(), keys.begin() + ptrdiff_t(n),
              [](Keyed a, Keyed b) { return a.second < b.second; });
    for (size_t i = 0; i < n; ++i) points[i] = points[keys[i].second];
    points.resize(n);
}

/// Sorts n of the candidates by group; the order within a group is random.
SurfacePoints arrange(Candidates found, size_t n, uint64_t seed) {
    std::vector<Candidate>& points = found.points;
    thin(points, n, seed);
    std::vector<Vec3> position(n);
    for (size_t i = 0; i < n; ++i) position[i] = points[i].position;
    const std::vector<int32_t> group = spatial_groups(position);
    // Random within a group, so that any part of a group is a fair sample of it.
    std::vector<std::tuple<int32_t, uint64_t, uint32_t>> order(n);
    for (uint32_t i = 0; i < n; ++i) order[i] = {group[i], random_key(seed, points[i].stratum, kShuffle), i};
    std::sort(order.begin(), order.end());

    SurfacePoints out;
    out.width = found.width;
    out.height = found.height;
    out.bad_normals = found.bad_normals;
    out.misses = found.misses;
    for (const auto& [g, key, i] : order) {
        const Candidate& c = points[i];
        out.position.push_back(c.position);
        out.normal.push_back(c.normal);
        out.shading_normal.push_back(c.shading_normal);
        out.group.push_back(g);
        out.stratum.push_back(c.stratum);
    }
    return out;
}

/// Primary rays of a camera through an image of approximately square pixels.
class CameraStrata {
public:
    CameraStrata(const Scene& scene, const RayCaster& caster, const Camera& camera, uint64_t seed)
        : scene_(scene), caster_(caster), film_(camera, camera.width, camera.height), seed_(seed) {}

    Candidates hits(size_t strata, int threads, const Control& control) const {
        Candidates all;
        // Strata as square as the image allows
        all.height = uint32_t(std::max(1.0, std::sqrt(double(strata) * film_.height / film_.width)));
        all.width = uint32_t((strata + all.height - 1) / all.height);
        const size_t n = all.strata(), chunks = (n + kRaysPerChunk - 1) / kRaysPerChunk;
        std::vector<Candidates> part(chunks);
        parallel_for(chunks, threads, [&](size_t c, int) {
            control.check();
            part[c].width = all.width;
            part[c].height = all.height;
            trace(c * kRaysPerChunk, std::min(n, (c + 1) * kRaysPerChunk), part[c]);
        });
        // In the order of strata, whichever thread was first
        for (const Candidates& p : part) all.append(p);
        return all;
    }

private:
    void trace(size_t first, size_t last, Candidates& out) const {
        std::vector<Ray> rays(last - first);
        std::vector<Hit> hits(last - first);
        const float step_x = float(film_.width) / float(out.width),
                    step_y = float(film_.height) / float(out.height);
        for (size_t i = first; i < last; ++i) {
            // One random position per stratum, of its own stream
            const Vec2 jitter = Rng(seed_, Purpose::kSurfacePoint, i, kPlace).next2();
            const float x = (float(i % out.width) + jitter.x) * step_x,
                        y = (float(i / out.width) + jitter.y) * step_y;
            rays[i - first] = {film_.origin(x, y), 0, normalize(film_.direction(x, y)), kInfinity};
        }
        caster_.intersect(rays, hits, Coherence::kCoherent);
        for (size_t i = first; i < last; ++i) {
            const Hit& h = hits[i - first];
            if (!h.valid() || scene_.sphere_light_of(h.mesh) >= 0) {
                ++out.misses;
                continue;
            }
            // Normals are turned to the camera.
            const Ray& ray = rays[i - first];
            out.add(surface_at(scene_, ray, h), uint32_t(i), -ray.d);
        }
    }

    const Scene& scene_;
    const RayCaster& caster_;
    FilmCamera film_;
    uint64_t seed_;
};

/// All placed triangles in sequence, as a line along which every position is a surface point.
///
///     |---- triangle 0 ----|- 1 -|------ 2 ------|- 3 -| ...     lengths are areas
///     |     *   | *       |      *  |   *     |   *   | ...      one point per stratum
class AreaStrata {
public:
    AreaStrata(const Scene& scene, uint64_t seed, const Control& control)
        : scene_(scene), control_(control), seed_(seed) {
        for_each_triangle([&](double area, uint32_t, uint32_t, int) { total_ += area; });
        if (!(total_ > 0) || !std::isfinite(total_))
            throw std::invalid_argument("scene must have surfaces of finite, positive area, got area " +
                                        std::to_string(total_));
    }

    Candidates points(size_t strata) const {
        Candidates out;
        out.width = uint32_t(strata);
        out.height = 1;
        double before = 0;
        uint32_t next = 0;
        Rng rng = random(next);
        double target = place(next, strata, rng);
        for_each_triangle([&](double area, uint32_t mesh, uint32_t triangle, int instance) {
            // All strata whose position lies on this triangle. Both sequences ascend, so one pass is enough.
            for (; next < strata && target < before + area; target = place(next, strata, rng)) {
                const Vec2 b = square_to_triangle(rng.next2());
                if (scene_.solid_at(mesh, triangle, b.x, b.y))
                    out.add(scene_.surface(mesh, triangle, instance, b.x, b.y), next, {});
                else
                    ++out.misses;
                // Every stratum has its own stream, so adding strata elsewhere does not change its point.
                rng = random(++next);
            }
            before += area;
        });
        return out;
    }

private:
    Rng random(uint32_t stratum) const { return Rng(seed_, Purpose::kSurfacePoint, stratum, kPlace); }
    double place(uint32_t stratum, size_t strata, Rng& rng) const {
        return (stratum + double(rng.next())) / double(strata) * total_;
    }
    /// Calls visit(area, mesh, triangle, instance or −1) in a fixed order.
    template <class Visit>
    void for_each_triangle(Visit visit) const {
        for (uint32_t m = 0; m < scene_.described_meshes(); ++m)
            // Meshes that only instances use are not in the world themselves.
            if (scene_.meshes()[m].in_world) for_each_triangle_of(m, -1, visit);
        const std::vector<Instance>& instances = scene_.description().instances;
        for (size_t i = 0; i < instances.size(); ++i)
            for (int m : instances[i].meshes) for_each_triangle_of(uint32_t(m), int(i), visit);
    }
    template <class Visit>
    void for_each_triangle_of(uint32_t index, int instance, Visit visit) const {
        control_.check();
        const Mesh& mesh = scene_.meshes()[index];
        const Affine* to_world =
            instance < 0 ? nullptr : &scene_.description().instances[size_t(instance)].to_world;
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3u v = mesh.triangles[t];
            Vec3 p[3] = {mesh.vertices[v.x], mesh.vertices[v.y], mesh.vertices[v.z]};
            if (to_world)
                for (Vec3& q : p) q = to_world->point(q);
            // Tiny triangles have normals whose squares leave the range of float.
            visit(0.5 * double(any_length(cross(p[1] - p[0], p[2] - p[0]))), index, t, instance);
        }
    }

    const Scene& scene_;
    const Control& control_;
    uint64_t seed_;
    double total_ = 0;
};

}  // namespace

SurfacePoints camera_points(const Scene& scene, const RayCaster& caster, const Camera& camera, size_t n,
                            uint64_t seed, int threads, const Control& control) {
    const CameraStrata strata(scene, caster, camera, seed);
    const auto what = "camera must see surfaces in at least 1/1024 of its image";
    return arrange(at_least(n, what, [&](size_t s) { return strata.hits(s, threads, control); }), n, seed);
}

SurfacePoints area_points(const Scene& scene, size_t n, uint64_t seed, const Control& control) {
    const AreaStrata strata(scene, seed, control);
    const auto what = "at least 1/1024 of the scene's area must be solid and have a normal";
    return arrange(at_least(n, what, [&](size_t s) { return strata.points(s); }), n, seed);
}

}  // namespace viscache
