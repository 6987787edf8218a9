// pbrt text: shapes and lights.
#include "viscache/formats/pbrt_reader.h"

namespace viscache::loading {

namespace {

/// The corners of patches of `n` corners.
std::vector<uint32_t> corners(const PbrtParam& indices, size_t n, size_t vertices) {
    if (indices.numbers.empty() || indices.numbers.size() % n)
        fail(indices.where, n == 3 ? "'indices' must be triples" : "'indices' must be fours");
    std::vector<uint32_t> flat;
    for (double x : indices.numbers) {
        // The tokens are doubles: a fraction must not be cut to the vertex below
        if (!(x >= 0 && x < double(vertices)) || x != std::floor(x))
            fail(indices.where, "'indices' holds " + std::to_string(x) + ", the mesh has " +
                                    std::to_string(vertices) + " vertices");
        flat.push_back(uint32_t(x));
    }
    return flat;
}

void add_triangles(Mesh& mesh, const PbrtParam& indices) {
    const auto flat = corners(indices, 3, mesh.vertices.size());
    for (size_t i = 0; i < flat.size(); i += 3) mesh.triangles.push_back({flat[i], flat[i + 1], flat[i + 2]});
}

Mesh inline_mesh(const PbrtParams& params, const std::string& where) {
    Mesh mesh;
    mesh.vertices = params.vec3s("P");
    const PbrtParam* indices = params.find("indices");
    const bool is_one = !indices && mesh.vertices.size() == 3;  // pbrt-v4: a triangle needs no indices
    if (mesh.vertices.empty() || (!indices && !is_one)) fail(where, "a triangle mesh needs P and indices");
    if (is_one)
        mesh.triangles = {{0, 1, 2}};
    else
        add_triangles(mesh, *indices);
    mesh.normals = params.vec3s("N");
    // Older files say "st"
    mesh.uvs = params.vec2s(params.has("uv") ? "uv" : "st");
    return mesh;
}

/// The area of a light: a shape, or a triangle of a mesh, to each of which pbrt gives the power of the light.
struct LightArea {
    double mean;
    bool is_even;  ///< of all triangles of the mesh
};

LightArea light_area(const Mesh& mesh, const std::string& type) {
    const bool is_mesh = type == "trianglemesh" || type == "plymesh" || type == "loopsubdiv";
    // A patch is two triangles here, and one light in pbrt
    const size_t count = mesh.triangles.size(), each = is_mesh ? 1 : type == "bilinearmesh" ? 2 : count;
    double sum = 0, least = std::numeric_limits<double>::infinity(), most = 0;
    for (size_t i = 0; i < count; i += each) {
        double area = 0;
        for (size_t k = i; k < i + each; ++k) {
            const Vec3u t = mesh.triangles[k];
            const Vec3 a = mesh.vertices[t.x];
            // In the world: the mesh is transformed already
            area += length(cross(mesh.vertices[t.y] - a, mesh.vertices[t.z] - a)) / 2;
        }
        sum += area;
        least = std::min(least, area);
        most = std::max(most, area);
    }
    return {sum * double(each) / double(count), most <= 1.01 * least};
}

}  // namespace

std::optional<Mesh> PbrtReader::shape_mesh(const std::string& type, const PbrtParams& params,
                                           const std::string& where) {
    if (type == "trianglemesh") return inline_mesh(params, where);
    if (type == "loopsubdiv") {
        params.ignore({"levels", "nlevels", "scheme"});
        loading_.warn(where, "'loopsubdiv' is not modelled; its control mesh is used");
        return inline_mesh(params, where);
    }
    if (type == "bilinearmesh") return bilinear_mesh(params, where);
    if (type == "plymesh") {
        const PbrtParam* file = params.find("filename");
        if (!file) fail(where, "a plymesh needs a filename");
        const std::string path = path_named(params.string("filename", ""), file->where);
        // A missing file is an error or a warning, as the caller of the loader wishes
        if (!loading_.has_mesh_file(path, file->where)) return {};
        return read_ply(path, loading_, file->where);
    }
    // Spheres, disks and cylinders become triangles
    if (auto mesh = round_shape(type, params, where)) return mesh;
    loading_.warn(where, "shape '" + type + "' is not modelled; skipped");
    return {};
}

/// Patches of four corners, each as two triangles.
Mesh PbrtReader::bilinear_mesh(const PbrtParams& params, const std::string& where) {
    Mesh mesh;
    mesh.vertices = params.vec3s("P");
    const PbrtParam* indices = params.find("indices");
    if (mesh.vertices.empty() || (!indices && mesh.vertices.size() != 4))
        fail(where, "a bilinear mesh needs P and indices");
    const auto flat =
        indices ? corners(*indices, 4, mesh.vertices.size()) : std::vector<uint32_t>{0, 1, 2, 3};
    bool flat_patches = true;
    for (size_t i = 0; i < flat.size(); i += 4) {
        const uint32_t p00 = flat[i], p10 = flat[i + 1], p01 = flat[i + 2], p11 = flat[i + 3];
        // pbrt's corners are in the order of (0, 0), (1, 0), (0, 1), (1, 1)
        mesh.triangles.push_back({p00, p10, p11});
        mesh.triangles.push_back({p00, p11, p01});
        const Vec3 a = mesh.vertices[p10] - mesh.vertices[p00], b = mesh.vertices[p01] - mesh.vertices[p00],
                   c = mesh.vertices[p11] - mesh.vertices[p00];
        const float size = length(a) * length(b) * length(c);
        // The volume that the corners span, relative to its edges: 0 for a plane
        flat_patches = flat_patches && std::fabs(dot(cross(a, b), c)) <= 1e-4f * size;
    }
    mesh.normals = params.vec3s("N");
    mesh.uvs = params.vec2s("uv");
    // A patch has its own coordinates where none are given
    if (mesh.uvs.empty() && flat.size() == 4 && mesh.vertices.size() == 4) {
        mesh.uvs.resize(4);
        for (uint32_t k = 0; k < 4; ++k) mesh.uvs[flat[k]] = {float(k % 2), float(k / 2)};
    }
    if (!flat_patches) loading_.warn(where, "curved patches are not modelled; each is two triangles");
    return mesh;
}

/// The texture coordinates that pbrt gives to shapes without.
void PbrtReader::add_default_uvs(Mesh& mesh, const std::string& type, const PbrtParams& params) {
    if (!mesh.uvs.empty()) return;
    const CornerUvs triangle{{{0, 0}, {1, 0}, {1, 1}}}, other_half{{{0, 0}, {1, 1}, {0, 1}}};
    if (type == "disk")
        mesh = textured_disk(params);
    else if (type == "bilinearmesh")
        add_triangle_uvs(mesh, {triangle, other_half});
    else
        add_triangle_uvs(mesh, {triangle});
}

/// pbrt keeps normals on their side in mirrored transforms. Shading normals, if given, determine the side of
/// a triangle.
void PbrtReader::orient(Mesh& mesh) {
    const bool mirrored = now_.ctm.determinant() < 0;
    transform_mesh(mesh, now_.ctm);
    if (mesh.normals.empty()) {
        // The winding gives the side. ReverseOrientation and a mirror cancel
        if (mirrored != now_.reversed) flip_winding(mesh);
        return;
    }
    // Normals first, then the side that the file asks for
    wind_by_normals(mesh);
    if (now_.reversed) flip_normals(mesh);
}

/// True if the shape is a full sphere that emits outwards.
bool PbrtReader::sphere_light(const PbrtParams& params, const std::string& where) {
    const auto scale = uniform_scale(now_.ctm);
    // Our sphere lights have one radius, one colour, and shine outwards; all else becomes a mesh
    if (!now_.area_light || now_.area_light->image >= 0 || object_ || !scale || now_.reversed ||
        !is_whole_sphere(params))
        return false;
    const double radius = params.number("radius", 1);
    if (!(radius > 0)) fail(where, "the radius of a sphere must be > 0");
    const double r = radius * *scale, area = 12.566370614359172 * r * r;
    loading_.scene.sphere_lights.push_back(
        {now_.ctm.point({0, 0, 0}), float(r), radiance(*now_.area_light, area)});
    return true;
}

/// The alpha of a shape that has holes. In pbrt-v3 only meshes have one, whose holes are where it is exactly
/// 0; in pbrt-v4 it is the share of rays that meet the surface.
std::optional<PbrtTexture> PbrtReader::shape_alpha(const std::string& type, const PbrtParams& params) {
    if (!params.has("alpha") || (!is_v4_ && type != "trianglemesh" && type != "plymesh")) return {};
    const PbrtTexture t = color_texture(params, "alpha", kOne);
    if (t.image < 0 && t.color.x >= (is_v4_ ? 1 : std::numeric_limits<float>::min())) return {};
    return t;
}

/// The current material, or a copy of it with the alpha of the shape.
int PbrtReader::shape_material(const std::optional<PbrtTexture>& alpha, const std::string& where) {
    if (now_.material == kNoMaterial) now_.material = loading_.add_material({});
    if (!alpha) return now_.material;
    const PbrtTexture& t = *alpha;
    // A copy: other shapes have the same material without the cut-out
    Material m = loading_.scene.materials[size_t(now_.material)];
    if (t.image < 0 || is_v4_) m.opacity = std::min(1.f, t.color.x);
    m.alpha_texture = t.image;
    if (t.image >= 0) m.alpha_cutoff = is_v4_ ? -1 : std::numeric_limits<float>::min();
    if (t.image >= 0 && t.color.x > 1)
        loading_.warn(where, "a factor above 1 of an image of alpha is not modelled; 1 is used");
    const int index = loading_.add_material(m);
    // The base colour is seen more clearly than the edges of holes
    material_uv_[index] = m.base_texture >= 0 ? material_uv_[now_.material] : t.uv;
    if (material_uv_[index] != t.uv)
        loading_.warn(where,
                      "the images of a material share one transform of texture coordinates; that of the "
                      "base colour is used");
    return index;
}

void PbrtReader::shape(const Names& names, const PbrtParams& params, const std::string& where) {
    const std::string& type = names[0];
    // Directions of tangents, which no material has here, and numbers of faces for textures by face
    params.ignore({"S", "discarddegenerateUVs", "faceIndices"});
    if (now_.material == kNoSurface) {
        params.ignore_all();
        // It bounds media alone. In pbrt-v4 it sheds no light, in v3 it does
        if (now_.area_light && !is_v4_)
            return loading_.warn(where, "an area light without a surface is not modelled; skipped");
        return loading_.note(where, "a shape without a surface (material \"none\") is skipped");
    }
    const auto alpha = shape_alpha(type, params);
    const bool is_unseen = alpha && alpha->image < 0 && !(alpha->color.x > 0);
    if (now_.area_light && object_) loading_.note(where, "emission inside an object is left out, as in pbrt");
    const bool shines = now_.area_light && !object_;
    if (is_unseen && !shines) return params.ignore_all();
    if (type == "sphere" && !alpha && sphere_light(params, where)) return;
    auto mesh = shape_mesh(type, params, where);
    if (!mesh) return params.ignore_all();
    // Indices and normals must be valid before the winding is changed.
    check_mesh(*mesh, where);
    mesh->material = shape_material(alpha, where);
    const bool shines_image = shines && now_.area_light->image >= 0;
    // Coordinates cost memory, so only meshes with an image get those that pbrt makes up
    if (shines_image || uses_image(loading_.scene.materials[size_t(mesh->material)]))
        add_default_uvs(*mesh, type, params);
    orient(*mesh);
    transform_uvs(*mesh, material_uv_[mesh->material]);
    mesh->in_world = object_ == nullptr;
    if (shines) {
        // Without any alpha left it is a light as a whole that is not seen, as in pbrt
        if (alpha && is_v4_ && !is_unseen)
            loading_.warn(where, "an area light with holes lights as if it had none");
        const LightArea area = light_area(*mesh, type);
        if (now_.area_light->power > 0 && !area.is_even)
            loading_.warn(where,
                          "a light of one power per triangle is not modelled; they share the power evenly");
        mesh->emission = radiance(*now_.area_light, area.mean);
        mesh->emission_texture = now_.area_light->image;
        mesh->emits_two_sided = now_.area_light->two_sided;
    }
    const int index = loading_.add_mesh(std::move(*mesh), where);
    // Meshes of an object are placed by its instances
    if (object_) object_->push_back(index);
}

/// The radiance that a light of this area has.
Rgb PbrtReader::radiance(const AreaLight& light, double area) const {
    if (!(light.power > 0) || !(area > 0)) return light.radiance;
    // Power of a Lambertian emitter: π·A·L per side
    return light.radiance * float(light.power / (area * kPi * (light.two_sided ? 2 : 1)));
}

void PbrtReader::area_light(const Names& names, const PbrtParams& params, const std::string& where) {
    const std::string& type = names[0];
    if (type != "diffuse" && type != "area") {
        params.ignore_all();
        return loading_.warn(where, "area light '" + type + "' is not modelled; skipped");
    }
    params.ignore({"samples", "nsamples"});  // of pbrt's own sampling
    AreaLight light{color(params, "L", kOne) * color(params, "scale", kOne),
                    params.boolean("twosided", false)};
    light.power = params.number("power", 0);
    if (const PbrtParam* file = params.find("filename")) {
        light.image =
            loading_.add_image(path_named(params.string("filename", ""), file->where), file->where, true);
        if (light.power > 0)
            loading_.warn(where, "the power of a light with an image is not modelled; its scale is used");
        // Its mean radiance would be needed, which is known when the image is decoded, later
        light.power = 0;
    }
    now_.area_light = light;
}

void PbrtReader::infinite_light(const PbrtParams& params, const std::string& where) {
    Environment env;
    env.scale = color(params, "L", kOne) * color(params, "scale", kOne);
    const char* const name = params.has("mapname") ? "mapname" : "filename";
    if (params.find("portal")) loading_.warn(where, "portals are not modelled; the whole sky shines");
    // That of an image would need its pixels, which are read later
    const double illuminance = params.has(name) ? 0 : params.number("illuminance", 0);
    // A constant sky of radiance L gives an upward surface π·L
    if (illuminance > 0) env.scale = env.scale * float(illuminance / kPi);
    if (is_v4_ && params.find(name))
        return loading_.warn(where,
                             "environment maps of pbrt-v4 (equal-area squares) are not modelled; skipped");
    if (const PbrtParam* map = params.find(name)) {
        const std::string path = path_named(params.string(name, ""), map->where);
        env.image = loading_.add_image(path, map->where, true);
    }
    // pbrt's map has z up and its column from atan2(y, x). Ours has y up and the column from atan2(x, -z).
    Affine ours_to_pbrt;
    ours_to_pbrt.m = {{{0, 0, -1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}}};
    env.to_world = now_.ctm * ours_to_pbrt;
    loading_.add_environment(env, where);
}

void PbrtReader::spot_light(const PbrtParams& params, const std::string& where) {
    const Vec3 from = params.point("from", {0, 0, 0}), to = params.point("to", {0, 0, 1});
    const Vec3 axis = normalize(now_.ctm.vector(to - from));
    const double outer = params.number("coneangle", 30),
                 // pbrt names the width of the border, we name the angle where it begins
        inner = std::max(0.0, outer - params.number("conedeltaangle", 5));
    if (length2(axis) == 0) fail(where, "a spot light needs two different points");
    if (!(outer > 0 && outer <= 180 && inner <= outer))
        fail(where, "a spot light needs 0 < coneangle <= 180 and conedeltaangle >= 0");
    // Versions differ in how light falls off between both angles
    const SpotCone cone{is_v4_ ? Falloff::kSmooth : Falloff::kQuartic, axis, float(std::cos(inner * kDegree)),
                        float(std::cos(outer * kDegree))};
    const double power = params.number("power", 0);
    const Rgb intensity = color(params, "I", kOne) * color(params, "scale", kOne) *
                          // Power of all of the cone
                          float(power > 0 ? power / spot_integral(cone) : 1);
    loading_.scene.point_lights.push_back({now_.ctm.point(from), intensity, cone});
}

void PbrtReader::light(const Names& names, const PbrtParams& params, const std::string& where) {
    const std::string& type = names[0];
    params.ignore({"samples", "nsamples"});  // of pbrt's own sampling
    if (type == "point") {
        const Vec3 position = now_.ctm.point(params.point("from", {0, 0, 0}));
        const double power = params.number("power", 0);
        loading_.scene.point_lights.push_back(
            {position, color(params, "I", kOne) * color(params, "scale", kOne) *
                           // Power over all directions
                           float(power > 0 ? power / (4 * kPi) : 1)});
    } else if (type == "spot") {
        spot_light(params, where);
    } else if (type == "distant") {
        const Vec3 towards = now_.ctm.vector(params.point("from", {0, 0, 0}) - params.point("to", {0, 0, 1}));
        if (length2(towards) == 0) fail(where, "a distant light needs two different points");
        const double illuminance = params.number("illuminance", 0);
        loading_.scene.directional_lights.push_back(
            {normalize(towards), color(params, "L", kOne) * color(params, "scale", kOne) *
                                     float(illuminance > 0 ? illuminance : 1)});
    } else if (type == "infinite" || type == "exinfinite") {
        infinite_light(params, where);
    } else {
        params.ignore_all();
        loading_.warn(where, "light '" + type + "' is not modelled; skipped");
    }
}

}  // namespace viscache::loading
