// MTL: reads the materials of an OBJ file and converts them to the nearest ones. tinyobjloader is not used:
// it reads malformed numbers as 0, drops faces with a wrong index and options of texture lines, and does not
// say which keys it leaves out. Checks before it, which this needs, are most of a reader. How exporters write
// materials is described in docs/howto/own-scene.md.
#include "viscache/formats/mtl.h"

#include <variant>

namespace viscache::loading {

namespace {

bool is_space(char c) { return c == ' ' || c == '\t'; }

struct Harmless {};  ///< leaves the picture right
struct Unmodelled {
    const char* what;
    bool unless_zero = false;
};

/// A key of a material: where its value goes, or why it goes nowhere.
struct MtlKey {
    const char* name;  ///< in lower case: exporters disagree about `map_Bump`
    std::variant<std::optional<Rgb> MtlMaterial::*, std::optional<float> MtlMaterial::*,
                 std::optional<MtlImage> MtlMaterial::*, Harmless, Unmodelled>
        to;
    bool is_share = false;  ///< must be in [0, 1]
};

constexpr Unmodelled kBump{"bump maps are not modelled"},
    kReflected{"images of reflections are not modelled"},
    kImage{"an image of this kind is not modelled; the number is used"};

const MtlKey kMtlKeys[] = {
    {"ka", &MtlMaterial::ka},  // there is no ambient light; Blender puts its share of metal here
    {"kd", &MtlMaterial::kd, true},
    {"ks", &MtlMaterial::ks, true},
    {"ke", &MtlMaterial::ke},
    {"tf", &MtlMaterial::tf},
    {"ns", &MtlMaterial::ns},
    {"ni", &MtlMaterial::ni},
    {"d", &MtlMaterial::d, true},
    {"tr", &MtlMaterial::tr, true},
    {"illum", &MtlMaterial::illum},
    {"pr", &MtlMaterial::pr, true},
    {"pm", &MtlMaterial::pm, true},
    {"map_kd", &MtlMaterial::map_kd},
    {"map_ks", &MtlMaterial::map_ks},
    {"map_ns", &MtlMaterial::map_ns},
    {"map_d", &MtlMaterial::map_d},
    {"map_ke", &MtlMaterial::map_ke},
    {"map_pr", &MtlMaterial::map_pr},
    {"map_ka", Harmless{}},     // no ambient light
    {"map_aat", Harmless{}},    // anti-aliasing of images
    {"sharpness", Harmless{}},  // of images of reflections, which are warned of
    {"pcr", Harmless{}},        // how a coat is, which is warned of
    {"anisor", Harmless{}},     // how anisotropy is turned, which is warned of
    {"ps", Unmodelled{"sheen is not modelled", true}},
    {"pc", Unmodelled{"the coat of Pc is not modelled", true}},
    {"aniso", Unmodelled{"anisotropy is not modelled", true}},
    {"bump", kBump},
    {"map_bump", kBump},
    {"norm", kBump},
    {"map_norm", kBump},
    {"map_kn", kBump},
    {"disp", kBump},
    {"map_disp", kBump},
    {"refl", kReflected},
    {"map_refl", kReflected},
    {"decal", Unmodelled{"decals are not modelled"}},
    {"map_tr", Unmodelled{"images of Tr are not modelled"}},
    {"map_tf", kImage},
    {"map_ni", kImage},
    {"map_pm", kImage},
    {"map_ps", kImage},
    {"map_pc", kImage},
    {"map_pcr", kImage},
};

enum class ImageOption { kOffset, kScale, kClamp, kChannel, kColorSpace, kHarmless };

/// An option of a texture line.
struct ImageKey {
    const char* name;
    ImageOption to;
    int numbers;  ///< at most so many follow; 0: a word does
    Vec3 standard{0, 0, 0};
    const char* unlike = nullptr;  ///< what is not modelled if the numbers are others
};

const ImageKey kImageKeys[] = {
    {"-o", ImageOption::kOffset, 3},
    {"-s", ImageOption::kScale, 3, {1, 1, 1}},
    {"-clamp", ImageOption::kClamp, 0},
    {"-imfchan", ImageOption::kChannel, 0},
    {"-colorspace", ImageOption::kColorSpace, 0},
    {"-t", ImageOption::kHarmless, 3, {0, 0, 0}, "turbulence of texture coordinates (-t) is not modelled"},
    {"-mm", ImageOption::kHarmless, 2, {0, 1, 0}, "base and gain of an image (-mm) are not modelled"},
    {"-blendu", ImageOption::kHarmless, 0},  // filters of images, which are not
    {"-blendv", ImageOption::kHarmless, 0},  // modelled for any format
    {"-boost", ImageOption::kHarmless, 1},
    {"-texres", ImageOption::kHarmless, 0},
    {"-cc", ImageOption::kHarmless, 0},    // of display hardware
    {"-bm", ImageOption::kHarmless, 1},    // of bump maps, which are warned of
    {"-type", ImageOption::kHarmless, 0},  // of images of reflections, which are warned of
};

template <class Row, size_t n>
const Row* row_of(const Row (&rows)[n], const std::string& name) {
    for (const Row& row : rows)
        if (name == row.name) return &row;
    return nullptr;
}

bool is_black(Rgb c) { return c == Rgb{}; }

/// The factor of an image. Exporters leave it out beside an image (Blender) or write zeros (Maya).
Rgb factor(const std::optional<Rgb>& given, bool has_image) {
    if (has_image && is_black(given.value_or(Rgb{}))) return {1, 1, 1};
    return given.value_or(Rgb{});
}

}  // namespace

std::string_view next_word(std::string_view& line) {
    size_t begin = 0;
    while (begin < line.size() && is_space(line[begin])) ++begin;
    size_t end = begin;
    while (end < line.size() && !is_space(line[end])) ++end;
    const std::string_view word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    return text;
}

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 60)) + "'"; }

WavefrontLines::WavefrontLines(std::string_view text, const std::string& path) : text_(text), path_(path) {
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);  // the byte order mark of UTF-8
}

std::string_view WavefrontLines::physical() {
    // The next LF is kept, so that a text with CR alone is not searched for it again and again.
    if (newline_ < begin_ || read_ == 0) newline_ = std::min(text_.find('\n', begin_), text_.size());
    std::string_view line = text_.substr(begin_, newline_ - begin_);
    const size_t cr = line.find('\r');
    const bool ends_here = cr < line.size() && (cr + 1 < line.size() || newline_ == text_.size());
    if (cr < line.size()) line = line.substr(0, cr);
    begin_ = ends_here ? begin_ + cr + 1 : newline_ + 1;
    ++read_;
    if (line.find('\0') != std::string_view::npos) fail(at_line(path_, read_), "a zero byte in a text file");
    return trimmed(line);
}

bool WavefrontLines::next(std::string_view& line) {
    if (begin_ >= text_.size()) return false;
    line = physical();
    number_ = read_;
    // A comment may end with a path of Windows.
    if (line.empty() || line.back() != '\\' || line.front() == '#') return true;
    joined_.clear();
    while (!line.empty() && line.back() == '\\') {
        joined_.append(line.substr(0, line.size() - 1)) += ' ';
        line = begin_ < text_.size() ? physical() : std::string_view();
    }
    joined_ += line;
    line = trimmed(joined_);
    return true;
}

Numbers numbers_of(std::string_view rest) {
    Numbers found;
    float* const first[6] = {&found.first.x, &found.first.y, &found.first.z,
                             &found.next.x,  &found.next.y,  &found.next.z};
    for (std::string_view w; !(w = next_word(rest)).empty() && w[0] != '#'; ++found.count) {
        const auto x = parse_number(w);
        if (!x || !std::isfinite(*x)) {
            found.wrong = w;
            return found;
        }
        if (found.count < 6) *first[found.count] = float(*x);
    }
    return found;
}

void MtlReader::read(const std::string& path, const std::string& asked_at) {
    // Files that were joined name their materials once for each part.
    for (const File& file : files_)
        if (file.path == path) return;
    std::string text;
    try {
        text = read_file(path);
    } catch (const SceneError& error) {
        return loading_.warn(asked_at, std::string(error.what()) + "; its materials are left out");
    }
    const size_t first = materials_.size();
    files_.push_back({path});
    WavefrontLines lines(text, path);
    for (std::string_view line; lines.next(line);) {
        if (line.empty()) continue;
        if (line[0] == '#') {
            if (line.starts_with("# Blender")) files_.back().writer = Writer::kBlender;
            if (lower(line).find("visualization toolkit") != std::string::npos)
                files_.back().writer = Writer::kVtk;
            continue;
        }
        const std::string_view key = next_word(line);
        read_line(key, trimmed(line), lines);
    }
    // Nobody writes materials that cannot be seen, so `Tr 1` alone says what Tr means in this file.
    bool has_one = false, has_zero = false;
    for (size_t i = first; i < materials_.size(); ++i) {
        if (materials_[i].d || !materials_[i].tr) continue;
        has_one = has_one || *materials_[i].tr == 1;
        has_zero = has_zero || *materials_[i].tr == 0;
    }
    files_.back().tr_is_opacity = files_.back().writer == Writer::kVtk || (has_one && !has_zero);
}

void MtlReader::read_line(std::string_view key, std::string_view rest, const WavefrontLines& lines) {
    const std::string name(key.substr(0, 60));
    if (key == "newmtl") {
        MtlMaterial& m = materials_.emplace_back();
        m.name = rest;
        m.file = files_.size() - 1;
        m.line = lines.number();
        if (!by_name_.try_emplace(m.name, int(materials_.size()) - 1).second)
            loading_.warn(lines.where(), "a material of this name is already defined; the first one is used");
        return;
    }
    const MtlKey* const row = row_of(kMtlKeys, lower(key));
    if (!row) return loading_.warn(lines.where(), "'" + name + "' is not read");
    if (std::holds_alternative<Harmless>(row->to)) return;
    const auto* const unmodelled = std::get_if<Unmodelled>(&row->to);
    if (unmodelled && !unmodelled->unless_zero) return loading_.warn(lines.where(), unmodelled->what);
    if (materials_.size() == 0 || materials_.back().file != files_.size() - 1)
        return loading_.warn(lines.where(), "a line before the first 'newmtl' is not read");
    MtlMaterial& m = materials_.back();
    if (const auto* const to = std::get_if<std::optional<MtlImage> MtlMaterial::*>(&row->to)) {
        if (MtlImage found = image(rest, lines); !found.name.empty()) m.** to = std::move(found);
        return;
    }
    std::string_view words = rest;
    const std::string_view word = next_word(words);
    if (word.empty()) loading_.warn(lines.where(), name + " has no number; it counts as 0");
    if (word == "spectral" || word == "xyz")
        return loading_.warn(lines.where(), "'" + name + " " + std::string(word) + "' is not read");
    if (word == "-halo") {
        loading_.warn(lines.where(), "a halo is not modelled");
        rest = words;
    }
    const auto [first, next, count, wrong] = numbers_of(rest);
    if (!wrong.empty())
        return loading_.warn(lines.where(), "'" + name + "' needs finite numbers; the line is not read");
    Vec3 v = first;
    if (count < 2) v.y = v.x;  // one number is a grey
    if (count < 3) v.z = v.x;
    const float least = std::min({v.x, v.y, v.z}), most = max_component(v);
    if (row->is_share && (least < 0 || most > 1)) {
        loading_.warn(lines.where(), name + " must be in [0, 1]; it is clamped");
        v = clamp01(v);
    }
    if (unmodelled && most != 0) loading_.warn(lines.where(), unmodelled->what);
    if (const auto* const to = std::get_if<std::optional<Rgb> MtlMaterial::*>(&row->to)) m.** to = v;
    if (const auto* const to = std::get_if<std::optional<float> MtlMaterial::*>(&row->to)) m.** to = v.x;
}

MtlImage MtlReader::image(std::string_view rest, const WavefrontLines& lines) {
    MtlImage found;
    found.line = lines.number();
    while (!rest.empty() && rest[0] == '-') {
        std::string_view after = rest;
        const std::string key = lower(next_word(after));
        after = trimmed(after);
        const ImageKey* const row = row_of(kImageKeys, key);
        if (after.empty()) break;  // a file's name
        rest = after;
        if (!row) {
            loading_.warn(lines.where(), "'" + key.substr(0, 60) + "' is not read");
            continue;
        }
        // The last word is the name of the file, whatever it is.
        Vec3 v = row->standard;
        float* const values[3] = {&v.x, &v.y, &v.z};
        for (int i = 0; i < row->numbers; ++i) {
            after = rest;
            const auto x = parse_number(next_word(after));
            if (!x || !std::isfinite(*x) || trimmed(after).empty()) break;
            *values[i] = float(*x);
            rest = trimmed(after);
        }
        std::string word;
        if (row->numbers == 0) {
            word = lower(next_word(rest));
            rest = trimmed(rest);
        }
        if (row->to == ImageOption::kOffset) {
            found.uv.m[0][2] = v.x;
            found.uv.m[1][2] = v.y;
        } else if (row->to == ImageOption::kScale) {
            found.uv.m[0][0] = v.x;
            found.uv.m[1][1] = v.y;
        } else if (row->to == ImageOption::kClamp && word == "on") {
            found.look_up.u = found.look_up.v = Wrap::kClamp;
        } else if (row->to == ImageOption::kColorSpace) {
            found.srgb = word != "linear";
        } else if (row->unlike && !(v == row->standard)) {
            loading_.warn(lines.where(), row->unlike);
        } else if (row->to == ImageOption::kChannel && word != "m") {
            loading_.warn(lines.where(),
                          "-imfchan is not modelled; opacity is alpha if there is one, else red");
        }
    }
    // Some exporters quote names.
    if (rest.size() > 2 && rest.front() == '"' && rest.back() == '"') rest = rest.substr(1, rest.size() - 2);
    if (rest.empty()) loading_.warn(lines.where(), "a texture line without a file is left out");
    found.name = rest;
    return found;
}

int MtlReader::find(const std::string& name) const {
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? -1 : found->second;
}

/// The share of the surface that is there, by `d`, `Tr` or `Tf`.
float MtlReader::opacity(const MtlMaterial& in) {
    if (in.d) return *in.d;  // 3ds Max writes Tr = 1 - d beside it
    if (in.tr) {
        const File& file = files_[in.file];
        if (file.writer != Writer::kVtk && (*in.tr == 0 || *in.tr == 1)) return 1;
        if (!file.tr_is_opacity)
            loading_.note(where(in), "'Tr' without 'd' is read as 1 - opacity; some programs mean opacity");
        return file.tr_is_opacity ? *in.tr : 1 - *in.tr;
    }
    // The models of glass without an index: Maya writes 1 - transparency here.
    const float illum = in.illum.value_or(2);
    if (in.tf && (illum == 4 || illum == 9) && !is_black(*in.tf)) {
        const Rgb tf = clamp01(*in.tf);
        if (tf.x != tf.y || tf.x != tf.z)
            loading_.warn(where(in), "coloured transparency (Tf) is not modelled; its mean is used");
        return (tf.x + tf.y + tf.z) / 3;
    }
    return 1;
}

/// Programs write the models of glass (4, 6, 7, 9) for plain and for half transparent materials, too.
bool MtlReader::is_glass(const MtlMaterial& in, float opacity) const {
    const Rgb tf = in.tf.value_or(Rgb{1, 1, 1});
    if (is_black(tf)) return false;
    // Its 6 and 9 stand for any alpha. Transmission is in Tf, whatever the model.
    if (by_blender(in)) return in.tf && in.pr && max_component(tf) >= 0.5f;
    const float illum = in.illum.value_or(2), ni = in.ni.value_or(0);
    // An index of 1 is a filter if there is a colour, otherwise what is written for a plain material.
    if (illum == 6 || illum == 7) return !in.ni || ni > 1 || std::min({tf.x, tf.y, tf.z}) < 1;
    return ni > 1 && (illum == 4 || (illum == 9 && opacity == 1));
}

void MtlReader::glass(Material& m, const MtlMaterial& in) {
    m.kind = MaterialKind::kDielectric;
    m.eta = std::max(in.ni.value_or(1.5f), 1.f);
    if (!(m.eta < 10)) fail(where(in), "Ni must be below 10");
    m.transmission = clamp01(in.tf.value_or(Rgb{1, 1, 1}));
    if (in.pr.value_or(0) > 0) loading_.warn(where(in), "rough glass is not modelled; it is smooth");
}

/// What a material reflects beside its Lambertian part.
void MtlReader::lobe(Material& m, const MtlMaterial& in, bool has_base) {
    const float illum = in.illum.value_or(2), ns = in.ns.value_or(0);
    const Rgb ks = in.ks.value_or(Rgb{});
    const bool is_pbr = in.pr || in.pm || in.map_pr, blender = by_blender(in);
    if (is_pbr || (blender && illum > 1)) {
        // Blender's Ks is its level of specular light, at which .5 stands for the reflectance of the index.
        const float level = blender ? 2 * (in.ks ? max_component(ks) : 0.5f) : 1;
        const float f0 = dielectric_f0(in.ni.value_or(0) > 1 ? *in.ni : 1.5f) * level;
        const float sharp = in.ns ? std::sqrt(std::clamp(ns / 1000, 0.f, 1.f)) : 0.5f;
        const float roughness = in.pr ? *in.pr : in.map_pr ? 1 : 1 - sharp;
        m.kind = MaterialKind::kGlossy;
        m.specular = clamp01({f0, f0, f0});
        m.roughness = clamp_roughness(roughness * roughness);
        m.metallic = in.pm.value_or(0);
        // Of a metal, which Blender writes as a mirror, its share is in Ka.
        if (!is_pbr && (illum == 3 || illum == 6)) m.metallic = clamp01(in.ka.value_or(Rgb{1, 1, 1})).x;
    } else if (illum > 1 && !is_black(ks)) {
        const bool reflects = illum == 3 || illum == 5 || illum == 8;
        const bool is_sharp = reflects && (!in.ns || ns >= 1000);
        if (reflects && !has_base)
            m.kind = MaterialKind::kMirror;
        else if (is_sharp || ns > 1)
            m.kind = MaterialKind::kGlossy;
        if (m.kind == MaterialKind::kDiffuse) return;
        m.specular = ks;
        // A lobe leaves 1 - Ks to the base, to which MTL adds it
        const auto before = [](float kd, float s) { return kd > 0 ? kd / std::max(1 - s, kd) : 0; };
        const Rgb kd = m.base_color;
        if (reflects && m.kind == MaterialKind::kGlossy)
            m.base_color = {before(kd.x, ks.x), before(kd.y, ks.y), before(kd.z, ks.z)};
        // The roughness whose lobe is as wide as a Phong lobe of this exponent (Walter et al. 2007).
        m.roughness = clamp_roughness(is_sharp ? 0 : std::sqrt(2.f / (std::max(ns, 0.f) + 2.f)));
    }
}

int MtlReader::add_image(Look& look, const MtlImage& image, const std::string& path, bool srgb) {
    const std::string at = at_line(path, image.line);
    if (!look.uv.add(image.uv))
        loading_.warn(at,
                      "the images of a material share one transform of texture coordinates; that of the "
                      "first is used");
    return loading_.add_image(resolve(path, image.name), at, srgb && image.srgb, image.look_up);
}

MtlReader::Look MtlReader::look(int index) {
    const MtlMaterial& in = materials_[size_t(index)];
    const std::string& path = files_[in.file].path;
    Look out;
    Material& m = out.material;
    const float illum = in.illum.value_or(2), opaque = opacity(in);
    const bool says_nothing = !in.kd && !in.ks && !in.ke && !in.map_kd && !in.map_ks && !in.map_ke;
    if (in.illum && !(illum >= 0 && illum <= 9))
        loading_.warn(where(in), "illum must be 0 to 9 here; 2 is used");
    if (is_glass(in, opaque)) {
        glass(m, in);
    } else {
        if (says_nothing) loading_.note(where(in), "a material without a colour is grey");
        if (!says_nothing) m.base_color = factor(in.kd, in.map_kd.has_value());
        lobe(m, in, in.map_kd || !is_black(m.base_color));
        m.opacity = in.map_d && opaque == 0 ? 1 : opaque;
    }
    if (in.map_kd && m.kind == MaterialKind::kDielectric)  // it would tint the glass
        loading_.warn(at_line(path, in.map_kd->line), "an image of Kd on glass is not modelled");
    else if (in.map_kd)
        m.base_texture = add_image(out, *in.map_kd, path, true);
    if (in.map_d) {
        m.alpha_texture = add_image(out, *in.map_d, path, false);
        m.alpha_cutoff = -1;  // a share
    }
    if (in.map_pr && m.kind == MaterialKind::kGlossy && m.metallic == 0)
        m.metallic_roughness_texture = add_image(out, *in.map_pr, path, false);
    else if (in.map_pr)
        loading_.warn(at_line(path, in.map_pr->line), kImage.what);
    for (const auto* unused : {&in.map_ks, &in.map_ns})
        if (*unused) loading_.warn(at_line(path, (*unused)->line), kImage.what);
    out.emission = factor(in.ke, in.map_ke.has_value());
    if (in.map_ke) out.emission_texture = add_image(out, *in.map_ke, path, true);
    return out;
}

}  // namespace viscache::loading
