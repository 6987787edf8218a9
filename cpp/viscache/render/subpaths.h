#pragma once
// Sub-paths of bidirectional path tracing: one from the camera and one from a light per sample.
#include <span>
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/render/eye_paths.h"
#include "viscache/render/light_sampling.h"
#include "viscache/render/path_weight.h"
#include "viscache/render/scatter.h"
#include "viscache/render/settings.h"

namespace viscache {

/// Data of a frame that its paths need.
struct BdptContext {
    const Scene& scene;
    const RayCaster& caster;
    const LightSampler& lights;
    FilmCamera film;
    BdptSettings settings;
    FrameSettings frame;

    /// Density of a primary ray over the whole film: per sr, or per m² across parallel rays. `cosine`:
    /// between the ray and the optical axis.
    double film_pdf(double cosine) const {
        // On a film at distance one: area dA = dω/cos³ of the angle to the axis
        const double film_area = double(film.pixel_area()) * film.width * film.height;
        if (film.camera.is_orthographic()) return 1 / film_area;
        return 1 / (film_area * cosine * cosine * cosine);
    }
    /// N_S. It equals N_P, because every eye path is joined with one light path.
    double samples() const { return double(frame.width) * frame.height * frame.spp; }
    bool to_camera() const { return settings.camera_connections != CameraConnections::kOff; }
};

/// One sample of every pixel of a tile.
struct SampleTile {
    Tile tile;
    uint32_t sample = 0;
};

/// Vertices of many sub-paths, and the start of each.
struct Subpaths {
    // One array for all paths, so that a tile of paths allocates once
    size_t stride = 0;  ///< most vertices per path
    std::vector<PathVertex> vertex;
    std::vector<uint32_t> count;
    std::vector<Emission> start;  ///< for light paths

    void reset(size_t paths, size_t longest) {
        stride = longest;
        vertex.resize(paths * longest);
        count.assign(paths, 0);
        start.resize(paths);
    }
    std::span<PathVertex> of(size_t path) { return {&vertex[path * stride], count[path]}; }
    std::span<const PathVertex> of(size_t path) const { return {&vertex[path * stride], count[path]}; }
    PathVertex& append(size_t path) { return vertex[path * stride + count[path]++] = PathVertex{}; }
};

/// Contributions of eye paths without connections: sums per pixel of the tile, row-major.
struct EyeLight {
    std::vector<Rgb> emitted;  ///< weighted light of emitters that eye paths hit
    std::vector<Rgb> seen;     ///< the part of it that met only mirrors and glass on its way
    std::vector<FirstHits> first;
};

/// Traces the sub-paths of sample tiles. Its buffers are reused.
class SubpathTracer {
public:
    explicit SubpathTracer(const BdptContext& context) : c_(context) {}

    void trace_light(const SampleTile& work, Subpaths& out, Counters& counters, const Control& control);
    void trace_eye(const SampleTile& work, Subpaths& out, EyeLight& light, Counters& counters,
                   const Control& control);

private:
    /// A sub-path that is still followed.
    struct Walker {
        uint32_t path = 0;
        uint64_t stream = 0;
        Ray ray;
        Rgb beta;
        double pdf = 0;         ///< density of the ray's direction per sr, or per m² across parallel light
        bool parallel = false;  ///< on the first edge of light from infinity, or from parallel cameras
        // Since the last vertex that is neither mirror nor glass
        double spread = 0;  ///< density of the ray at that vertex × probabilities of later events
        bool parallel_spread = false;
        float distance = 0;
        bool direct = true;  ///< only mirrors and glass so far
    };
    void walk(Transport transport, size_t edges, Subpaths& out, EyeLight* light, Counters& counters,
              const Control& control);
    bool arrive(Walker& w, const Hit& hit, Subpaths& out, EyeLight* light, Counters& counters) const;
    PathVertex vertex_at(const Walker& w, const Hit& hit, const SurfacePoint& s) const;
    bool go_on(Walker& w, Transport transport, std::span<PathVertex> path) const;
    void add_emitted(const Walker& w, const PathVertex& emitter, double pdf_point, double pdf_before,
                     Rgb radiance, Subpaths& out, EyeLight& light, Counters& counters,
                     StrategyRules rules) const;
    void hit_environment(const Walker& w, Subpaths& out, EyeLight& light, Counters& counters) const;
    void hit_light(const Walker& w, const Hit& hit, const SurfacePoint& s, Subpaths& out, EyeLight& light,
                   Counters& counters) const;
    void add_first_hit(const Walker& w, const Hit& hit, const SurfacePoint& s, EyeLight& light) const;
    uint32_t pixel_of(uint32_t path) const {
        return uint32_t(places_[path].second) * uint32_t(width_) + places_[path].first;
    }
    uint64_t stream_of(const SampleTile& work, uint32_t path) const;
    void start(const SampleTile& work);

    const BdptContext& c_;
    int width_ = 0;
    std::vector<std::pair<uint16_t, uint16_t>> places_;
    std::vector<Walker> walkers_, next_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
};

}  // namespace viscache
