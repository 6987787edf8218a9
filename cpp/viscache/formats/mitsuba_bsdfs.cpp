// Mitsuba XML: converts surface models to the nearest material.
#include "viscache/formats/mitsuba_reader.h"
#include "viscache/scene/coat.h"

namespace viscache::loading {

namespace {

constexpr Rgb kGrey{.5f, .5f, .5f};

bool is_bsdf(pugi::xml_node node) { return std::string_view(node.name()) == "bsdf"; }

}  // namespace

void MitsubaReader::set_base(Material& m, const ColorTexture& base) {
    m.base_color = clamp01(base.color);
    m.base_texture = base.image;
    attribute_ = base.attribute;
}

/// Microfacets are GGX's or Beckmann's, which Mitsuba takes by default; warns of others.
bool MitsubaReader::is_beckmann(Node node) {
    const std::string wanted = lower(string(node, "distribution", "beckmann"));
    if (wanted != "ggx" && wanted != "beckmann")
        warn_at(node, "the distribution of microfacets '" + wanted + "' is not modelled; GGX's is used");
    return wanted == "beckmann";
}

float MitsubaReader::roughness(Node node, double fallback) {
    // The geometric mean keeps the area of the highlight: α_u·α_v is a factor of both distributions.
    if (property(node, "alpha_u") || property(node, "alpha_v")) {
        const double u = number(node, "alpha_u", 0.1), v = number(node, "alpha_v", 0.1);
        if (u != v) warn_at(node, "anisotropic roughness is not modelled; the geometric mean is used");
        return clamp_roughness(float(std::sqrt(std::max(0.0, u * v))));
    }
    return clamp_roughness(float(number(node, "alpha", fallback)));
}

double MitsubaReader::ior(Node owner, const char* name, double fallback) {
    const Node node = property(owner, name);
    if (!node) return fallback;
    // Media may be named ("bk7", "water") or given as numbers.
    const std::string value = attribute(node, "value");
    if (const auto known = ior_named(lower(value))) return *known;
    if (std::string_view(node.name()) == "string") {
        warn_at(node,
                "the medium '" + value + "' is not known; index " + std::to_string(fallback) + " is used");
        return fallback;
    }
    const double x = number(owner, name, fallback);
    if (!(x > 0)) fail_at(node, "an index of refraction must be > 0");
    return x;
}

/// plastic, roughplastic: a diffuse base under a dielectric coating.
Material MitsubaReader::plastic(Node node, int /*depth*/) {
    const bool rough = type_of(node) == "roughplastic";
    Material m;
    m.kind = MaterialKind::kGlossy;
    m.coat = rough ? CoatKind::kRough : CoatKind::kSmooth;
    if (rough && is_beckmann(node)) m.coat = CoatKind::kBeckmann;
    m.nonlinear = boolean(node, "nonlinear", false);
    m.two_sided = false;
    set_base(m, color_texture(node, "diffuse_reflectance", kGrey, true));
    m.specular = clamp01(color(node, "specular_reflectance", {1, 1, 1}));
    // Mitsuba's defaults: polypropylene in air.
    m.eta = float(ior(node, "int_ior", 1.49) / ior(node, "ext_ior", 1.000277));
    m.beckmann = !rough;  // without the long tails of GGX
    m.roughness = rough ? roughness(node, 0.1) : kMirrorRoughness;
    return m;
}

/// Sets a roughness that may have an image.
void MitsubaReader::set_roughness(Material& m, Node node) {
    const ColorTexture alpha = color_texture(node, "alpha", {.1f, .1f, .1f});
    m.roughness_texture = alpha.image;
    m.roughness = alpha.image >= 0 ? clamp_roughness(luminance(alpha.color)) : roughness(node, 0.1);
}

Material MitsubaReader::conductor(Node node, int /*depth*/) {
    const bool rough = type_of(node) == "roughconductor";
    Material m;
    m.two_sided = false;
    m.beckmann = rough && is_beckmann(node);
    m.kind = rough ? MaterialKind::kGlossy : MaterialKind::kMirror;
    m.base_color = {0, 0, 0};
    if (rough) set_roughness(m, node);
    // Without any material, Mitsuba 0.x takes copper and later versions a perfect mirror.
    const std::string name =
        string(node, "material", version_major_ >= 2 && !property(node, "eta") ? "none" : "Cu");
    auto ior = conductor_named(name);
    if (!ior) {
        warn_at(node, "the conductor '" + name + "' is not known; a perfect mirror is used");
        ior = conductor_named("none");
    }
    // Explicit indices replace those of a named metal one by one.
    if (property(node, "eta")) ior->eta = color(node, "eta", {0, 0, 0});
    if (property(node, "k")) ior->k = color(node, "k", {1, 1, 1});
    const float outside = float(this->ior(node, "ext_eta", 1.0));
    m.specular = clamp01(color(node, "specular_reflectance", {1, 1, 1}));
    set_metal(m, ior->eta / outside, ior->k / outside);
    return m;
}

Material MitsubaReader::dielectric(Node node, int /*depth*/) {
    const std::string type = type_of(node);
    Material m;
    m.kind = MaterialKind::kDielectric;
    m.thin = type == "thindielectric";
    // Mitsuba's defaults: BK7 glass in air.
    m.eta = float(ior(node, "int_ior", 1.5046) / ior(node, "ext_ior", 1.000277));
    for (const char* name : {"specular_reflectance", "specular_transmittance"})
        if (const Node given = property(node, name); given && !(color(node, name, {1, 1, 1}) == Rgb{1, 1, 1}))
            warn_at(given, "a factor of what glass reflects or transmits is not modelled; 1 is used");
    if (type == "roughdielectric") skip(node, "'roughdielectric' is not modelled; smooth glass is used");
    return m;
}

Material MitsubaReader::principled(Node node, int /*depth*/) {
    Material m;
    m.kind = MaterialKind::kGlossy;
    const ColorTexture base = color_texture(node, "base_color", kGrey, true);
    const float metallic = std::clamp(float(number(node, "metallic", 0)), 0.f, 1.f);
    // Burley's model: `specular` in [0, 1] spans reflectances of 0 to 8 % at normal incidence, and α is the
    // square of the roughness.
    const float specular = 0.08f * float(number(node, "specular", 0.5)),
                r = float(number(node, "roughness", 0.5));
    set_base(m, {base.color * (1 - metallic), base.image, base.attribute});
    m.specular = clamp01(Rgb{specular, specular, specular} * (1 - metallic) + base.color * metallic);
    m.roughness = clamp_roughness(r * r);
    if (number(node, "spec_trans", 0) > 0.5) {
        m = Material{};
        m.kind = MaterialKind::kDielectric;
        m.eta = float(ior(node, "eta", 1.5));
    }
    skip(node,
         "'principled' is not modelled in full; base colour, metallic, specular and roughness are kept");
    return m;
}

/// The bsdf that an element is or refers to.
MitsubaReader::Node MitsubaReader::bsdf_of(Node child) const {
    const bool is_ref = std::string_view(child.name()) == "ref";
    const Node found = is_ref ? target_of(child) : child;
    if (!is_bsdf(found)) return {};
    use(child);
    return found;
}

Material MitsubaReader::nested(Node node, int depth) {
    for (const Node child : node.children())
        // References may be cyclic; `bsdf` stops at its limit of depth.
        if (const Node found = bsdf_of(child)) return bsdf(found, depth + 1);
    fail_at(node, "'" + type_of(node) + "' needs a bsdf inside");
}

Material MitsubaReader::mask(Node node, int depth) {
    Material m = nested(node, depth);
    const ColorTexture opacity = color_texture(node, "opacity", kGrey);
    m.alpha_texture = opacity.image;
    m.alpha_cutoff = -1;  // greys are shares
    if (opacity.image < 0) m.opacity = std::clamp(luminance(opacity.color), 0.f, 1.f);
    return m;
}

Material MitsubaReader::two_sided(Node node, int depth) {
    Material m = nested(node, depth);
    m.two_sided = true;
    const auto inside = [](Node c) { return is_bsdf(c) || std::string_view(c.name()) == "ref"; };
    if (std::count_if(node.children().begin(), node.children().end(), inside) > 1)
        skip(node, "a bsdf of its own for the back is not modelled; the first is used for both sides");
    return m;
}

Material MitsubaReader::diffuse(Node node, int /*depth*/) {
    const std::string type = type_of(node);
    Material m;
    m.two_sided = type == "difftrans";
    const char* const name = type == "difftrans"             ? "transmittance"
                             : property(node, "reflectance") ? "reflectance"
                                                             : "diffuse_reflectance";  // of 0.x
    set_base(m, color_texture(node, name, kGrey, true));
    if (type == "roughdiffuse") skip(node, "'roughdiffuse' is not modelled; smooth diffuse is used");
    if (type == "difftrans") skip(node, "'difftrans' is not modelled; diffuse reflection is used");
    return m;
}

/// phong, ward: a lobe beside a diffuse base.
Material MitsubaReader::phong(Node node, int /*depth*/) {
    Material m;
    m.two_sided = false;
    m.kind = MaterialKind::kGlossy;
    set_base(m, color_texture(node, "diffuse_reflectance", kGrey, true));
    m.specular = clamp01(color(node, "specular_reflectance", {.2f, .2f, .2f}));
    const double exponent = std::max(0.0, number(node, "exponent", 30));
    // The Beckmann roughness whose lobe has the width of a Phong lobe of this exponent (Walter et al. 2007).
    m.roughness = type_of(node) == "phong" ? clamp_roughness(float(std::sqrt(2 / (exponent + 2))))
                                           : roughness(node, 0.1);
    return m;
}

/// Of layers and mixtures, which are not modelled, the first part.
Material MitsubaReader::first_inside(Node node, int depth) {
    const Material m = nested(node, depth);
    skip(node, "'" + type_of(node) + "' is not modelled; the first bsdf inside is used");
    return m;
}

Material MitsubaReader::bsdf(Node node, int depth) {
    using Reader = MitsubaReader;
    // clang-format off
    static constexpr std::pair<std::string_view, ReadBsdf Reader::*> kTypes[] = {
        {"twosided", &Reader::two_sided}, {"mask", &Reader::mask},
        {"diffuse", &Reader::diffuse}, {"lambertian", &Reader::diffuse},
        {"roughdiffuse", &Reader::diffuse}, {"difftrans", &Reader::diffuse},
        {"plastic", &Reader::plastic}, {"roughplastic", &Reader::plastic},
        {"phong", &Reader::phong}, {"ward", &Reader::phong},
        {"conductor", &Reader::conductor}, {"roughconductor", &Reader::conductor},
        {"dielectric", &Reader::dielectric}, {"roughdielectric", &Reader::dielectric},
        {"thindielectric", &Reader::dielectric},
        {"principled", &Reader::principled}, {"principledthin", &Reader::principled},
        {"bumpmap", &Reader::first_inside}, {"normalmap", &Reader::first_inside},
        {"coating", &Reader::first_inside}, {"roughcoating", &Reader::first_inside},
        {"mixturebsdf", &Reader::first_inside}, {"blendbsdf", &Reader::first_inside},
    };
    // clang-format on
    if (depth > kMaxDepth) fail_at(node, "bsdfs are nested too deeply, or refer to themselves");
    const std::string type = type_of(node);
    use(node);
    for (const auto& [name, read] : kTypes)
        if (name == type) return (this->*read)(node, depth);
    skip(node, "bsdf '" + type + "' is not modelled; grey diffuse is used");
    return {};
}

int MitsubaReader::material(Node node) {
    // An element that many shapes refer to is converted once, and its warnings appear once.
    const auto [found, is_new] = materials_.try_emplace(node.hash_value(), -1);
    if (is_new && type_of(node) != "null") {
        MaterialUv uv;
        uv_ = &uv;
        attribute_.clear();
        found->second = loading_.add_material(bsdf(node, 0));
        uv_ = nullptr;
        // Images of a material share the transform that is applied to the meshes that use it.
        material_uv_[found->second] = uv.get();
        material_attribute_[found->second] = attribute_;
    }
    return found->second;
}

int MitsubaReader::material_of(Node shape) {
    for (const Node child : shape.children())
        if (const Node found = bsdf_of(child)) return material(found);
    // Mitsuba's own default: a one-sided grey material, a black one for lamps.
    const bool emits = max_component(area_emission(shape).color) > 0;
    // The hash value of an element is its address, so 0 and 1 are free as keys.
    const auto [found, is_new] = materials_.try_emplace(emits ? 1 : 0, -1);
    if (is_new) {
        Material m;
        m.two_sided = false;
        if (emits) m.base_color = {0, 0, 0};
        found->second = loading_.add_material(m);
    }
    return found->second;
}

}  // namespace viscache::loading
