#include "viscache/vismap/reflection.h"

#include "viscache/vismap/node_directions.h"

namespace viscache {

void SurfaceReflection::sample(int level, uint32_t first, RgbBlock& out) const {
    const DirectionTable& t = node_centres(level);
    const auto run = lobe_.glossy ? product_kernels().glossy : product_kernels().diffuse;
    run(lobe_, &t.x[first], &t.y[first], &t.z[first], out);
}

void SurfaceReflection::touched(int level, uint32_t first, std::span<uint8_t> touched) const {
    const DirectionTable& t = node_centres(level);
    product_kernels().above(lobe_, &t.x[first], &t.y[first], &t.z[first], &node_radius_sines(level)[first],
                            touched.data(), touched.size());
}

}  // namespace viscache
