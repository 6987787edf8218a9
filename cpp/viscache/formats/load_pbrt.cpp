// pbrt text: directives, transforms, attribute blocks and object instances.
#include "viscache/formats/pbrt_reader.h"

#include <filesystem>

namespace viscache::loading {

std::string PbrtReader::path_named(const std::string& name, const std::string& asked_at) const {
    // pbrt-v3 resolves names from the folder of the main file. Files that were moved together are found from
    // their own folder.
    const std::string from_main = resolve(main_path_, name);
    const std::string from_here = resolve(asked_at.substr(0, asked_at.rfind(':')), name);
    std::error_code error;
    return !std::filesystem::exists(from_main, error) && std::filesystem::exists(from_here, error)
               ? from_here
               : from_main;
}

void PbrtReader::save(char kind, const PbrtToken& token) {
    // Each open block keeps a copy of the state: a short file of Begins must not fill the memory.
    if (saved_.size() > 100000) fail(token.where(), "blocks are nested more than 100,000 deep");
    saved_.push_back({now_, kind, token.where()});
}

void PbrtReader::restore(char kind, const PbrtToken& token) {
    // An object is an attribute block to pbrt: each may end the other.
    const bool is_transform = kind == 't';
    if (saved_.empty() || (saved_.back().kind == 't') != is_transform)
        fail(token.where(), std::string(token.text) + " has no matching begin");
    // TransformEnd brings the transform back, and AttributeEnd all of the state.
    if (is_transform)
        now_.ctm = saved_.back().graphics.ctm;
    else
        now_ = std::move(saved_.back().graphics);
    saved_.pop_back();
}

Affine PbrtReader::read_matrix(const PbrtToken& token) {
    tokens_.expect(PbrtToken::kOpen, "'['");
    double v[16];
    for (double& x : v) x = tokens_.expect_number();
    tokens_.expect(PbrtToken::kClose, "']'");
    // The file lists the matrix by columns.
    if (v[3] != 0 || v[7] != 0 || v[11] != 0 || v[15] != 1)
        fail(token.where(), "only affine matrices are read");
    Affine t;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) t.m[i][j] = v[j * 4 + i];
    return t;
}

Affine PbrtReader::read_look_at(const PbrtToken& token) {
    float v[9];
    for (float& x : v) x = float(tokens_.expect_number());
    const Vec3 eye{v[0], v[1], v[2]}, target{v[3], v[4], v[5]}, up{v[6], v[7], v[8]};
    // pbrt's camera space is left-handed: x to the right, y up, z forward.
    const Vec3 forward = normalize(target - eye), right = normalize(cross(normalize(up), forward));
    if (length2(forward) == 0 || length2(right) == 0)
        fail(token.where(), "LookAt needs a target other than the eye, and an up vector across the view");
    const Vec3 columns[4] = {right, cross(forward, right), forward, eye};
    Affine camera_to_world;
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 3; ++i) camera_to_world.m[i][j] = columns[j][i];
    // Transforms before Camera map the world to the camera.
    const auto t = inverse_of(camera_to_world);
    if (!t) fail(token.where(), "LookAt has no inverse");
    return *t;
}

void PbrtReader::multiply(const Affine& t, const PbrtToken& token) {
    // The latest directive is nearest to the point.
    now_.ctm = now_.ctm * t;
    if (!is_finite(now_.ctm)) fail(token.where(), "the transform is not finite");
}

bool PbrtReader::transform_directive(const PbrtToken& token) {
    const std::string_view name = token.text;
    double v[4];
    const auto read = [&](int n) {
        for (int i = 0; i < n; ++i) v[i] = tokens_.expect_number();
    };
    if (name == "Identity") {
        now_.ctm = Affine{};
    } else if (name == "Translate") {
        read(3);
        multiply(translation(v[0], v[1], v[2]), token);
    } else if (name == "Scale") {
        read(3);
        multiply(scaling(v[0], v[1], v[2]), token);
    } else if (name == "Rotate") {
        read(4);
        multiply(rotation(v[0], v[1], v[2], v[3]), token);
    } else if (name == "LookAt") {
        multiply(read_look_at(token), token);
    } else if (name == "Transform") {
        now_.ctm = read_matrix(token);
    } else if (name == "ConcatTransform") {
        multiply(read_matrix(token), token);
    } else if (name == "CoordinateSystem") {
        coordinate_systems_[name_argument()] = now_.ctm;
    } else if (name == "CoordSysTransform") {
        const std::string system = name_argument();
        const auto found = coordinate_systems_.find(system);
        if (found == coordinate_systems_.end())
            fail(token.where(), "the coordinate system '" + system + "' is not defined");
        now_.ctm = found->second;
    } else if (name == "ActiveTransform") {
        const PbrtToken which = tokens_.expect(PbrtToken::kWord, "All, StartTime or EndTime");
        if (which.text != "All")
            loading_.warn(token.where(), "moving transforms are not modelled; all of them apply");
    } else if (name == "TransformTimes") {
        read(2);
        loading_.warn(token.where(), "moving transforms are not modelled");
    } else {
        return false;
    }
    return true;
}

void PbrtReader::object_instance(const PbrtToken& token) {
    const std::string name = name_argument();
    const auto found = objects_.find(name);
    if (found == objects_.end()) fail(token.where(), "the object '" + name + "' is not defined");
    // pbrt has one level of instances.
    if (object_) fail(token.where(), "ObjectInstance must not stand inside ObjectBegin");
    if (!found->second.empty()) loading_.scene.instances.push_back({found->second, now_.ctm});
}

bool PbrtReader::block_directive(const PbrtToken& token) {
    const std::string_view name = token.text;
    if (name == "WorldBegin") {
        if (in_world_) fail(token.where(), "WorldBegin stands twice");
        in_world_ = true;
        now_.ctm = Affine{};
        // The transform of the camera does not carry over into the world.
        coordinate_systems_["world"] = now_.ctm;
    } else if (name == "WorldEnd") {
        if (!in_world_) fail(token.where(), "WorldEnd without WorldBegin");
        if (!saved_.empty()) fail(saved_.back().where, "this block does not end before WorldEnd");
        world_ended_ = true;
    } else if (name == "AttributeBegin" || name == "TransformBegin") {
        save(name == "AttributeBegin" ? 'a' : 't', token);
    } else if (name == "AttributeEnd" || name == "TransformEnd") {
        restore(name == "AttributeEnd" ? 'a' : 't', token);
    } else if (name == "ObjectBegin") {
        if (object_) fail(token.where(), "ObjectBegin must not stand inside ObjectBegin");
        save('o', token);
        object_ = &objects_[name_argument()];
        // A second definition of a name replaces the first.
        object_->clear();
    } else if (name == "ObjectEnd") {
        restore('o', token);
        object_ = nullptr;
    } else if (name == "ObjectInstance") {
        object_instance(token);
    } else if (name == "ReverseOrientation") {
        now_.reversed = !now_.reversed;
    } else if (name == "Include") {
        const PbrtToken file = tokens_.expect(PbrtToken::kString, "a file name in quotes");
        // The state is not saved: an included file may change the transform and the material of the file that
        // includes it.
        tokens_.push(path_named(std::string(file.text), file.where()), file.where());
    } else {
        return false;
    }
    return true;
}

/// Directives with parameters.
const PbrtReader::Plugin PbrtReader::kPlugins[] = {
    {"Shape", "shape", 1, 0, &PbrtReader::shape},
    {"Material", "material", 1, 0, &PbrtReader::set_material},
    {"MakeNamedMaterial", "material", 1, -1, &PbrtReader::make_named_material},
    {"NamedMaterial", "", 1, -1, &PbrtReader::set_named_material},
    {"Texture", "texture", 3, 2, &PbrtReader::texture},
    {"LightSource", "light", 1, 0, &PbrtReader::light},
    {"AreaLightSource", "light", 1, 0, &PbrtReader::area_light},
    {"Camera", "", 1, 0, &PbrtReader::camera},
    {"Film", "", 1, 0, &PbrtReader::film},
    {"MakeNamedMedium", "medium", 1, -1, &PbrtReader::make_named_medium},
    {"Option", "", 0, -1, &PbrtReader::option},
    // How the picture is computed does not belong to the scene. A filter keeps the mean of the picture
    {"Integrator", "", 1, -1, &PbrtReader::rendering_settings},
    {"Sampler", "", 1, -1, &PbrtReader::rendering_settings},
    {"PixelFilter", "", 1, -1, &PbrtReader::rendering_settings},
    {"Accelerator", "", 1, -1, &PbrtReader::rendering_settings},
    {"SurfaceIntegrator", "", 1, -1, &PbrtReader::rendering_settings},
    {"VolumeIntegrator", "", 1, -1, &PbrtReader::rendering_settings},
    {"Renderer", "", 1, -1, &PbrtReader::rendering_settings},
};

/// Reads a directive with its parameters. Those that its reader left are warned of here: no reader can drop
/// one in silence.
bool PbrtReader::plugin_directive(const PbrtToken& token) {
    const auto* plugin = std::find_if(std::begin(kPlugins), std::end(kPlugins),
                                      [&](const Plugin& p) { return p.word == token.text; });
    if (plugin == std::end(kPlugins)) return medium_interface(token);
    const std::string where = token.where();
    Names names;
    for (int i = 0; i < plugin->names; ++i) names.push_back(name_argument());
    const PbrtParams params = params_of(plugin->attribute);
    (this->*plugin->read)(names, params, where);
    const PbrtParams::List unread = params.unread();
    if (unread.empty()) return true;
    std::string of(plugin->word);
    if (plugin->shown >= 0) of += " '" + names[size_t(plugin->shown)] + "'";
    warn_unread(unread, of);
    return true;
}

void PbrtReader::warn_unread(const PbrtParams::List& params, const std::string& of) {
    for (const auto& p : params)
        loading_.warn(p->where, "the parameter '" + p->name + "' of " + of + " is not read");
}

void PbrtReader::make_named_medium(const Names&, const PbrtParams& params, const std::string& where) {
    // The picture is wrong only where a shape, a light or the camera stands in it
    loading_.note(where, "a medium is left out; media are not modelled");
    params.ignore_all();
}

bool PbrtReader::medium_interface(const PbrtToken& token) {
    if (token.text != "MediumInterface") return false;
    bool is_empty = name_argument().empty();
    // The exterior medium may be left out.
    if (tokens_.peek().kind == PbrtToken::kString) is_empty = name_argument().empty() && is_empty;
    if (!is_empty) loading_.warn(token.where(), "media are not modelled; the space is empty");
    return true;
}

bool PbrtReader::directive(const PbrtToken& token) {
    return block_directive(token) || transform_directive(token) || plugin_directive(token) ||
           v4_directive(token);
}

/// The world of pbrt-v4 has no end of its own.
void PbrtReader::end_of_file(const PbrtToken& token) {
    if (!is_v4_ || !in_world_) fail(token.where(), "the file ends before WorldEnd");
    if (!saved_.empty()) fail(saved_.back().where, "this block does not end before the file does");
}

void PbrtReader::read_scene(const std::string& path) {
    main_path_ = path;
    tokens_.push(path, "");
    while (!world_ended_) {
        const PbrtToken token = tokens_.next();
        if (token.kind == PbrtToken::kEnd) {
            end_of_file(token);
            break;
        }
        if (token.kind != PbrtToken::kWord || !directive(token))
            fail(token.where(),
                 "a directive must stand here, got '" + std::string(token.text.substr(0, 40)) + "'");
    }
    finish_camera();
    // What no directive of its kind has read
    PbrtParams::List unread = std::move(defaults_);
    std::erase_if(unread, [](const auto& p) { return p->is_read; });
    warn_unread(unread, "Attribute");
}

void load_pbrt(const std::string& path, Loading& loading) { PbrtReader(loading).read_scene(path); }

}  // namespace viscache::loading
