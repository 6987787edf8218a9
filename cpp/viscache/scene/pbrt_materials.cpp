// pbrt-v3 text: converts colours, textures and materials to the nearest material.
#include "viscache/scene/pbrt_reader.h"

namespace viscache::loading {

namespace {

constexpr Rgb kHalf{.5f, .5f, .5f}, kQuarter{.25f, .25f, .25f}, kOne{1, 1, 1}, kZero{0, 0, 0};

/// pbrt's RoughnessToAlpha for `remaproughness`.
double roughness_to_alpha(double roughness) {
    const double x = std::log(std::max(roughness, 1e-3));
    return 1.62142 + 0.819955 * x + 0.1734 * x * x + 0.0171201 * x * x * x + 0.000640711 * x * x * x * x;
}

Spectrum spectrum_from(const std::vector<double>& v, const std::string& where) {
    if (v.size() < 2 || v.size() % 2) fail(where, "a spectrum must be pairs of wavelength and value");
    Spectrum s;
    for (size_t i = 0; i < v.size(); i += 2) {
        if (!std::isfinite(v[i]) || !std::isfinite(v[i + 1])) fail(where, "a spectrum must be finite");
        if (!s.empty() && v[i] <= s.back().first) fail(where, "the wavelengths of a spectrum must grow");
        s.emplace_back(v[i], v[i + 1]);
    }
    return s;
}

/// pbrt scales black bodies to a peak of 1.
Rgb normalised_blackbody(double kelvin) {
    constexpr double h = 6.62607015e-34, c = 299792458.0, wien = 2.897771955e-3;
    const double peak_m = wien / kelvin;
    const double peak = 2 * h * c * c / (std::pow(peak_m, 5) * std::expm1(4.965114231744276)) * 1e-9;
    return blackbody_rgb(kelvin) / float(peak);
}

}  // namespace

Rgb PbrtReader::spectrum_file(const PbrtParam& p) {
    if (p.strings.size() != 1) fail(p.where, "one spectrum file must be named");
    std::string text = read_file(path_named(p.strings[0], p.where), p.where);
    std::vector<double> values;
    for (size_t i = 0; (i = text.find_first_not_of(" \t\r\n,", i)) != std::string::npos;) {
        const size_t end = std::min(text.find_first_of(text[i] == '#' ? "\n" : " \t\r\n,", i), text.size());
        if (text[i] != '#') {
            const auto x = parse_number(std::string_view(text).substr(i, end - i));
            if (!x)
                fail(p.where,
                     "the spectrum file '" + p.strings[0] + "' holds something that is not a number");
            values.push_back(*x);
        }
        i = end;
    }
    return spectrum_to_rgb(spectrum_from(values, p.where));
}

std::optional<Rgb> PbrtReader::color_of(const PbrtParam& p) {
    const auto& v = p.numbers;
    Rgb c{};
    if (p.type == "rgb" || p.type == "color" || p.type == "xyz") {
        if (v.size() != 3) fail(p.where, "'" + p.name + "' must be three numbers");
        c = {float(v[0]), float(v[1]), float(v[2])};
        if (p.type == "xyz")
            c = {3.2404542f * c.x - 1.5371385f * c.y - 0.4985314f * c.z,
                 -0.9692660f * c.x + 1.8760108f * c.y + 0.0415560f * c.z,
                 0.0556434f * c.x - 0.2040259f * c.y + 1.0572252f * c.z};
    } else if (p.type == "spectrum") {
        c = p.strings.empty() ? spectrum_to_rgb(spectrum_from(v, p.where)) : spectrum_file(p);
    } else if (p.type == "blackbody") {
        if (v.empty() || v.size() > 2 || !(v[0] > 0))
            fail(p.where, "a black body must be a temperature > 0 and a scale");
        c = normalised_blackbody(v[0]) * float(v.size() == 2 ? v[1] : 1);
    } else if (p.type == "float") {
        if (v.size() != 1) fail(p.where, "'" + p.name + "' must be one number");
        c = {float(v[0]), float(v[0]), float(v[0])};
    } else {
        return {};
    }
    if (!is_finite(c)) fail(p.where, "'" + p.name + "' is not finite");
    return max(kZero, c);
}

PbrtTexture PbrtReader::color_texture(const PbrtParams& params, const char* name, Rgb fallback) {
    const PbrtParam* p = params.find(name);
    if (!p) return {fallback};
    if (const auto c = color_of(*p)) return {*c};
    if (p->type != "texture" || p->strings.size() != 1)
        fail(p->where, std::string("'") + name + "' must be a colour or a texture");
    const auto found = now_.textures->find(p->strings[0]);
    if (found != now_.textures->end()) return found->second;
    loading_.warn(p->where, "the texture '" + p->strings[0] + "' is not defined; the default is used");
    return {fallback};
}

Rgb PbrtReader::color(const PbrtParams& params, const char* name, Rgb fallback) {
    const PbrtTexture t = color_texture(params, name, fallback);
    if (t.image >= 0)
        loading_.warn(params.find(name)->where,
                      std::string("an image for '") + name + "' is not modelled; white is used");
    return t.color;
}

void PbrtReader::texture(const std::string& where) {
    const std::string name = name_argument();
    name_argument();  // type: float or spectrum
    const std::string type = name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    PbrtTexture t;
    if (type == "imagemap") {
        const PbrtParam* file = params.find("filename");
        if (!file) fail(where, "an imagemap needs a filename");
        const std::string path = path_named(params.string("filename", ""), file->where);
        t.image = loading_.add_image(path, file->where, params.boolean("gamma", true));
        const float scale = float(params.number("scale", 1));
        t.color = {scale, scale, scale};
        if (params.number("uscale", 1) != 1 || params.number("vscale", 1) != 1 ||
            params.number("udelta", 0) != 0 || params.number("vdelta", 0) != 0 ||
            params.string("mapping", "uv") != "uv")
            loading_.warn(where, "a mapping of texture coordinates is not modelled; ignored");
    } else if (type == "constant") {
        t.color = color(params, "value", kOne);
    } else if (type == "scale") {
        const PbrtTexture a = color_texture(params, "tex1", kOne), b = color_texture(params, "tex2", kOne);
        t = {a.color * b.color, a.image >= 0 ? a.image : b.image};
        if (a.image >= 0 && b.image >= 0)
            loading_.warn(where, "the product of two images is not modelled; the first is used");
    } else {
        loading_.warn(where, "texture '" + type + "' is not modelled; grey is used");
        t.color = kHalf;
    }
    auto changed = std::make_shared<std::map<std::string, PbrtTexture>>(*now_.textures);
    (*changed)[name] = t;
    now_.textures = changed;
}

float PbrtReader::roughness(const PbrtParams& params, double fallback) {
    double r = params.number("roughness", fallback);
    const double u = params.number("uroughness", r), v = params.number("vroughness", r);
    r = std::sqrt(std::max(0.0, u) * std::max(0.0, v));
    return clamp_roughness(float(params.boolean("remaproughness", true) ? roughness_to_alpha(r) : r));
}

Material PbrtReader::metal(const PbrtParams& params) {
    Material m;
    const ConductorIor copper = *conductor_named("Cu");
    const Rgb eta = color(params, "eta", copper.eta), k = color(params, "k", copper.k);
    m.kind = MaterialKind::kGlossy;
    m.base_color = kZero;
    m.specular = {conductor_f0(eta.x, k.x), conductor_f0(eta.y, k.y), conductor_f0(eta.z, k.z)};
    m.roughness = roughness(params, 0.01);
    return m;
}

/// plastic, uber, substrate, disney: a diffuse base under a glossy lobe.
Material PbrtReader::coated(const std::string& type, const PbrtParams& params, const std::string& where) {
    Material m;
    m.kind = MaterialKind::kGlossy;
    const bool quarter = type == "plastic" || type == "uber";
    PbrtTexture base = color_texture(params, type == "disney" ? "color" : "Kd", quarter ? kQuarter : kHalf);
    if (type == "disney") {
        const float metallic = std::clamp(float(params.number("metallic", 0)), 0.f, 1.f);
        m.specular = clamp01(Rgb{.04f, .04f, .04f} * (1 - metallic) + base.color * metallic);
        base.color = base.color * (1 - metallic);
        const double r = params.number("roughness", 0.5);
        m.roughness = clamp_roughness(float(r * r));
    } else {
        const Rgb ks = color(params, "Ks", quarter ? kQuarter : kHalf);
        const float eta = float(params.number(params.has("index") ? "index" : "eta", 1.5));
        m.specular = clamp01(type == "substrate" ? ks : ks * dielectric_f0(eta));
        m.roughness = roughness(params, 0.1);
    }
    m.base_color = clamp01(base.color);
    m.base_texture = base.image;
    if (type == "uber" && params.has("opacity")) {
        const PbrtTexture opacity = color_texture(params, "opacity", kOne);
        m.alpha_texture = opacity.image;
        if (opacity.image < 0) m.opacity = luminance(clamp01(opacity.color));
    }
    if (type != "plastic")
        loading_.warn(where, "material '" + type +
                                 "' is not modelled in full; a glossy coat over a diffuse base is used");
    return m;
}

int PbrtReader::mix(const PbrtParams& params, const std::string& where) {
    const auto found = now_.named->find(params.string("namedmaterial1", ""));
    if (found == now_.named->end()) fail(where, "the material 'mix' needs a defined namedmaterial1");
    loading_.warn(where, "material 'mix' is not modelled; its first material is used");
    return found->second;
}

int PbrtReader::material(const std::string& type, const PbrtParams& params, const std::string& where) {
    Material m;
    if (type == "" || type == "none") return kNoSurface;
    if (type == "mix") return mix(params, where);
    if (params.has("bumpmap")) loading_.warn(where, "bump maps are not modelled; ignored");
    if (type == "matte" || type == "translucent") {
        const PbrtTexture base = color_texture(params, "Kd", type == "matte" ? kHalf : kQuarter);
        m.base_color = clamp01(base.color);
        m.base_texture = base.image;
        if (type == "translucent")
            loading_.warn(where, "material 'translucent' is not modelled; diffuse reflection is used");
    } else if (type == "plastic" || type == "uber" || type == "substrate" || type == "disney") {
        m = coated(type, params, where);
    } else if (type == "metal") {
        m = metal(params);
    } else if (type == "mirror") {
        m.kind = MaterialKind::kMirror;
        m.specular = clamp01(color(params, "Kr", {.9f, .9f, .9f}));
    } else if (type == "glass") {
        m.kind = MaterialKind::kDielectric;
        m.eta = float(params.number(params.has("index") ? "index" : "eta", 1.5));
        if (!(m.eta > 0)) fail(where, "an index of refraction must be > 0");
        if (params.number("uroughness", 0) > 0 || params.number("vroughness", 0) > 0)
            loading_.warn(where, "rough glass is not modelled; smooth glass is used");
    } else {
        loading_.warn(where, "material '" + type + "' is not modelled; grey diffuse is used");
    }
    return loading_.add_material(m);
}

void PbrtReader::make_named_material(const std::string& where) {
    const std::string name = name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    if (!params.has("type")) fail(where, "MakeNamedMaterial needs \"string type\"");
    auto changed = std::make_shared<std::map<std::string, int>>(*now_.named);
    (*changed)[name] = material(params.string("type", ""), params, where);
    now_.named = changed;
}

void PbrtReader::set_named_material(const std::string& where) {
    const std::string name = name_argument();
    PbrtParams::read(tokens_);
    const auto found = now_.named->find(name);
    if (found == now_.named->end())
        return loading_.warn(where, "the material '" + name + "' is not defined; the one before is kept");
    now_.material = found->second;
}

}  // namespace viscache::loading
