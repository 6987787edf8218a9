#include "viscache/render/eye_paths.h"

#include "viscache/sampling/rng.h"
#include "viscache/sampling/warp.h"

namespace viscache {

namespace {

constexpr size_t kRaysPerCall = 512;  // small enough that the buffers stay in the cache; a multiple of 16
constexpr float kWeak = 3e-3f;        // weaker branches play Russian roulette

/// One branch of an eye path that is still followed.
struct Branch {
    Ray ray;
    Rgb throughput{1, 1, 1};
    uint32_t pixel;
    uint32_t order_x, order_y;
    uint64_t stream;
    float distance = 0;  ///< unfolded length so far
    float camera_cos;    ///< cosine of the primary ray to the optical axis
    float index2 = 1;    ///< squared index of refraction relative to the camera's medium; undoes the
                         ///< compression of radiance
    int depth = 0;
};

}  // namespace

void EyeTile::reset(int w, int h) {
    width = w;
    height = h;
    block.clear();
    // `EyeBlock::clear` leaves these, because arrays of points have none
    block.tile_width = block.tile_height = 0;
    shading.clear();
    throughput.clear();
    pixel.clear();
    stream.clear();
    const size_t n = size_t(w) * h;
    emitted.assign(n, {});
    first.assign(n, {});
}

namespace {

/// Traces all branches of one tile.
class TilePaths {
public:
    TilePaths(const EyePathTracer& tracer, EyeTile& out, Counters& counters)
        : t_(tracer),
          out_(out),
          counters_(counters),
          inverse_spp_(1.f / tracer.frame.spp),
          // Frames that go on have other random numbers: their streams follow those of the samples
          // before
          first_stream_(tracer.frame.first_sample * uint64_t(tracer.film.width) *
                        uint64_t(tracer.film.height)) {}

    void run(const Tile& tile, const Control& control) {
        trace_primary(tile, control);
        // Rays that mirrors and glass have spawned
        while (!next_.empty()) {
            std::swap(branches_, next_);
            next_.clear();
            // Generation by generation, so that rays of all branches are traced in full calls
            for (size_t first = 0; first < branches_.size(); first += kRaysPerCall)
                step(std::span(branches_).subspan(first, std::min(kRaysPerCall, branches_.size() - first)),
                     Coherence::kIncoherent, control);
        }
    }

private:
    /// Traces all samples of the tile, pixel by pixel along its Morton curve.
    void trace_primary(const Tile& tile, const Control& control) {
        // For the order of Sec. 4.3 of AQVC, the samples of a pixel lie on a grid inside of it
        const int spp = t_.frame.spp, grid = int(std::ceil(std::sqrt(double(spp))));
        out_.reset(tile.x1 - tile.x0, tile.y1 - tile.y0);
        out_.block.tile_width = uint32_t(out_.width * grid);
        out_.block.tile_height = uint32_t(out_.height * grid);
        const uint64_t first = t_.frame.first_sample;
        out_.first_sample = first;
        const auto flush = [&] {
            step(branches_, Coherence::kCoherent, control);
            branches_.clear();
        };
        for (auto [px, py] : morton_pixels(out_.width, out_.height)) {
            const int x = tile.x0 + px, y = tile.y0 + py;
            const uint64_t pixel_id = uint64_t(y) * uint64_t(t_.film.width) + uint64_t(x);
            // The same places for every method, and one sequence over frames that go on
            const PixelPlaces places(t_.frame.seed, pixel_id, first);
            for (int s = 0; s < spp; ++s) {
                const Vec2 jitter =
                    t_.integrator.centred ? Vec2{0.5f, 0.5f} : places[uint32_t(first + uint64_t(s))];
                Branch& b = branches_.emplace_back(primary(float(x) + jitter.x, float(y) + jitter.y));
                b.pixel = uint32_t(py * out_.width + px);
                b.order_x = uint32_t(px * grid + s % grid);
                b.order_y = uint32_t(py * grid + s / grid);
                // Room below for the number of a branch
                b.stream = (first_stream_ + pixel_id * uint64_t(spp) + uint64_t(s)) << kBranchBits;
                if (branches_.size() == kRaysPerCall) flush();
            }
        }
        flush();
    }

    /// The primary ray through a position on the film.
    Branch primary(float x, float y) const {
        const FilmCamera& film = t_.film;
        const Vec3 raw = film.direction(x, y);
        // Directions of the film have the length 1/cosine to the optical axis
        const float norm = length(raw);
        Branch b;
        b.ray = {film.origin(x, y), 0, raw / norm, kInfinity};
        b.camera_cos = 1 / norm;
        return b;
    }

    void step(std::span<Branch> branches, Coherence coherence, const Control& control) {
        control.check();
        const size_t n = branches.size();
        rays_.resize(n);
        hits_.resize(n);
        for (size_t i = 0; i < n; ++i) rays_[i] = branches[i].ray;
        // Primary rays of a run along the curve are coherent; branches are not
        t_.caster.intersect(rays_, hits_, coherence);
        for (size_t i = 0; i < n; ++i) arrive(branches[i], hits_[i]);
        counters_.camera_rays += n;
    }

    void arrive(Branch& b, const Hit& hit) {
        if (!hit.valid()) {
            // Ambient occlusion shows no light but its own
            if (const EnvironmentMap* env = t_.scene.environment(); env && !t_.integrator.ambient)
                out_.emitted[b.pixel] += b.throughput * env->eval(b.ray.d) * inverse_spp_;
            return;
        }
        const int instance = hit.instance == kNoHit ? -1 : int(hit.instance);
        SurfacePoint s = t_.scene.surface(hit.mesh, hit.triangle, instance, hit.u, hit.v);
        const Vec3 wo = -b.ray.d;
        const bool front = dot(s.ng, wo) >= 0;
        // Seen directly or in mirrors. Lights that are found otherwise are connections
        if (!t_.integrator.ambient && max_component(s.emission) > 0 && (front || s.emits_two_sided))
            out_.emitted[b.pixel] += b.throughput * s.emission * inverse_spp_;
        // What the pixel shows first, mirrors and glass included: for layers that filters use
        if (b.depth == 0) {
            FirstHits& first = out_.first[b.pixel];
            ++first.count;
            first.depth += hit.t;
            first.normal += front ? s.ns : -s.ns;
            first.albedo += s.base_color;
        }
        if (length2(s.ng) == 0) return;  // a degenerate triangle has no sides
        b.distance += hit.t;
        const Material& material = t_.scene.materials()[size_t(s.material)];
        if (t_.integrator.ambient) {  // only geometry matters: mirrors and glass count as surfaces
            store(b, s, material, front);
            return;
        }
        switch (material.kind) {
            case MaterialKind::kDiffuse: store(b, s, material, front); break;
            case MaterialKind::kGlossy:
                store(b, s, material, front);
                if (material.thin && (front || material.two_sided)) pass(b, s, front);
                break;
            case MaterialKind::kMirror:
                // The back of a one-sided mirror absorbs
                if (material.two_sided || front)
                    reflect(b, s, front,
                            mirror_reflectance(material.specular, t_.scene.metal(s.material),
                                               std::fabs(dot(s.ns, wo))));
                break;
            case MaterialKind::kDielectric: split(b, s, material, front); break;
        }
    }

    /// Stores a point on a diffuse or glossy surface as an eye point.
    void store(const Branch& b, const SurfacePoint& s, const Material& material, bool front) {
        // Backs of one-sided surfaces are black
        if (!front && !material.two_sided && !t_.integrator.ambient) return;
        // `Direct` shades what the camera sees itself; behind mirrors only emitters count
        if (b.depth > 0 && !t_.integrator.shade_after_specular) return;
        const Vec3 ng = front ? s.ng : -s.ng;
        ShadingPoint sp = t_.scene.reflection(s);
        sp.ng = ng;
        sp.ns = front ? s.ns : -s.ns;
        sp.wo = -b.ray.d;
        // A shading normal that faces away from the eye would make the surface black: use the geometric
        // normal
        if (dot(sp.ns, sp.wo) <= 0) sp.ns = ng;
        sp.mirror = material.coat == CoatKind::kSmooth;
        // Bounded below, since cells of a cache grow as the density falls
        const float cos_eye = std::max(std::fabs(dot(ng, b.ray.d)), kLeastCosine);
        out_.block.position.push_back(s.position);
        out_.block.normal.push_back(ng);
        out_.block.origin.push_back(spawn(s.position, ng, t_.scene.offset_extent()));
        out_.block.density.push_back(density(b, cos_eye));
        out_.block.order_x.push_back(b.order_x);
        out_.block.order_y.push_back(b.order_y);
        const uint64_t sample = (b.stream >> kBranchBits) - first_stream_, spp = uint64_t(t_.frame.spp);
        // Pixel and branch, without the number of the sample: eye points of one place share
        // sequences
        out_.block.place.push_back(sample / spp << kBranchBits | b.stream % kBranches);
        out_.block.turn.push_back(uint32_t(t_.frame.first_sample + sample % spp));
        out_.shading.push_back(sp);
        out_.throughput.push_back(b.throughput * inverse_spp_);
        out_.pixel.push_back(b.pixel);
        out_.stream.push_back(b.stream);
    }

    /// D_e = N_S·P_e: eye samples per unit area at the point.
    float density(const Branch& b, float cos_eye) const {
        // The pixel's area at the unfolded distance: mirrors and glass are passed as if they were
        // not there
        return float(t_.frame.spp) * cos_eye / t_.film.pixel_area_at(b.camera_cos, b.distance);
    }

    /// Largest share of the pixel's light that a branch can carry, in any medium.
    static float strength(const Branch& b) { return luminance(b.throughput) * b.index2; }

    /// Russian roulette for weak branches. Survivors get the weight that keeps the expectation.
    bool survives(Branch& branch) const {
        const float s = strength(branch);
        if (s >= kWeak) return true;
        // Keyed by the branch: whether it survives does not depend on any other
        Rng rng(t_.frame.seed, Purpose::kBranch, branch.stream, uint64_t(branch.depth));
        if (!(rng.next() * kWeak < s)) return false;
        branch.throughput = branch.throughput * (kWeak / s);
        return true;
    }

    /// Continues a branch from the surface with its new throughput and medium.
    void follow(Branch branch, const SurfacePoint& s, Vec3 side, Vec3 direction, uint64_t which) {
        if (branch.depth >= t_.integrator.max_depth) return lose(branch);
        // From the side on which the path goes on
        branch.ray = {spawn(s.position, side, t_.scene.offset_extent()), 0, normalize(direction), kInfinity};
        // Branches are numbered as nodes of a binary heap: those of k are 2k + 1 and 2k + 2. After
        // nine levels numbers repeat, which correlates such deep branches and biases none
        const uint64_t number = branch.stream % kBranches;
        branch.stream += (number * 2 + 1 + which) % kBranches - number;
        ++branch.depth;
        if (survives(branch)) next_.push_back(branch);
    }

    /// Light that no path brings any more is counted, so that a picture that is too dark says so.
    void lose(const Branch& b) { counters_.lost_throughput += double(strength(b)); }

    void reflect(const Branch& b, const SurfacePoint& s, bool front, Rgb factor) {
        const Vec3 ng = front ? s.ng : -s.ng;
        Vec3 n = front ? s.ns : -s.ns;
        Vec3 direction = b.ray.d - n * (2 * dot(b.ray.d, n));
        // Into the surface: the geometric normal cannot do that
        if (dot(direction, ng) <= 0) {
            n = ng;
            direction = b.ray.d - n * (2 * dot(b.ray.d, n));
        }
        Branch reflected = b;
        reflected.throughput = b.throughput * factor;
        follow(reflected, s, ng, direction, 0);
    }

    /// Follows the reflected and the refracted branch of glass.
    void split(const Branch& b, const SurfacePoint& s, const Material& material, bool front) {
        if (material.thin) return pass(b, s, front);
        const Vec3 ng = front ? s.ng : -s.ng, n = front ? s.ns : -s.ns;
        const float cos_i = dot(s.ns, -b.ray.d);  // the sign tells the side
        const GlassShares shares = glass_shares(t_.scene.reflection(s), cos_i);
        reflect(b, s, front, shares.mirrored);
        // Total reflection, or black glass
        if (!(max_component(shares.passed) > 0)) return;
        const float eta = front ? 1 / material.eta : material.eta;  // incoming index over the other
        // The change of index compresses radiance. This cancels where the path leaves the glass again
        Branch through = b;
        through.throughput = b.throughput * (shares.passed * eta * eta);
        // What `strength` undoes: a branch inside of glass is not weaker than it will be outside
        through.index2 = b.index2 / (eta * eta);
        const auto transmitted = viscache::refract(-b.ray.d, n, eta);
        // The shading normal bends it back to its own side, or rounding at the edge of total
        // reflection
        if (!transmitted || dot(*transmitted, ng) >= 0) return lose(through);
        follow(through, s, -ng, *transmitted, 1);
    }

    /// Follows the reflected branch of a thin plate, and the one that goes straight on, as through a sheet.
    void pass(const Branch& b, const SurfacePoint& s, bool front) {
        const GlassShares shares = glass_shares(t_.scene.reflection(s), dot(s.ns, b.ray.d));
        if (max_component(shares.mirrored) > 0) reflect(b, s, front, shares.mirrored);
        if (!(max_component(shares.passed) > 0)) return;
        Branch through = b;
        through.throughput = b.throughput * shares.passed;
        follow(through, s, front ? -s.ng : s.ng, b.ray.d, 1);
    }

    const EyePathTracer& t_;
    EyeTile& out_;
    Counters& counters_;
    const float inverse_spp_;
    const uint64_t first_stream_;  ///< streams of the frames before this one
    std::vector<Branch> branches_, next_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
};

}  // namespace

void EyePathTracer::trace(const Tile& tile, EyeTile& out, Counters& counters, const Control& control) const {
    TilePaths(*this, out, counters).run(tile, control);
}

}  // namespace viscache
