#include "viscache/render/scatter.h"

namespace viscache {

namespace {

/// Reflection or refraction of light from one direction.
struct SpecularEvent {
    Vec3 direction;
    Vec3 normal;  ///< normal that was used, on the side where the light arrives
    double probability = 1;
    float eta = 1;       ///< index of the side of arrival over that of the other side; 1: reflected
    Rgb share{1, 1, 1};  ///< of the light
};

/// The event for a direction on either side of the surface. Mirrors use the shading normal, or the geometric
/// normal if the shading normal would reflect below the surface.
std::optional<SpecularEvent> specular_event(const PathVertex& v, Vec3 from, bool through) {
    // The event may be asked for the way back, from the other side: the normals turn with it
    const bool same_side = dot(v.surface.ng, from) >= 0, front = same_side == v.front;
    const Vec3 ng = same_side ? v.surface.ng : -v.surface.ng;
    Vec3 n = same_side ? v.surface.ns : -v.surface.ns;
    // A shading normal that faces away from the ray would reflect it into the surface
    if (dot(n, from) <= 0) n = ng;
    const bool glass = v.surface.kind == MaterialKind::kDielectric;
    ShadingPoint sp = v.surface;
    sp.ns = n;
    sp.wo = from;
    // A sheet reflects as rough surfaces do
    if (v.surface.kind == MaterialKind::kGlossy)
        return SpecularEvent{-from, n, double(pass_share(sp)), 1, glass_shares(sp, dot(n, from)).passed};
    const GlassShares shares =
        glass ? glass_shares(sp, front ? dot(n, from) : -dot(n, from)) : GlassShares{{1, 1, 1}, {}};
    // The probability of reflection is Fresnel's share itself, so the factor of either branch of
    // clear glass is one
    const double fresnel = double(max_component(shares.mirrored));
    // A thin plate does not bend the ray
    if (through && v.surface.thin) return SpecularEvent{-from, n, 1 - fresnel, 1, shares.passed};
    if (through) {
        const float eta = front ? 1 / v.surface.eta : v.surface.eta;
        const auto direction = refract(from, n, eta);
        // Total reflection, or a shading normal that sends the ray back to its own side
        if (!direction || dot(*direction, ng) >= 0) return std::nullopt;
        return SpecularEvent{normalize(*direction), n, 1 - fresnel, eta, shares.passed};
    }
    Vec3 direction = n * (2 * dot(from, n)) - from;
    // Reflected below the true surface: the geometric normal cannot do that
    if (dot(direction, ng) <= 0) {
        n = ng;
        direction = n * (2 * dot(from, n)) - from;
    }
    return SpecularEvent{normalize(direction), n, fresnel, 1, shares.mirrored};
}

std::optional<Scatter> scatter_specular(const PathVertex& v, Transport transport, Rng& rng) {
    // Within 2.6 degrees: what is told apart is another event, not rounding
    constexpr float kSameDirection = 0.999f;
    const bool glass = v.surface.kind == MaterialKind::kDielectric;
    const Vec3 from = v.surface.wo;
    const bool sheet = v.surface.kind == MaterialKind::kGlossy;
    auto event = specular_event(v, from, sheet);
    const bool through = sheet || (glass && double(rng.next()) >= event->probability);
    if (through && !sheet) event = specular_event(v, from, true);
    // The rest of the energy is lost here, as in paths from the eye
    if (!event || !(event->probability > 0)) return std::nullopt;
    Scatter s;
    s.specular = true;
    s.direction = event->direction;
    s.pdf = event->probability;
    // The next ray starts on the side to which it leaves
    s.side = through ? -v.surface.ng : v.surface.ng;
    // With replaced normals the way back can be another event
    const auto back = specular_event(v, s.direction, through);
    if (back && dot(back->direction, from) > kSameDirection) s.pdf_back = back->probability;
    s.factor =
        // Clear glass divides its share by the probability of the event, which is the same number
        glass || sheet
            ? event->share / float(event->probability)
            : mirror_reflectance(v.surface.specular, v.surface.metal, std::fabs(dot(v.surface.ns, from)));
    if (transport == Transport::kImportance)
        // Light paths: cosines of shading normals do not cancel (Veach 1997, Sec. 5.3). Radiance,
        // but not importance, is compressed by η²
        s.factor = s.factor * adjoint(event->normal, v.surface.ng, from, s.direction);
    else
        s.factor = s.factor * (event->eta * event->eta);  // the change of index compresses radiance
    return s;
}

std::optional<Scatter> scatter_rough(const PathVertex& v, Transport transport, Rng& rng) {
    const ShadingPoint sp = shading_from(v, v.surface.wo);
    if (is_black(sp)) return std::nullopt;
    // One number chooses the lobe, two choose the direction in it
    const float u_lobe = rng.next();
    const auto drawn = sample_bsdf(sp, u_lobe, rng.next2());
    if (!drawn || !(drawn->pdf > 0)) return std::nullopt;
    Scatter s;
    s.direction = drawn->wi;
    s.side = sp.ng;
    // A path that does not pass a sheet
    const float rest = 1 - pass_share(sp);
    s.pdf = double(drawn->pdf * rest);
    // Density of the same edge walked the other way, which the weights of all strategies need
    s.pdf_back = scatter_pdf(v, drawn->wi, sp.wo);
    s.factor = drawn->weight / rest;
    if (transport == Transport::kImportance)
        s.factor =
            // For light paths the roles of the two directions change: the eye lies where the path
            // goes on
            reflected(v, drawn->wi, sp.wo) *
            (dot(sp.ng, drawn->wi) / (dot(sp.ng, sp.wo) * drawn->pdf * rest));
    return s;
}

}  // namespace

std::optional<Scatter> scatter(const PathVertex& v, Transport transport, Rng& rng) {
    std::optional<Scatter> s;
    switch (v.surface.kind) {
        case MaterialKind::kDiffuse:
        case MaterialKind::kGlossy: {
            const float pass = v.surface.thin ? pass_share(shading_from(v, v.surface.wo)) : 0.f;
            s = pass > 0 && rng.next() < pass ? scatter_specular(v, transport, rng)
                                              : scatter_rough(v, transport, rng);
            break;
        }
        case MaterialKind::kMirror:
        case MaterialKind::kDielectric: s = scatter_specular(v, transport, rng); break;
    }
    // A path that carries nothing, or no number, ends
    if (!s || !is_finite(s->direction) || !is_finite(s->factor) || !(max_component(s->factor) > 0))
        return std::nullopt;
    return s;
}

}  // namespace viscache
