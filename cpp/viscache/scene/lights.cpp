#include "viscache/scene/lights.h"

#include "viscache/scene/scene.h"

namespace viscache {

namespace {

constexpr float kMostRows = 1024;

float texels_between(Vec2 a, Vec2 b, const Image& image) {
    return std::max(std::fabs(a.x - b.x) * float(image.width), std::fabs(a.y - b.y) * float(image.height));
}

}  // namespace

Rgb image_radiance(const EmissiveImage& p, Vec2 w) {
    const float first = 1 - w.x - w.y;
    return p.scale * sample_image(*p.image, {p.uv[0].x * first + p.uv[1].x * w.x + p.uv[2].x * w.y,
                                             p.uv[0].y * first + p.uv[1].y * w.x + p.uv[2].y * w.y})
                         .rgb;
}

Rgb mean_radiance(const EmissiveImage& p, size_t most_samples) {
    const float longest =
        std::max({texels_between(p.uv[0], p.uv[1], *p.image), texels_between(p.uv[1], p.uv[2], *p.image),
                  texels_between(p.uv[2], p.uv[0], *p.image)});
    const float limit = std::min(kMostRows, std::max(1.f, std::floor(std::sqrt(float(most_samples)))));
    const bool coarse = !(longest <= limit);
    const int rows = std::max(1, int(std::ceil(coarse ? limit : longest)));
    // The centroids of rows² equal triangles; those that point down follow the others of their row
    double sum[3] = {};
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < 2 * (rows - i) - 1; ++j) {
            const bool down = j >= rows - i;
            const float x = float(i) + (down ? 2.f / 3 : 1.f / 3);
            const float y = float(down ? j - (rows - i) : j) + (down ? 2.f / 3 : 1.f / 3);
            const Rgb radiance = image_radiance(p, {x / float(rows), y / float(rows)});
            sum[0] += radiance.x;
            sum[1] += radiance.y;
            sum[2] += radiance.z;
        }
    const double count = double(rows) * rows;
    const Rgb mean{float(sum[0] / count), float(sum[1] / count), float(sum[2] / count)};
    // Samples may miss bright texels. The triangle must keep a chance to be chosen
    return coarse && !(max_component(mean) > 0) ? p.scale * 1e-3f : mean;
}

}  // namespace viscache
