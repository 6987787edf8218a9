// pbrt text: colours, spectra and textures.
#include <filesystem>

#include "viscache/formats/pbrt_reader.h"

namespace viscache::loading {

namespace {

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

bool is_light(const PbrtParam& p) { return p.name == "L" || p.name == "I"; }

}  // namespace

std::vector<double> PbrtReader::spectrum_file(const PbrtParam& p) {
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
    return values;
}

/// As RGBSpectrum::FromSampled of pbrt-v3: no white balance, for reflectances neither, and the outermost
/// values hold beyond their wavelengths. pbrt-v4 sees reflectances by daylight, and ends there.
Rgb PbrtReader::spectrum_of(const PbrtParam& p) {
    if (p.strings.size() == 1) {
        if (const auto known = named_spectrum(p.strings[0])) return *known;
        std::error_code error;
        if (is_v4_ && !std::filesystem::exists(path_named(p.strings[0], p.where), error)) {
            loading_.warn(p.where, "the spectrum '" + p.strings[0] + "' is not known; 1 is used");
            return kOne;
        }
    }
    Spectrum s = spectrum_from(p.strings.empty() ? p.numbers : spectrum_file(p), p.where);
    if (is_v4_) return spectrum_to_rgb(s, is_light(p) ? SpectrumOf::kLight : SpectrumOf::kReflectance);
    if (s.front().first > 300) s.insert(s.begin(), {300, s.front().second});
    if (s.back().first < 900) s.emplace_back(900, s.back().second);
    return spectrum_to_rgb(s, SpectrumOf::kLight);
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
        c = spectrum_of(p);
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
    c = max(kZero, c);
    // A spectrum gives a light of pbrt-v4 its colour alone: its luminance is 1 times the light's scale
    const bool has_shape_alone = is_v4_ && is_light(p) && (p.type == "spectrum" || p.type == "blackbody");
    return has_shape_alone && luminance(c) > 0 ? c / luminance(c) : c;
}

PbrtTexture PbrtReader::color_texture(const PbrtParams& params, const char* name, Rgb fallback) {
    const PbrtParam* p = params.find(name);
    if (!p) return {fallback};
    if (const auto c = color_of(*p)) return {*c};
    if (p->type != "texture" || p->strings.size() != 1)
        fail(p->where, std::string("'") + name + "' must be a colour or a texture");
    const auto found = now_.textures->find(p->strings[0]);
    if (found == now_.textures->end()) {
        loading_.warn(p->where, "the texture '" + p->strings[0] + "' is not defined; the default is used");
        return {fallback};
    }
    const PbrtTexture& t = found->second;
    if (uv_ && t.image >= 0 && !uv_->add(t.uv))
        loading_.warn(p->where,
                      "the images of a material share one transform of texture coordinates; that of "
                      "the first is used");
    return t;
}

Rgb PbrtReader::color(const PbrtParams& params, const char* name, Rgb fallback) {
    const PbrtTexture t = color_texture(params, name, fallback);
    if (t.image >= 0)
        loading_.warn(params.find(name)->where,
                      std::string("an image for '") + name + "' is not modelled; white is used");
    return t.color;
}

/// The transform of texture coordinates that a texture asks for.
UvTransform PbrtReader::mapping(const PbrtParams& params, const std::string& where) {
    if (const std::string kind = params.string("mapping", "uv"); kind != "uv") {
        params.ignore({"v1", "v2"});
        loading_.warn(where, "the mapping '" + kind + "' is not modelled; texture coordinates are used");
    }
    UvTransform t;
    t.m[0][0] = params.number("uscale", 1);
    t.m[1][1] = params.number("vscale", 1);
    t.m[0][2] = params.number("udelta", 0);
    t.m[1][2] = params.number("vdelta", 0);
    return t;
}

PbrtTexture PbrtReader::image_map(const PbrtParams& params, const std::string& where) {
    const PbrtParam* file = params.find("filename");
    if (!file) fail(where, "an imagemap needs a filename");
    const std::string path = path_named(params.string("filename", ""), file->where);
    PbrtTexture t;
    const std::string encoding = params.string("encoding", "sRGB"), name = params.string("wrap", "repeat");
    const bool srgb = params.boolean("gamma", encoding != "linear");
    if (encoding != "sRGB" && encoding != "linear")
        loading_.warn(where, "the encoding '" + encoding + "' is not modelled; sRGB is used");
    const auto wrap = wrap_named(name);
    if (!wrap) loading_.warn(where, "the wrap mode '" + name + "' is not modelled; images repeat");
    if (params.boolean("invert", false))
        loading_.warn(where, "inverted images are not modelled; the image is used as it is");
    const Wrap both = wrap.value_or(Wrap::kRepeat);
    t.image =
        loading_.add_image(path, file->where, srgb, {params.string("filter", "") == "point", both, both});
    const float scale = float(params.number("scale", 1));
    t.color = {scale, scale, scale};
    t.uv = mapping(params, where);
    // How pbrt filters: the mean of what is seen stays
    params.ignore({"maxanisotropy", "trilinear"});
    return t;
}

PbrtTexture PbrtReader::checkerboard(const PbrtParams& params, const std::string& where) {
    params.ignore({"aamode"});  // smooths edges; the mean stays
    if (params.integer("dimension", 2) != 2) {
        loading_.warn(where, "a checkerboard in space is not modelled; its mean colour is used");
        return {(color(params, "tex1", kOne) + color(params, "tex2", kZero)) * 0.5f};
    }
    // Squares are one unit wide, those of the image half a unit
    PbrtTexture t;
    t.image = loading_.add_checkerboard(color(params, "tex1", kOne), color(params, "tex2", kZero), where);
    t.uv = mapping(params, where);
    for (auto& row : t.uv.m)
        for (double& x : row) x /= 2;
    return t;
}

/// The names are that of the texture, float or spectrum, and the kind.
void PbrtReader::texture(const Names& names, const PbrtParams& params, const std::string& where) {
    const std::string& type = names[2];
    PbrtTexture t;
    if (type == "imagemap") {
        t = image_map(params, where);
    } else if (type == "checkerboard") {
        t = checkerboard(params, where);
    } else if (type == "constant") {
        t.color = color(params, "value", kOne);
    } else if (type == "scale") {
        // pbrt-v4 names them "tex" and "scale"
        const PbrtTexture a = color_texture(params, params.has("tex") ? "tex" : "tex1", kOne),
                          b = color_texture(params, params.has("scale") ? "scale" : "tex2", kOne);
        t = a.image >= 0 ? a : b;
        t.color = a.color * b.color;
        if (a.image >= 0 && b.image >= 0)
            loading_.warn(where, "the product of two images is not modelled; the first is used");
    } else {
        params.ignore_all();
        loading_.warn(where, "texture '" + type + "' is not modelled; grey is used");
        t.color = kHalf;
    }
    auto changed = std::make_shared<std::map<std::string, PbrtTexture>>(*now_.textures);
    (*changed)[names[0]] = t;
    now_.textures = changed;
}

}  // namespace viscache::loading
