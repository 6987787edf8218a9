#include "viscache/render/mean_light.h"

#include <cmath>

#include "viscache/render/glossy_sums.h"

namespace viscache {

namespace {

/// Pixels of the small picture.
/// Enough for a mean that only scales the shares of corrections; few against the pixels of a frame.
constexpr double kPixels = 1024;

}  // namespace

float reflected_row(const SharedLights& lights, const EyeTile& eyes, size_t eye, ColumnRange range,
                    const Word* wanted, std::vector<float>& row) {
    const ShadingPoint& sp = eyes.shading[eye];
    // Lobes need a kernel of their own, because a contribution under one depends on the direction
    const EyeShade shade{eyes.block.position[eye], sp.ng, sp.ns};
    return has_lobe(sp) ? contribution_row_glossy(lights, shade, sp, wanted, row)
                        : contribution_row(lights, shade, range, row);
}

float to_pixel(const EyeTile& eyes, size_t eye) {
    const ShadingPoint& sp = eyes.shading[eye];
    // Contributions under a lobe have the reflection already; of a diffuse surface they are
    // irradiance, to which base/π is missing
    const Rgb to = has_lobe(sp) ? eyes.throughput[eye] : eyes.throughput[eye] * (sp.base * (1 / kPi));
    // A third for the mean of these channels, and a third because contributions are sums of three
    return (to.x + to.y + to.z) / 9;
}

void set_mean_light(std::span<SharedLights> groups, const EyePathTracer& tracer, Counters& counters,
                    const Control& control) {
    // The same view at a lower resolution. Its first sample is fixed, so that all parts of a
    // picture, and frames that go on from it, get the same mean
    EyePathTracer small = tracer;
    const double pixels = double(tracer.frame.width) * tracer.frame.height;
    // Both edges shrink alike; a picture that is small already is taken as it is
    const double scale = std::min(1.0, std::sqrt(kPixels / pixels));
    small.frame.width = int(std::ceil(tracer.frame.width * scale));
    small.frame.height = int(std::ceil(tracer.frame.height * scale));
    small.frame.spp = 1;
    small.frame.first_sample = 0;
    // A film has its resolution inside, so the small one needs its own
    small.film = FilmCamera(tracer.film.camera, small.frame.width, small.frame.height);
    EyeTile eyes;
    small.trace({0, 0, small.frame.width, small.frame.height}, eyes, counters, control);
    std::vector<float> row;
    std::vector<Word> wanted;
    for (SharedLights& lights : groups) {
        double sum = 0;
        for (size_t i = 0; i < eyes.size(); ++i) {
            const ShadingPoint& sp = eyes.shading[i];
            const ColumnRange range = lights.ends.columns_of(eyes.block, i);
            wanted.assign(row_words_for(lights.ends.count), 0);
            // Lobes are computed for wanted columns alone, as in the frame
            wanted_row(lights, {eyes.block.position[i], sp.ng, sp.ns}, range, wanted.data());
            reflected_row(lights, eyes, i, range, wanted.data(), row);
            // In double, because thousands of lights may be orders of magnitude apart
            double light = 0;
            for (size_t k = range.first; k < range.last; ++k) light += row[k];
            sum += light * to_pixel(eyes, i);
        }
        // Per pixel of the picture, not per eye point: pixels without a surface count as dark
        lights.mean_light = float(sum / (double(small.frame.width) * small.frame.height));
    }
}

}  // namespace viscache
