// pbrt-v3 text: shapes, lights, camera and film.
#include "viscache/scene/pbrt_reader.h"

namespace viscache::loading {

namespace {

constexpr Rgb kOne{1, 1, 1};

Mesh inline_mesh(const PbrtParams& params, const std::string& where) {
    Mesh mesh;
    mesh.vertices = params.vec3s("P");
    const PbrtParam* indices = params.find("indices");
    if (mesh.vertices.empty() || !indices) fail(where, "a triangle mesh needs P and indices");
    if (indices->numbers.empty() || indices->numbers.size() % 3)
        fail(indices->where, "'indices' must be triples");
    const size_t n = mesh.vertices.size();
    std::vector<uint32_t> flat;
    for (double x : indices->numbers) {
        if (!(x >= 0 && x < double(n)) || x != std::floor(x))
            fail(indices->where, "'indices' holds " + std::to_string(x) + ", the mesh has " +
                                     std::to_string(n) + " vertices");
        flat.push_back(uint32_t(x));
    }
    for (size_t i = 0; i < flat.size(); i += 3) mesh.triangles.push_back({flat[i], flat[i + 1], flat[i + 2]});
    mesh.normals = params.vec3s("N");
    mesh.uvs = params.vec2s(params.has("uv") ? "uv" : "st");
    return mesh;
}

}  // namespace

std::optional<Mesh> PbrtReader::shape_mesh(const std::string& type, const PbrtParams& params,
                                           const std::string& where) {
    if (type == "trianglemesh") return inline_mesh(params, where);
    if (type == "loopsubdiv") {
        loading_.warn(where, "'loopsubdiv' is not modelled; its control mesh is used");
        return inline_mesh(params, where);
    }
    if (type == "plymesh") {
        const PbrtParam* file = params.find("filename");
        if (!file) fail(where, "a plymesh needs a filename");
        const std::string path = path_named(params.string("filename", ""), file->where);
        return read_ply(path, file->where);
    }
    if (type == "sphere") {
        const double radius = params.number("radius", 1);
        if (!(radius > 0)) fail(where, "the radius of a sphere must be > 0");
        if (params.has("zmin") || params.has("zmax") || params.has("phimax"))
            loading_.warn(where, "partial spheres are not modelled; the whole sphere is used");
        return sphere_mesh({0, 0, 0}, float(radius));
    }
    if (type == "disk") {
        if (params.has("innerradius") || params.has("phimax"))
            loading_.warn(where, "partial disks are not modelled; the whole disk is used");
        Mesh mesh = disk_mesh();
        const float radius = float(params.number("radius", 1)), height = float(params.number("height", 0));
        if (!(radius > 0)) fail(where, "the radius of a disk must be > 0");
        for (Vec3& p : mesh.vertices) p = {p.x * radius, p.y * radius, height};
        return mesh;
    }
    return {};
}

/// pbrt keeps normals on their side in mirrored transforms. Shading normals, if given, determine the side of
/// a triangle.
void PbrtReader::orient(Mesh& mesh) {
    const bool mirrored = now_.ctm.determinant() < 0;
    transform_mesh(mesh, now_.ctm);
    if (mesh.normals.empty()) {
        if (mirrored != now_.reversed) flip_winding(mesh);
        return;
    }
    wind_by_normals(mesh);
    if (now_.reversed) flip_normals(mesh);
}

/// True if the shape is a full sphere that emits outwards.
bool PbrtReader::sphere_light(const PbrtParams& params, const std::string& where) {
    const auto scale = uniform_scale(now_.ctm);
    if (!now_.area_light || object_ || !scale || now_.reversed) return false;
    const double radius = params.number("radius", 1);
    if (!(radius > 0)) fail(where, "the radius of a sphere must be > 0");
    loading_.scene.sphere_lights.push_back(
        {now_.ctm.point({0, 0, 0}), float(radius * *scale), now_.area_light->radiance});
    return true;
}

/// The current material, or a copy of it with the alpha cut-out of the shape.
int PbrtReader::shape_material(const PbrtParams& params, const std::string& where) {
    if (now_.material == kNoMaterial) now_.material = loading_.add_material({});
    const PbrtParam* alpha = params.find("alpha");
    if (!alpha) return now_.material;
    const PbrtTexture t = color_texture(params, "alpha", kOne);
    if (t.image < 0 && t.color.x >= 1) return now_.material;
    Material m = loading_.scene.materials[size_t(now_.material)];
    if (t.image < 0) m.opacity = t.color.x;
    m.alpha_texture = t.image;
    return loading_.add_material(m);
}

void PbrtReader::shape(const std::string& where) {
    const std::string type = name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    if (now_.material == kNoSurface)
        return loading_.warn(where, "a shape without a surface (material \"none\") is skipped");
    // An alpha of 0 makes a shape invisible
    if (const PbrtParam* alpha = params.find("alpha"); alpha && alpha->numbers == std::vector<double>{0})
        return;
    if (type == "sphere" && sphere_light(params, where)) return;
    auto mesh = shape_mesh(type, params, where);
    if (!mesh) return loading_.warn(where, "shape '" + type + "' is not modelled; skipped");
    // Indices and normals must be valid before the winding is changed.
    check_mesh(*mesh, where);
    orient(*mesh);
    mesh->material = shape_material(params, where);
    mesh->in_world = object_ == nullptr;
    if (now_.area_light && object_) {
        loading_.warn(where, "emission inside an object is not modelled (as in pbrt); skipped");
    } else if (now_.area_light) {
        mesh->emission = now_.area_light->radiance;
        mesh->emits_two_sided = now_.area_light->two_sided;
    }
    const int index = loading_.add_mesh(std::move(*mesh), where);
    if (object_) object_->push_back(index);
}

void PbrtReader::area_light(const std::string& where) {
    const std::string type = name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    if (type != "diffuse" && type != "area")
        return loading_.warn(where, "area light '" + type + "' is not modelled; skipped");
    if (params.has("power")) loading_.warn(where, "'power' of an area light is not modelled; L is used");
    now_.area_light =
        AreaLight{color(params, "L", kOne) * color(params, "scale", kOne), params.boolean("twosided", false)};
}

void PbrtReader::infinite_light(const PbrtParams& params, const std::string& where) {
    Environment env;
    env.scale = color(params, "L", kOne) * color(params, "scale", kOne);
    const char* const name = params.has("mapname") ? "mapname" : "filename";
    if (const PbrtParam* map = params.find(name)) {
        const std::string path = path_named(params.string(name, ""), map->where);
        env.image = loading_.add_image(path, map->where, true);
    }
    // pbrt's map has z up and its column from atan2(y, x). Ours has y up and the column from atan2(x, -z).
    Affine ours_to_pbrt;
    ours_to_pbrt.m = {{{0, 0, -1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}}};
    env.to_world = now_.ctm * ours_to_pbrt;
    loading_.set_environment(env, where);
}

void PbrtReader::light(const std::string& where) {
    const std::string type = name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    if (params.has("power")) loading_.warn(where, "'power' of a light is not modelled; ignored");
    if (type == "point") {
        const Vec3 position = now_.ctm.point(params.point("from", {0, 0, 0}));
        loading_.scene.point_lights.push_back(
            {position, color(params, "I", kOne) * color(params, "scale", kOne)});
    } else if (type == "distant") {
        const Vec3 towards = now_.ctm.vector(params.point("from", {0, 0, 0}) - params.point("to", {0, 0, 1}));
        if (length2(towards) == 0) fail(where, "a distant light needs two different points");
        loading_.scene.directional_lights.push_back(
            {normalize(towards), color(params, "L", kOne) * color(params, "scale", kOne)});
    } else if (type == "infinite" || type == "exinfinite") {
        infinite_light(params, where);
    } else {
        loading_.warn(where, "light '" + type + "' is not modelled; skipped");
    }
}

void PbrtReader::camera(const std::string& where) {
    const std::string type = name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    const auto to_world = inverse_of(now_.ctm);
    if (!to_world) fail(where, "the camera's transform has no inverse");
    coordinate_systems_["camera"] = *to_world;
    if (type != "perspective") return loading_.warn(where, "camera '" + type + "' is not modelled; skipped");
    if (params.has("frameaspectratio") || params.has("screenwindow"))
        loading_.warn(where, "screen windows are not modelled; the film's shape is used");
    if (params.number("lensradius", 0) > 0)
        loading_.warn(where, "depth of field is not modelled; a pinhole is used");
    Camera c;
    c.origin = to_world->point({0, 0, 0});
    c.right = normalize(to_world->vector({1, 0, 0}));
    c.up = normalize(to_world->vector({0, 1, 0}));
    c.forward = normalize(to_world->vector({0, 0, 1}));
    camera_fov_ = float(params.number("fov", params.has("halffov") ? 2 * params.number("halffov", 45) : 90));
    if (!(camera_fov_ > 0 && camera_fov_ < 180)) fail(where, "the field of view must be in (0, 180) degrees");
    camera_ = c;
}

void PbrtReader::film(const std::string& where) {
    name_argument();
    const PbrtParams params = PbrtParams::read(tokens_);
    film_width_ = params.integer("xresolution", film_width_);
    film_height_ = params.integer("yresolution", film_height_);
    if (film_width_ < 1 || film_height_ < 1) fail(where, "the film's resolution must be >= 1");
    if (params.has("cropwindow")) loading_.warn(where, "a crop is not modelled; the whole film is used");
}

void PbrtReader::finish_camera() {
    if (!camera_) return;
    camera_->width = film_width_;
    camera_->height = film_height_;
    // fov spans the shorter side.
    camera_->fov_is_horizontal = film_width_ < film_height_;
    camera_->fov_y_rad = camera_fov_ * kPi / 180.f;
    loading_.scene.cameras.push_back(*camera_);
}

}  // namespace viscache::loading
