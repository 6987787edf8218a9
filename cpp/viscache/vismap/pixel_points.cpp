#include "viscache/vismap/pixel_points.h"

#include <cmath>

#include "viscache/sampling/pixel_place.h"
#include "viscache/scene/film_camera.h"
#include "viscache/visibility/surface_hit.h"

namespace viscache {

namespace {

/// Traces camera rays and measures the pixel at what they hit.
class FirstHitFinder {
public:
    FirstHitFinder(const Scene& scene, const RayCaster& caster, const Camera& camera, int width, int height,
                   const PixelRules& rules)
        : scene_(scene), caster_(caster), film_(camera, width, height), rules_(rules) {}

    /// First hits through places of the film, in pixels.
    PixelPoints find(std::span<const Vec2> places) const {
        std::vector<Ray> rays;
        for (Vec2 p : places)
            rays.push_back({film_.origin(p.x, p.y), 0, normalize(film_.direction(p.x, p.y)), kInfinity});
        std::vector<Hit> hits(rays.size());
        caster_.intersect(rays, hits, Coherence::kCoherent);
        PixelPoints out;
        for (size_t i = 0; i < rays.size(); ++i) out.points.push_back(point(rays[i], hits[i], out));
        return out;
    }

private:
    CachePoint point(const Ray& ray, const Hit& hit, PixelPoints& out) const {
        // Sphere lights have no surface on which a record could lie.
        if (!hit.valid() || scene_.sphere_light_of(hit.mesh) >= 0) {
            ++out.misses;
            return {};
        }
        const SurfacePoint s = surface_at(scene_, ray, hit);
        const float cos_surface = std::fabs(dot(s.ng, ray.d));
        // A normal is a unit vector, or zero for a degenerate triangle.
        if (!(length2(s.ng) > 0.5f) || !is_finite(s.ng) || !is_finite(s.position)) {
            ++out.bad_normals;
            return {};
        }
        const float cos_film = dot(ray.d, film_.camera.forward);
        // A pinhole: distance × √(solid angle of the pixel)
        const float across = film_.pixel_area_at(cos_film, 1) / std::max(cos_surface, rules_.least_cos);
        // A pixel's beam widens with distance only in perspective.
        const float spread = film_.camera.is_orthographic() ? 1.f : hit.t;
        const float footprint = spread * std::sqrt(across);
        // reach × image width: d_max is given in pixels and turned into a length at the point.
        const float d_max = std::min(rules_.reach * float(film_.width) * footprint,
                                     rules_.most_reach * scene_.bounds().diagonal());
        // Records belong to the side that the camera sees.
        return {s.position, dot(s.ng, ray.d) > 0 ? -s.ng : s.ng, d_max, footprint};
    }

    const Scene& scene_;
    const RayCaster& caster_;
    FilmCamera film_;
    PixelRules rules_;
};

/// Points of all pixels; place(pixel) lies in the pixel.
template <class Place>
PixelPoints points_of_pixels(const FirstHitFinder& finder, int width, int height, Place place, int threads,
                             const Control& control) {
    PixelPoints all;
    all.points.resize(size_t(width) * size_t(height));
    // One set of counters per row, so that rows need no lock.
    std::vector<PixelPoints> rows(static_cast<size_t>(height));
    parallel_for(size_t(height), threads, [&](size_t y, int) {
        control.check();
        std::vector<Vec2> places;
        for (int x = 0; x < width; ++x) {
            const Vec2 at = place(y * size_t(width) + size_t(x));
            places.push_back({float(x) + at.x, float(y) + at.y});
        }
        rows[y] = finder.find(places);
        std::copy(rows[y].points.begin(), rows[y].points.end(),
                  all.points.begin() + std::ptrdiff_t(y * size_t(width)));
        rows[y].points.clear();
    });
    // Integers: the sums do not depend on the order of rows.
    for (const PixelPoints& row : rows) {
        all.misses += row.misses;
        all.bad_normals += row.bad_normals;
    }
    return all;
}

}  // namespace

PixelPoints pixel_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                         int height, Vec2 at, const PixelRules& rules, int threads, const Control& control) {
    const FirstHitFinder finder(scene, caster, camera, width, height, rules);
    return points_of_pixels(finder, width, height, [&](uint64_t) { return at; }, threads, control);
}

PixelPoints sample_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                          int height, uint64_t seed, uint32_t sample, const PixelRules& rules, int threads,
                          const Control& control) {
    const FirstHitFinder finder(scene, caster, camera, width, height, rules);
    const auto place = [&](uint64_t pixel) { return pixel_place(seed, pixel, sample); };
    return points_of_pixels(finder, width, height, place, threads, control);
}

PixelPoints startup_points(const Scene& scene, const RayCaster& caster, const Camera& camera, int width,
                           int height, size_t n, uint64_t seed, const PixelRules& rules,
                           const Control& control) {
    control.check();
    // Cells as square as their number allows; cell k of n is in row k / columns
    // n ≈ rows · columns with rows / columns ≈ height / width
    const auto rows = size_t(std::max(1.0, std::round(std::sqrt(double(n) * height / width))));
    const size_t columns = (n + rows - 1) / rows, used_rows = (n + columns - 1) / columns;
    std::vector<Vec2> places;
    for (size_t k = 0; k < n; ++k) {
        // The last row may have fewer cells; they are wider, so that every cell lies in the image.
        const size_t row = k / columns, in_row = std::min(columns, n - row * columns);
        const Vec2 jitter = Rng(seed, Purpose::kMapStartup, k, 0).next2();
        places.push_back({(float(k % columns) + jitter.x) * float(width) / float(in_row),
                          (float(row) + jitter.y) * float(height) / float(used_rows)});
    }
    return FirstHitFinder(scene, caster, camera, width, height, rules).find(places);
}

}  // namespace viscache
