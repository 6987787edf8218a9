// Mitsuba XML: converts shapes to meshes, sphere lights and instances.
#include "viscache/formats/mitsuba_reader.h"
#include "viscache/scene/face_colors.h"

namespace viscache::loading {

namespace {

bool is_generated(const std::string& type) {
    return type == "rectangle" || type == "cube" || type == "disk" || type == "cylinder";
}

/// Share of the area whose faces have a vertex normal that points behind them.
double leaning_share(const Mesh& mesh) {
    double leaning = 0, area = 0;
    for (Vec3u t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t.x], normal = cross(mesh.vertices[t.y] - a, mesh.vertices[t.z] - a);
        const double size = double(length(normal));
        area += size;
        if (std::min({dot(mesh.normals[t.x], normal), dot(mesh.normals[t.y], normal),
                      dot(mesh.normals[t.z], normal)}) < 0)
            leaning += size;
    }
    return area > 0 ? leaning / area : 0;
}

}  // namespace

Mesh MitsubaReader::serialized_mesh(Node node, const std::string& path) {
    const auto [found, is_new] = serialized_.try_emplace(path);
    if (is_new) found->second = read_file(path, where(node));
    const int index = integer(node, "shape_index", 0);
    if (index < 0) fail_at(node, "shape_index must be >= 0, got " + std::to_string(index));
    return read_serialized(path, found->second, size_t(index));
}

/// An open tube from p0 to p1, facing outwards.
Mesh MitsubaReader::cylinder(Node node) {
    const Vec3 p0 = vector(node, "p0").value_or(Vec3{0, 0, 0}),
               p1 = vector(node, "p1").value_or(Vec3{0, 0, 1});
    const double radius = number(node, "radius", 1);
    if (!(radius > 0)) fail_at(node, "the radius of a cylinder must be > 0");
    if (p0 == p1) fail_at(node, "the ends of a cylinder must differ");
    Mesh mesh = revolved_mesh({{radius, 0, 0, 1}, {radius, length(p1 - p0), 0, 1}});
    const Frame3 frame = frame_around(normalize(p1 - p0));
    const Vec3 columns[4] = {frame.x, frame.y, frame.z, p0};
    Affine place;
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 3; ++i) place.m[i][j] = columns[j][i];
    transform_mesh(mesh, place);
    return mesh;
}

/// The mesh of a file; empty if the file is not there and may be left out.
std::optional<Mesh> MitsubaReader::mesh_file(Node node, const std::string& type, FileColors& colors) {
    const std::string path = path_of(node);
    if (!loading_.has_mesh_file(path, where(node))) {
        use_rest(node);
        return {};
    }
    if (type == "serialized") return serialized_mesh(node, path);
    Mesh mesh = type == "obj" ? read_obj(path, loading_, false, where(node)).at(0)
                              : read_ply(path, loading_, where(node), &colors);
    // Row 0 of an image is v = 0 in Mitsuba. Its OBJ reader flips v unless told otherwise.
    if (!boolean(node, "flip_tex_coords", type == "obj"))
        for (Vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
    return mesh;
}

/// `has_image`: the mesh needs texture coordinates.
std::optional<Mesh> MitsubaReader::shape_mesh(Node node, const std::string& type, bool has_image,
                                              FileColors& colors) {
    if (type == "obj" || type == "ply" || type == "serialized") return mesh_file(node, type, colors);
    if (!is_generated(type)) {
        skip(node, "shape '" + type + "' is not modelled; skipped");
        return {};
    }
    Mesh mesh = type == "rectangle"  ? rectangle_mesh()
                : type == "cube"     ? cube_mesh()
                : type == "cylinder" ? cylinder(node)
                : has_image          ? polar_disk_mesh()
                                     : disk_mesh();
    for (Vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
    return mesh;
}

/// The attribute that the material names. Colours of a file count for nothing without one.
void MitsubaReader::set_colors(Node node, Mesh& mesh, FileColors& colors, const std::string& attribute) {
    if (attribute.empty()) return;
    if (attribute == "vertex_color" && !colors.vertices.empty())
        mesh.colors = std::move(colors.vertices);
    else if (attribute == "face_color" && !colors.faces.empty())
        color_faces(mesh, colors.faces);
    else
        warn_at(node,
                "the shape lacks the attribute that its material names, or it is none of vertex_color and "
                "face_color of a PLY file; white is used");
    if (colors.clamped) warn_at(node, kClampedColors);
    for (VertexColor& c : mesh.colors) c.a = 255;  // only its colour is asked for
}

void MitsubaReader::sphere(Node node, const ColorTexture& emission, int material, bool in_group,
                           std::vector<int>* group) {
    const Vec3 center = vector(node, "center").value_or(Vec3{0, 0, 0});
    const double radius = number(node, "radius", 1);
    if (!(radius > 0)) fail_at(node, "the radius of a sphere must be > 0");
    const Affine to_world = transform(node);
    const auto scale = uniform_scale(to_world);
    // A transform that mirrors turns a sphere inside out, as in Mitsuba 3: its radius becomes negative.
    const bool flipped = boolean(node, "flip_normals", false) != (to_world.determinant() < 0);
    const bool emits = max_component(emission.color) > 0 && !in_group;
    if (emits && emission.image < 0 && scale && !flipped) {
        loading_.scene.sphere_lights.push_back(
            {to_world.point(center), float(radius * *scale), emission.color});
        return;
    }
    Mesh mesh = sphere_mesh(center, float(radius));
    FileColors none;
    set_colors(node, mesh, none, material_attribute_[material]);
    transform_uvs(mesh, material_uv_[material]);
    transform_mesh(mesh, to_world);
    if (to_world.determinant() < 0) flip_winding(mesh);
    if (flipped) flip_normals(mesh);
    mesh.name = attribute(node, "id");
    mesh.material = material;
    mesh.in_world = !in_group;
    if (emits) {
        mesh.emission = emission.color;
        mesh.emission_texture = emission.image;
        warn_at(node,
                "an emitting sphere that is stretched, turned inside out or has an image is tessellated");
    }
    const int index = loading_.add_mesh(std::move(mesh), where(node));
    if (group) group->push_back(index);
}

void MitsubaReader::add_shape(Node node, std::vector<int>* group) {
    const std::string type = type_of(node);
    use(node);
    const int material = material_of(node);
    ColorTexture emission = area_emission(node);
    if (group && max_component(emission.color) > 0) {
        warn_at(node, "emission inside a shapegroup is not modelled; skipped");
        emission = {{0, 0, 0}};
    }
    for (const Node child : node.children()) {
        const bool is_ref = std::string_view(child.name()) == "ref";
        if (std::string_view((is_ref ? target_of(child) : child).name()) != "medium") continue;
        use(child);
        skip(child, "media are not modelled; skipped");
    }
    if (material < 0) return skip(node, "a shape with the bsdf 'null' is skipped");
    if (type == "sphere") return sphere(node, emission, material, group != nullptr, group);
    const bool has_image = uses_image(loading_.scene.materials[size_t(material)]) || emission.image >= 0;
    FileColors colors;
    auto mesh = shape_mesh(node, type, has_image, colors);
    if (!mesh) return;
    if (property(node, "max_smooth_angle"))
        warn_at(node, "'maxSmoothAngle' is not modelled; the normals of the file are kept");
    if (boolean(node, "face_normals", false)) mesh->normals.clear();
    const Affine to_world = transform(node);
    transform_mesh(*mesh, to_world);
    // Files without normals are smooth, with the front where their winding says
    if (mesh->normals.empty() && !is_generated(type) && !boolean(node, "face_normals", false))
        smooth_normals(*mesh);
    // After the normals, which are those of shared vertices
    set_colors(node, *mesh, colors, material_attribute_[material]);
    if (has_image && mesh->uvs.empty()) {
        check_mesh(*mesh, where(node));
        add_triangle_uvs(*mesh, {CornerUvs{{{0, 1}, {1, 1}, {0, 0}}}});
    }
    transform_uvs(*mesh, material_uv_[material]);
    // The front is where the normals point, also under a transform that mirrors. Files without normals have
    // it where their winding says.
    if (is_generated(type) && to_world.determinant() < 0) {
        flip_winding(*mesh);
        if (type == "cylinder" && max_component(emission.color) > 0)
            warn_at(node, "a mirrored cylinder shines outwards; Mitsuba 3 samples its light inwards");
    }
    if (!mesh->normals.empty()) {
        check_mesh(*mesh, where(node));
        wind_by_normals(*mesh);
        if (leaning_share(*mesh) > 0.01)
            warn_at(
                node,
                "vertex normals point behind their faces; unlike in Mitsuba, they are turned to the front");
    }
    if (boolean(node, "flip_normals", false)) flip_normals(*mesh);
    if (const std::string id = attribute(node, "id"); !id.empty()) mesh->name = id;
    mesh->material = material;
    mesh->emission = emission.color;
    mesh->emission_texture = emission.image;
    mesh->in_world = group == nullptr;
    const int index = loading_.add_mesh(std::move(*mesh), where(node));
    if (group) group->push_back(index);
}

const std::vector<int>& MitsubaReader::group_meshes(Node node) {
    const auto [found, is_new] = groups_.try_emplace(node.hash_value());
    use(node);
    if (is_new)
        for (const Node child : node.children()) {
            if (std::string_view(child.name()) != "shape") continue;
            const std::string type = type_of(child);
            if (type == "instance" || type == "shapegroup")
                fail_at(child, "a shapegroup must not hold instances or groups");
            add_shape(child, &found->second);
        }
    return found->second;
}

void MitsubaReader::instance(Node node) {
    Node group;
    use(node);
    for (const Node child : node.children()) {
        const std::string_view tag = child.name();
        if (tag != "ref" && tag != "shape") continue;
        use(child);
        group = tag == "ref" ? target_of(child) : child;
    }
    if (!group || type_of(group) != "shapegroup") fail_at(node, "an instance must refer to a shapegroup");
    const auto& meshes = group_meshes(group);
    if (!meshes.empty()) loading_.scene.instances.push_back({meshes, transform(node)});
}

void MitsubaReader::shape(Node node) {
    const std::string type = type_of(node);
    if (type == "shapegroup") return;  // read when an instance places it
    if (type == "instance") return instance(node);
    add_shape(node, nullptr);
}

}  // namespace viscache::loading
