// pbrt text: converts materials to the nearest material.
#include "viscache/formats/pbrt_reader.h"

namespace viscache::loading {

namespace {

/// pbrt's RoughnessToAlpha for `remaproughness`.
double roughness_to_alpha(double roughness) {
    const double x = std::log(std::max(roughness, 1e-3));
    return 1.62142 + 0.819955 * x + 0.1734 * x * x + 0.0171201 * x * x * x + 0.000640711 * x * x * x * x;
}

}  // namespace

/// A number, also of a constant texture.
double PbrtReader::plain_number(const PbrtParams& params, const std::string& name, double fallback) {
    const PbrtParam* p = params.find(name.c_str());
    if (!p || p->type != "texture") return params.number(name.c_str(), fallback);
    const PbrtTexture t = color_texture(params, name.c_str(), kOne * float(fallback));
    if (t.image < 0) return t.color.x;
    loading_.warn(p->where,
                  "an image for '" + name + "' is not modelled; " + std::to_string(fallback) + " is used");
    return fallback;
}

/// Takes the image of a metal's roughness. False if there is none, or if pbrt remaps its values.
bool PbrtReader::roughness_image(Material& m, const PbrtParams& params, const std::string& name) {
    const PbrtParam* p = params.find(name.c_str());
    if (!p || p->type != "texture" || params.boolean("remaproughness", true)) return false;
    const PbrtTexture t = color_texture(params, name.c_str(), kOne);
    if (t.image < 0) return false;
    m.roughness_texture = t.image;
    m.roughness = clamp_roughness(t.color.x);
    return true;
}

/// The mean of two roughnesses.
double PbrtReader::isotropic(const PbrtParams& params, double u, double v) {
    const auto* given = params.find("vroughness");
    if (!given) given = params.find("uroughness");
    if (u != v)
        loading_.warn(given ? given->where : main_path_,
                      "a roughness each way is not modelled; their mean is used");
    return std::sqrt(std::max(0.0, u) * std::max(0.0, v));
}

float PbrtReader::roughness(const PbrtParams& params, double fallback) {
    double r = plain_number(params, "roughness", fallback);
    const double u = plain_number(params, "uroughness", r), v = plain_number(params, "vroughness", r);
    r = isotropic(params, u, v);
    return clamp_roughness(float(params.boolean("remaproughness", true) ? roughness_to_alpha(r) : r));
}

Material PbrtReader::metal(const PbrtParams& params) {
    Material m;
    const Conductor copper = *conductor_named("Cu");
    m.kind = MaterialKind::kGlossy;
    m.base_color = kZero;
    set_metal(m, color(params, "eta", copper.eta), color(params, "k", copper.k));
    if (!roughness_image(m, params, "roughness")) m.roughness = roughness(params, 0.01);
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
    params.ignore_at(0, {"Kr", "Kt"});
    if (type != "disney" && max_component(m.specular) == 0)
        m.kind = MaterialKind::kDiffuse;
    else
        loading_.warn(where, "material '" + type +
                                 "' is not modelled in full; a glossy coat over a diffuse base is used");
    return m;
}

int PbrtReader::mix(const PbrtParams& params, const std::string& where) {
    // pbrt-v4 lists both names
    std::string name = params.string("namedmaterial1", "");
    if (const PbrtParam* both = params.find("materials"); both && !both->strings.empty())
        name = both->strings[0];
    const auto found = now_.named->find(name);
    if (found == now_.named->end()) fail(where, "the material 'mix' needs a defined namedmaterial1");
    params.ignore({"namedmaterial2", "amount"});
    loading_.warn(where, "material 'mix' is not modelled; its first material is used");
    return found->second;
}

int PbrtReader::material(const std::string& type, const PbrtParams& params, const std::string& where) {
    MaterialUv uv;
    uv_ = &uv;
    const int index = surface(type, params, where);
    uv_ = nullptr;
    if (index >= 0) material_uv_.try_emplace(index, uv.get());
    return index;
}

int PbrtReader::surface(const std::string& type, const PbrtParams& params, const std::string& where) {
    Material m;
    if (type == "" || type == "none" || type == "interface") return kNoSurface;
    if (type == "mix") return mix(params, where);
    for (const char* name : {"bumpmap", "displacement", "normalmap"})
        if (params.has(name))
            loading_.warn(params.find(name)->where, std::string("a '") + name + "' is not modelled; ignored");
    if (is_v4_material(type)) {
        is_v4_ = true;
        return loading_.add_material(v4_surface(type, params, where));
    }
    if (type == "matte" || type == "translucent") {
        const PbrtTexture base = color_texture(params, "Kd", type == "matte" ? kHalf : kQuarter);
        m.base_color = clamp01(base.color);
        m.base_texture = base.image;
        params.ignore_at(0, {"sigma"});
        if (type == "translucent") {
            params.ignore({"Ks", "reflect", "transmit", "roughness", "remaproughness"});
            loading_.warn(where, "material 'translucent' is not modelled; diffuse reflection is used");
        }
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
        const double u = params.number("uroughness", 0), v = params.number("vroughness", 0);
        params.ignore({"remaproughness"});
        params.ignore_at(1, {"Kr", "Kt"});
        if (u > 0 || v > 0) loading_.warn(where, "rough glass is not modelled; smooth glass is used");
    } else {
        params.ignore_all();
        loading_.warn(where, "material '" + type + "' is not modelled; grey diffuse is used");
    }
    return loading_.add_material(m);
}

void PbrtReader::set_material(const Names& names, const PbrtParams& params, const std::string& where) {
    now_.material = material(names[0], params, where);
}

void PbrtReader::make_named_material(const Names& names, const PbrtParams& params, const std::string& where) {
    if (!params.has("type")) fail(where, "MakeNamedMaterial needs \"string type\"");
    auto changed = std::make_shared<std::map<std::string, int>>(*now_.named);
    (*changed)[names[0]] = material(params.string("type", ""), params, where);
    now_.named = changed;
}

void PbrtReader::set_named_material(const Names& names, const PbrtParams&, const std::string& where) {
    const auto found = now_.named->find(names[0]);
    if (found == now_.named->end())
        return loading_.warn(where, "the material '" + names[0] + "' is not defined; the one before is kept");
    now_.material = found->second;
}

}  // namespace viscache::loading
