// pbrt-v4 text: its own directives and materials. The reader accepts the words of both versions.
#include "viscache/formats/pbrt_reader.h"
#include "viscache/scene/coat.h"

namespace viscache::loading {

namespace {

constexpr float kSmooth = 1e-3f;  ///< pbrt takes surfaces of smaller alpha for smooth

}  // namespace

bool PbrtReader::v4_directive(const PbrtToken& token) {
    const std::string_view name = token.text;
    const std::string where = token.where();
    if (name == "ColorSpace") {
        if (const std::string space = name_argument(); space != "srgb")
            loading_.warn(where, "the colour space '" + space + "' is not modelled; sRGB is used");
    } else if (name == "Attribute") {
        const std::string target = name_argument();
        auto changed = std::make_shared<std::map<std::string, PbrtParams>>(*now_.defaults);
        PbrtParams given = PbrtParams::read(tokens_);
        const PbrtParams::List own = given.own();
        defaults_.insert(defaults_.end(), own.begin(), own.end());
        given.append((*changed)[target]);
        // Each directive looks through all of them
        if (given.size() > 1000) fail(where, "more than 1,000 parameters are set for '" + target + "'");
        (*changed)[target] = given;
        now_.defaults = changed;
    } else if (name == "Import") {
        const PbrtToken file = tokens_.expect(PbrtToken::kString, "a file name in quotes");
        tokens_.push(path_named(std::string(file.text), file.where()), file.where());
    } else {
        return false;
    }
    is_v4_ = true;
    return true;
}

void PbrtReader::option(const Names&, const PbrtParams& params, const std::string&) {
    is_v4_ = true;
    // Settings of the rendering, which the other directives do not repeat
    params.ignore({"disablepixeljitter", "disablewavelengthjitter", "disabletexturefiltering",
                   "displacementedgescale", "msereferenceimage", "msereferenceout", "pixelstats",
                   "rendercoordsys", "seed", "wavefront"});
}

/// The parameters of a directive, after them those that Attribute sets for this kind of directive.
PbrtParams PbrtReader::params_of(const std::string& kind) {
    PbrtParams params = PbrtParams::read(tokens_);
    const auto found = now_.defaults->find(kind);
    if (!kind.empty() && found != now_.defaults->end()) params.append(found->second);
    return params;
}

bool PbrtReader::is_v4_material(const std::string& type) {
    static const std::string names[] = {
        "diffuse",        "coateddiffuse",       "conductor", "coatedconductor", "dielectric",
        "thindielectric", "diffusetransmission", "interface", "measured"};
    return std::find(std::begin(names), std::end(names), type) != std::end(names);
}

/// GGX's alpha. pbrt-v4 takes the root where v3 takes a polynomial.
float PbrtReader::v4_alpha(const PbrtParams& params, const std::string& prefix, double fallback) {
    const double r = plain_number(params, prefix + "roughness", fallback);
    const double mean = isotropic(params, plain_number(params, prefix + "uroughness", r),
                                  plain_number(params, prefix + "vroughness", r));
    return float(params.boolean("remaproughness", true) ? std::sqrt(mean) : mean);
}

/// Index of refraction: a number, or the mean of a spectrum.
float PbrtReader::v4_eta(const PbrtParams& params, const char* name, double fallback,
                         const std::string& where) {
    const float eta = luminance(color(params, name, Rgb{1, 1, 1} * float(fallback)));
    if (!(eta > 0)) fail(where, "an index of refraction must be > 0");
    return eta;
}

/// conductor, and coatedconductor without its coat.
Material PbrtReader::v4_conductor(const PbrtParams& params, const std::string& prefix) {
    Material m;
    m.base_color = kZero;
    m.kind = MaterialKind::kGlossy;
    if (params.has("reflectance")) {
        // The k at which a metal of η = 1 reflects so much at normal incidence
        const Rgb r = min(kOne * 0.9999f, color(params, "reflectance", kHalf));
        const auto k = [](float x) { return 2 * std::sqrt(std::max(0.f, x) / (1 - x)); };
        set_metal(m, kOne, {k(r.x), k(r.y), k(r.z)});
    } else {
        const Conductor copper = *conductor_named("Cu");
        set_metal(m, color(params, (prefix + "eta").c_str(), copper.eta),
                  color(params, (prefix + "k").c_str(), copper.k));
    }
    if (roughness_image(m, params, prefix + "roughness")) return m;
    const float alpha = v4_alpha(params, prefix, 0);
    if (alpha < kSmooth) m.kind = MaterialKind::kMirror;
    m.roughness = clamp_roughness(alpha);
    return m;
}

/// coateddiffuse: a diffuse base under a dielectric. pbrt follows light between the two by random walks; the
/// closed form of their sum is that of Mitsuba's plastics.
Material PbrtReader::v4_coated_diffuse(const PbrtParams& params, const std::string& where) {
    Material m;
    m.kind = MaterialKind::kGlossy;
    const PbrtTexture base = color_texture(params, "reflectance", kHalf);
    m.base_color = clamp01(base.color);
    m.base_texture = base.image;
    m.eta = v4_eta(params, "eta", 1.5, where);
    const float alpha = v4_alpha(params, "", 0);
    m.coat = alpha < kSmooth ? CoatKind::kSmooth : CoatKind::kRough;
    m.beckmann = alpha < kSmooth;
    m.roughness = alpha < kSmooth ? kMirrorRoughness : clamp_roughness(alpha);
    m.nonlinear = true;
    // Without scattering inside, neither its phase function nor the thickness of the coat matters; the walks
    // are pbrt's way to compute the sum
    params.ignore({"maxdepth", "nsamples", "thickness", "g"});
    if (max_component(color(params, "albedo", kZero)) > 0)
        loading_.warn(where, "the medium inside of a coat is not modelled; ignored");
    return m;
}

/// The nearest material for one of pbrt-v4.
Material PbrtReader::v4_surface(const std::string& type, const PbrtParams& params, const std::string& where) {
    Material m;
    if (type == "diffuse" || type == "diffusetransmission") {
        const PbrtTexture base = color_texture(params, "reflectance", type == "diffuse" ? kHalf : kQuarter);
        m.base_color = clamp01(base.color);
        m.base_texture = base.image;
        if (type != "diffuse") {
            params.ignore({"transmittance", "scale"});
            loading_.warn(where, "material '" + type + "' is not modelled; diffuse reflection is used");
        }
    } else if (type == "coateddiffuse") {
        m = v4_coated_diffuse(params, where);
    } else if (type == "conductor") {
        m = v4_conductor(params, "");
    } else if (type == "coatedconductor") {
        m = v4_conductor(params, "conductor.");
        params.ignore({"interface.roughness", "interface.uroughness", "interface.vroughness", "interface.eta",
                       "thickness", "albedo", "g", "maxdepth", "nsamples"});
        loading_.warn(where, "the coat of 'coatedconductor' is not modelled; the conductor alone is used");
    } else if (type == "dielectric") {
        m.kind = MaterialKind::kDielectric;
        m.eta = v4_eta(params, "eta", 1.5, where);
        if (v4_alpha(params, "", 0) >= kSmooth)
            loading_.warn(where, "rough glass is not modelled; smooth glass is used");
    } else if (type == "thindielectric") {
        m.kind = MaterialKind::kDielectric;
        m.eta = v4_eta(params, "eta", 1.5, where);
        m.thin = true;
    } else {
        params.ignore_all();
        loading_.warn(where, "material '" + type + "' is not modelled; grey diffuse is used");
    }
    return m;
}

namespace {

/// "metal-Cu-eta" and the like.
std::optional<Rgb> metal_named(const std::string& name) {
    const size_t dash = name.rfind('-');
    if (!name.starts_with("metal-") || dash < 6) return {};
    const auto ior = conductor_named(name.substr(6, dash - 6));
    const std::string what = name.substr(dash + 1);
    if (!ior || (what != "eta" && what != "k")) return {};
    return what == "eta" ? ior->eta : ior->k;
}

}  // namespace

/// A spectrum that pbrt-v4 knows by its name.
std::optional<Rgb> PbrtReader::named_spectrum(const std::string& name) {
    // Indices of refraction at 587.6 nm, from the makers' data sheets
    static const std::pair<const char*, float> glasses[] = {
        {"glass-BK7", 1.5168f}, {"glass-BAF10", 1.6700f}, {"glass-FK51A", 1.4866f}, {"glass-LASF9", 1.8502f},
        {"glass-F5", 1.6034f},  {"glass-SF10", 1.7283f},  {"glass-SF11", 1.7847f}};
    for (const auto& [known, eta] : glasses)
        if (name == known) return kOne * eta;
    if (const auto metal = metal_named(name)) return metal;
    if (name == "stdillum-D65") return kOne;
    if (name == "stdillum-A") {
        const Rgb lamp = blackbody_rgb(2856);
        return lamp / luminance(lamp);
    }
    return {};
}

}  // namespace viscache::loading
