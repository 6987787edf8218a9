#include "viscache/vismap/reflection.h"

#include "viscache/vismap/node_directions.h"

namespace viscache {

SurfaceReflection::SurfaceReflection(const ShadingPoint& p) : glossy_(p.kind == MaterialKind::kGlossy) {
    const bool reflects = glossy_ || p.kind == MaterialKind::kDiffuse;
    const float cos_o = dot(p.ns, p.wo);
    black_ = !reflects || !(cos_o > 0 && dot(p.ng, p.wo) > 0) ||
             !(max_component(p.base) > 0 || (glossy_ && max_component(p.specular) > 0));
    lobe_.ns = p.ns, lobe_.ng = p.ng, lobe_.wo = p.wo;
    // Under a lobe `diffuse_albedo` is the mean over cosines of what grows with 1 − (1 − cos)⁵, 20/21 of it
    lobe_.diffuse = diffuse_albedo(p) * ((glossy_ ? 21.f / 20 : 1.f) / kPi);
    lobe_.f0 = p.specular, lobe_.cos_o = cos_o, lobe_.alpha2 = p.roughness * p.roughness;
    lobe_.outgoing = black_ ? 0.f : smith_g1(cos_o, p.roughness) / (4 * cos_o);
}

void SurfaceReflection::sample(int level, uint32_t first, RgbBlock& out) const {
    const DirectionTable& t = node_centres(level);
    const auto run = glossy_ ? product_kernels().glossy : product_kernels().diffuse;
    run(lobe_, &t.x[first], &t.y[first], &t.z[first], out);
}

void SurfaceReflection::touched(int level, uint32_t first, std::span<uint8_t> touched) const {
    const DirectionTable& t = node_centres(level);
    product_kernels().above(lobe_, &t.x[first], &t.y[first], &t.z[first], &node_radius_sines(level)[first],
                            touched.data(), touched.size());
}

}  // namespace viscache
