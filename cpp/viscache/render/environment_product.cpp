#include "viscache/render/environment_product.h"

#include <chrono>

#include "viscache/math/cpu_time.h"
#include "viscache/render/local_samples.h"

namespace viscache {

namespace {

// Enough rays for full packets. Trees of several passes are kept for all points of a batch, so
// these are bounded lower
constexpr size_t kSamplesPerBatch = 8192;
constexpr size_t kMostEyes = 256, kMostKeptEyes = 64;

/// Wall clock, which is cheap to read. The CPU time of a batch is split in proportion to it.
double tick() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

size_t pixel_in_frame(const Tile& tile, const EyeTile& eyes, uint32_t eye, int frame_width) {
    // Map sources are asked by the pixel of the frame, eye points know that of their tile
    const uint32_t p = eyes.pixel[eye], w = uint32_t(eyes.width);
    return size_t(tile.y0 + int(p / w)) * size_t(frame_width) + size_t(tile.x0 + int(p % w));
}

// f·cos: the integrand without light and visibility
Rgb reflected(const ShadingPoint& sp, Vec3 wi) { return eval_bsdf(sp, wi) * std::max(0.f, dot(sp.ns, wi)); }

bool finite(const DirectionSample& s) { return std::isfinite(s.z) && std::isfinite(s.w); }

}  // namespace

void EnvironmentProduct::prepare(const Tile& tile, const EyeTile& eyes, Slot& slot, PointEstimate& point,
                                 Counters& counters) {
    // A point whose product of light and reflection vanishes needs no maps and no samples
    ++counters.product_points;
    if (point.dark()) ++counters.product_dark;
    if (!c_.maps || point.dark()) return;
    // Where J replaces the estimate, nothing is drawn and a shaped density would be work for
    // nothing
    const bool guide = c_.settings.density() == DensityChoice::kGuided ||
                       (c_.settings.density() == DensityChoice::kAuto && c_.guided);
    slot.maps = read_(eyes.block.position[slot.eye], eyes.block.normal[slot.eye],
                      pixel_in_frame(tile, eyes, slot.eye, c_.frame_width));
    counters.product_without_record += slot.maps.count == 0;
    point.look(slot.maps, guide && !c_.settings.replace);
    // Sources that number their records want to know which ones were used
    if (!tally_.used.empty())
        for (int i = 0; i < slot.maps.count; ++i) tally_.used[slot.maps.id[i]] = 1;
    // The density follows the dilated maps, but never below eta times product sampling: errors of
    // the maps cost variance, not bias
    if (guide && !c_.settings.replace) counters.product_guided += point.guide(c_.settings.eta);
}

void EnvironmentProduct::draw(const EyeTile& eyes, size_t slot, const PointEstimate& point, int pass,
                              Counters& counters) {
    const uint32_t eye = slots_[slot].eye;
    const ShadingPoint& sp = eyes.shading[eye];
    const size_t n = size_t(c_.integrator.n_environment);
    // Maps may have learnt from rays of the frames before, so the samples must be independent of theirs
    const uint64_t sequence = c_.maps ? eyes.first_sample : eyes.sequence();
    const uint32_t sample = c_.maps ? eyes.sample_of_frame(eye) : eyes.sample(eye);
    const PointStream stream(c_.integrator.points, c_.seed, Purpose::kProduct, eyes.block.place[eye],
                             sequence * uint64_t(c_.integrator.passes) + uint64_t(pass), sample, uint32_t(n));
    // Queries are gathered for all points of the batch, so that their rays fill packets
    for (size_t i = slot * n; i < (slot + 1) * n; ++i) {
        DirectionSample& out = samples_[i];
        const ProductTree::Sample s = point.draw(stream.at(uint32_t(i - slot * n)));
        const Rgb b = reflected(sp, s.wi);
        out = point.complete(s, b);
        // B over the B̃ that the density knows: how far a weight can leave its mean
        counters.greatest_ratio = std::max(counters.greatest_ratio, double(luminance(b) / s.b));
        if (!finite(out)) {
            ++counters.non_finite;
            // A sample of nothing keeps its place, so the divisor n stays right
            out = {};
        }
        visible_[i] = 0;
        // A direction that brings nothing needs no ray
        if (out.matters) {
            queries_.push_back(query_towards(eye, s.wi, LightGroup::kEnvironment, 0));
            asked_.push_back(uint32_t(i));
        }
    }
}

void EnvironmentProduct::finish(const EyeTile& eyes, int pass, std::span<Rgb> sum, std::span<Rgb> last,
                                Counters& counters) {
    const size_t n = size_t(c_.integrator.n_environment);
    for (size_t k = 0; k < slots_.size(); ++k) {
        Slot& slot = slots_[k];
        // J is the integral of the maps alone; otherwise samples correct it, with the α that the
        // setting chooses
        const Rgbd e = c_.settings.replace && c_.maps
                           ? slot.moments.j
                           : finish_pass(slot.moments, {&samples_[k * n], n}, {&visible_[k * n], n},
                                         c_.settings.alpha, slot.earlier);
        const Rgb value = eyes.throughput[slot.eye] * Rgb{float(e[0]), float(e[1]), float(e[2])};
        if (!is_finite(value)) {
            ++counters.non_finite;
            continue;
        }
        // The picture is the mean of all passes. The last one also has a layer of its own: its α
        // comes from all passes before it
        sum[eyes.pixel[slot.eye]] += value * (1 / float(c_.integrator.passes));
        if (pass == c_.integrator.passes - 1) last[eyes.pixel[slot.eye]] += value;
    }
}

void EnvironmentProduct::compare_records() {
    const size_t n = size_t(c_.integrator.n_environment);
    // Two bits of a Morton code per level: texels of the environment to cells of the maps
    const int below = 2 * (c_.light.levels() - c_.maps->m);
    for (const uint32_t sample : asked_) {
        const BlendedMaps& maps = slots_[sample / n].maps;
        const size_t cell = samples_[sample].texel >> below;
        // Undoes the shape of the density, so that rates of error are those under product sampling
        const uint64_t weight = RecordTally::weight(samples_[sample].d);
        for (int i = 0; i < maps.count; ++i)
            // Every blended record is compared by itself: a blend hides which of them is wrong
            tally_.compare(maps.id[i], get_bit(maps.bits[i], cell), visible_[sample] != 0, weight);
    }
}

void EnvironmentProduct::add(const Tile& tile, const EyeTile& eyes, VisibilityOracle& oracle,
                             std::span<Rgb> sum, std::span<Rgb> last, Counters& counters,
                             ProductSeconds& seconds, const Control& control) {
    // Trees are expensive to build. With several passes those of a batch are kept, otherwise one
    // buffer serves all points
    const bool keep = c_.integrator.passes > 1, replace = c_.settings.replace && c_.maps;
    const size_t n = size_t(c_.integrator.n_environment);
    const size_t batch = std::clamp<size_t>(kSamplesPerBatch / n, 1, keep ? kMostKeptEyes : kMostEyes);
    points_.resize(keep ? batch : 1);
    for (size_t first = 0; first < eyes.size(); first += batch) {
        control.check();
        slots_.clear();
        for (size_t i = first; i < std::min(first + batch, eyes.size()); ++i)
            // Points that reflect nothing get no slot, and so no samples
            if (!is_black(eyes.shading[i])) slots_.push_back({uint32_t(i), {}, {}, {}});
        samples_.assign(slots_.size() * n, {});
        visible_.assign(slots_.size() * n, 0);
        for (int pass = 0; pass < c_.integrator.passes; ++pass) {
            // Reading the CPU clock is a system call, too slow for each step of each point: the
            // steps are timed by the wall clock, and the CPU time of the batch is split in
            // proportion
            const double cpu = thread_cpu_seconds();
            double trees = 0, maps = 0, drawn = 0;
            queries_.clear();
            asked_.clear();
            for (size_t k = 0; k < slots_.size(); ++k) {
                PointEstimate& point = points_[keep ? k : 0];
                const uint32_t eye = slots_[k].eye;
                // Light × reflection and the maps do not change from pass to pass, so the first
                // pass prepares them for all
                const double start = tick();
                if (pass == 0)
                    point.begin(c_.light, SurfaceReflection(eyes.shading[eye]), c_.maps ? c_.maps->m : 5);
                const double built = tick();
                if (pass == 0) prepare(tile, eyes, slots_[k], point, counters);
                // Moments are copied: without several passes the next point reuses the estimate
                slots_[k].moments = point.moments();
                const double looked = tick();
                if (!replace && !point.dark()) draw(eyes, k, point, pass, counters);
                trees += built - start;
                maps += looked - built;
                drawn += tick() - looked;
            }
            // 1e-30: a batch without points has no time to split
            const double before = thread_cpu_seconds(),
                         share = (before - cpu) / (trees + maps + drawn + 1e-30);
            seconds.trees += trees * share;
            seconds.maps += maps * share;
            seconds.samples += drawn * share;
            const Answer answer = oracle.pairs({eyes.block, queries_}, counters);
            for_each_bit(answer.row(0), [&](size_t i) { visible_[asked_[i]] = 1; });
            const double traced = thread_cpu_seconds();
            finish(eyes, pass, sum, last, counters);
            if (!tally_.rays.empty()) compare_records();
            seconds.visibility += traced - before;
            seconds.finish += thread_cpu_seconds() - traced;
        }
    }
}

namespace {

/// Pilot: so many pixels, samples of each, and pixels of a work item. Guided sampling must promise
/// a tenth less variance, because it costs time. Its pass number is one that no frame has, so that
/// its random numbers are independent of the frame's.
constexpr size_t kPilotPixels = 1024, kPilotSamples = 16, kPilotChunk = 32;
constexpr double kGuidedBelow = 0.9;
constexpr uint64_t kPilotPass = ~uint64_t{0};

/// Sums over the pilot pixels in squared radiance: for the product density (0) and the guided density (1).
struct PilotSums {
    double variance[2]{}, covariance[2]{}, variance_w[2]{};
    void merge(const PilotSums& b) {
        for (int k = 0; k < 2; ++k) {
            variance[k] += b.variance[k];
            covariance[k] += b.covariance[k];
            variance_w[k] += b.variance_w[k];
        }
    }
    /// Adds the product samples of one point. They estimate both densities: E_p[y²] = E_IS[y² D^(−1)] for y
    /// over p.
    void add(const PointMoments& point, std::span<const DirectionSample> samples,
             std::span<const uint8_t> visible, std::span<const double> d) {
        AlphaSums sums;
        for (size_t i = 0; i < samples.size(); ++i)
            // α of this point, by regression on the same samples; that of the frame is pooled over
            // all points below
            sums.add((visible[i] ? samples[i].z : 0) - point.mean_w, samples[i].w - point.mean_w);
        const double alpha = regressed_alpha(sums, point.variance_w), n = double(samples.size());
        double y1 = 0, y2[2]{}, zw[2]{}, ww[2]{}, z1 = 0;
        for (size_t i = 0; i < samples.size(); ++i) {
            const double z = visible[i] ? samples[i].z : 0, w = samples[i].w, y = z - alpha * w;
            y1 += y;
            z1 += z;
            for (int k = 0; k < 2; ++k) {
                // The weight of a sample under the other density; 1 for its own
                const double q = 1 / (k ? d[i] : 1);
                y2[k] += y * y * q;
                zw[k] += z * w * q;
                ww[k] += w * w * q;
            }
        }
        // Z and W are relative to L_ns; squared radiance makes pixels comparable, so that bright
        // ones count as much as they do in the picture
        const double scale = point.l_ns * point.l_ns, mean = y1 / n, mu = point.mean_w;
        for (int k = 0; k < 2; ++k) {
            // With few samples the estimate of a small variance can be negative
            variance[k] += scale * std::max(0.0, y2[k] / n - mean * mean);
            covariance[k] += scale * (zw[k] / n - z1 / n * mu);
            variance_w[k] += scale * std::max(0.0, ww[k] / n - mu * mu);
        }
    }
};

/// Runs the pilot on one thread.
class Pilot {
public:
    Pilot(const ProductContext& c, const EyePathTracer& tracer, std::unique_ptr<VisibilityOracle> oracle)
        : c_(c), tracer_(tracer), oracle_(std::move(oracle)), read_(c.maps->reader()) {}

    void try_pixel(size_t pixel, PilotSums& sums, Counters& counters, const Control& control) {
        const int x = int(pixel % size_t(c_.frame_width)), y = int(pixel / size_t(c_.frame_width));
        // A tile of one pixel gives the eye point that the frame has there
        const Tile tile{x, y, x + 1, y + 1};
        tracer_.trace(tile, eyes_, counters, control);
        if (eyes_.size() == 0 || is_black(eyes_.shading[0])) return;
        point_.begin(c_.light, SurfaceReflection(eyes_.shading[0]), c_.maps->m);
        if (point_.dark()) return;
        point_.look(read_(eyes_.block.position[0], eyes_.block.normal[0], pixel), true);
        if (!point_.has_maps()) return;
        // D is computed but not applied: samples come from the product density and are weighted for
        // both
        const bool shaped = point_.guide(c_.settings.eta, false);
        const PointStream stream(c_.integrator.points, c_.seed, Purpose::kProduct, eyes_.stream[0],
                                 kPilotPass);
        std::vector<ShadowQuery> queries;
        std::vector<size_t> asked;
        for (size_t i = 0; i < kPilotSamples; ++i) {
            const ProductTree::Sample s = point_.draw(stream.at(uint32_t(i)));
            samples_[i] = point_.complete(s, reflected(eyes_.shading[0], s.wi));
            if (!finite(samples_[i])) samples_[i] = {};
            d_[i] = shaped ? point_.shaped_density(s.texel) : 1;
            visible_[i] = 0;
            if (samples_[i].matters) {
                queries.push_back(query_towards(0, s.wi, LightGroup::kEnvironment, 0));
                asked.push_back(i);
            }
        }
        // The pilot asks the frame's own oracle, so a cache's errors enter the forecast as they
        // will enter the frame
        oracle_->begin_tile(eyes_.block);
        const uint64_t before = counters.rays();
        const Answer answer = oracle_->pairs({eyes_.block, queries}, counters);
        counters.pilot_rays += counters.rays() - before;
        for (size_t i = 0; i < asked.size(); ++i) visible_[asked[i]] = answer.bits->get(0, i);
        sums.add(point_.moments(), samples_, visible_, d_);
    }

private:
    const ProductContext& c_;
    const EyePathTracer& tracer_;
    std::unique_ptr<VisibilityOracle> oracle_;
    MapReader read_;
    EyeTile eyes_;
    PointEstimate point_;
    std::array<DirectionSample, kPilotSamples> samples_;
    std::array<uint8_t, kPilotSamples> visible_;
    std::array<double, kPilotSamples> d_;
};

}  // namespace

Forecast forecast(const ProductContext& c, const EyePathTracer& tracer, OracleSource& source, int threads,
                  Counters& counters, const Control& control) {
    const size_t pixels = size_t(tracer.frame.width) * size_t(tracer.frame.height);
    const size_t tried = std::min(pixels, kPilotPixels), chunks = (tried + kPilotChunk - 1) / kPilotChunk;
    std::vector<PilotSums> sums(chunks);
    std::vector<Counters> counted(chunks);
    std::vector<std::unique_ptr<Pilot>> pilots(size_t(resolve_threads(threads)));
    parallel_for(chunks, threads, [&](size_t chunk, int worker) {
        control.check();
        // Made on its own thread when it is first needed
        auto& pilot = pilots[size_t(worker)];
        if (!pilot) pilot = std::make_unique<Pilot>(c, tracer, source.make());
        for (size_t i = chunk * kPilotChunk; i < std::min(tried, (chunk + 1) * kPilotChunk); ++i) {
            // One random pixel from each of equal parts of the frame
            Rng rng(c.seed, Purpose::kProduct, i, kPilotPass - 1);
            const size_t from = i * pixels / tried, to = (i + 1) * pixels / tried;
            const size_t pixel = from + std::min(to - from - 1, size_t(rng.next() * float(to - from)));
            pilot->try_pixel(pixel, sums[chunk], counted[chunk], control);
        }
    });
    PilotSums all;
    // In the order of the chunks: sums of doubles depend on it
    for (size_t i = 0; i < chunks; ++i) {
        all.merge(sums[i]);
        counters.merge(counted[i]);
    }
    Forecast f;
    // No variance at all: nothing is gained by guiding, and the ratio stays 1
    if (all.variance[0] > 0) f.variance_ratio = all.variance[1] / all.variance[0];
    f.guided = f.variance_ratio < kGuidedBelow;
    const bool guided = c.settings.density() == DensityChoice::kGuided ||
                        (c.settings.density() == DensityChoice::kAuto && f.guided);
    // Covariance over variance, pooled over pixels. Clamped like the α of later passes
    if (all.variance_w[guided] > 0)
        f.alpha = std::clamp(all.covariance[guided] / all.variance_w[guided], 0.0, kMostAlpha);
    return f;
}

}  // namespace viscache
