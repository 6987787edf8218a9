// SceneDescription: a scene that loaders and Python fill before it is frozen.
#include <pybind11/native_enum.h>

#include "described.h"
#include "viscache/scene/description_bytes.h"

namespace viscache::bindings {

namespace {

/// A point of the world in the coordinates of the scene, rounded once.
// Subtracted in double: a scene a million units from the origin of the world keeps its millimetres.
Vec3 relative(const SceneDescription& d, const Point& p) {
    return {float(p[0] - d.origin[0]), float(p[1] - d.origin[1]), float(p[2] - d.origin[2])};
}

/// The same for an array (N, 3), which keeps its precision until then.
std::vector<Vec3> relative(const SceneDescription& d, const DoubleArray& points, const char* name) {
    require_rows(points, 3, name);
    std::vector<Vec3> out(size_t(points.shape(0)));
    const double* row = points.data();
    for (size_t i = 0; i < out.size(); ++i, row += 3) out[i] = relative(d, {row[0], row[1], row[2]});
    return out;
}

/// A transform to the coordinates of the scene.
Affine relative(const SceneDescription& d, Affine to_world) {
    // Only the translation moves: the directions of a transform know no origin.
    for (size_t i = 0; i < 3; ++i) to_world.m[i][3] -= d.origin[i];
    return to_world;
}

Affine affine_from(const DoubleArray& a) {
    // A last row of (0, 0, 0, 1) may be left out
    if (a.ndim() != 2 || a.shape(1) != 4 || (a.shape(0) != 3 && a.shape(0) != 4))
        throw py::value_error("to_world must have shape (3, 4) or (4, 4), got " + shape_text(a));
    Affine t;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) t.m[i][j] = a.at(i, j);
    return t;
}

int add_mesh(SceneDescription& d, const DoubleArray& vertices, const UintArray& triangles, int material,
             const std::optional<FloatArray>& normals, const std::optional<FloatArray>& uvs, Float3 emission,
             bool emits_two_sided, bool in_world, const std::string& name, int emission_texture) {
    Mesh mesh;
    mesh.name = name;
    mesh.material = material;
    mesh.emission = vec3(emission);
    mesh.emission_texture = emission_texture;
    mesh.emits_two_sided = emits_two_sided;
    mesh.in_world = in_world;
    // Meshes of instances have coordinates of their own, and their transforms are made relative.
    if (in_world)
        mesh.vertices = relative(d, vertices, "vertices");
    else
        mesh.vertices = relative({}, vertices, "vertices");  // its instances are placed
    require_rows(triangles, 3, "triangles");
    // Rows of three numbers without gaps, as the array type ensures
    const auto* t = reinterpret_cast<const Vec3u*>(triangles.data());
    mesh.triangles.assign(t, t + triangles.shape(0));
    if (normals) mesh.normals = vec3s(*normals, "normals");
    if (uvs) {
        require_rows(*uvs, 2, "uvs");
        const auto* uv = reinterpret_cast<const Vec2*>(uvs->data());
        mesh.uvs.assign(uv, uv + uvs->shape(0));
    }
    d.meshes.push_back(std::move(mesh));
    return int(d.meshes.size()) - 1;
}

SpotCone cone_from(Float3 axis, std::array<float, 2> cone_deg, const std::string& falloff) {
    const auto [inner, outer] = cone_deg;
    if (!(inner >= 0 && inner <= outer && outer > 0 && outer <= 180))
        throw py::value_error("cone_deg must be 0 <= inner <= outer <= 180, outer > 0, got " +
                              std::to_string(inner) + " and " + std::to_string(outer));
    const Vec3 unit = normalize(vec3(axis));
    // NaN fails too
    if (!(std::fabs(length(unit) - 1) < 1e-3f)) throw py::value_error("axis must not be zero or non-finite");
    // Number 0 is the falloff of lights without a cone.
    for (size_t i = 1; i < std::size(kFalloffNames); ++i)
        if (falloff == kFalloffNames[i])
            return {Falloff(i), unit, std::cos(inner * kPi / 180), std::cos(outer * kPi / 180)};
    throw py::value_error("falloff must be one of angle, quadratic, quartic, smooth, got " + falloff);
}

Wrap wrap_from(const std::string& name) {
    for (size_t i = 0; i < std::size(kWrapNames); ++i)
        if (name == kWrapNames[i]) return Wrap(i);
    throw py::value_error("wrap must be two of repeat, mirror, clamp, got " + name);
}

int add_image(SceneDescription& d, const FloatArray& pixels, bool nearest,
              const std::array<std::string, 2>& wrap) {
    Image image = image_from(pixels);
    image.nearest = nearest;
    image.wrap_u = wrap_from(wrap[0]);
    image.wrap_v = wrap_from(wrap[1]);
    d.images.push_back(std::move(image));
    return int(d.images.size()) - 1;
}

/// The pixels of an image that a loader has only named. Filters and wrapping stay as the loader has set them.
void set_image(SceneDescription& d, size_t index, const FloatArray& pixels) {
    Image &image = d.images.at(index), given = image_from(pixels);
    image.width = given.width;
    image.height = given.height;
    image.channels = given.channels;
    image.pixels = std::move(given.pixels);
    // Decoded floats take the place of bytes.
    image.bytes.clear();
}

void bind_meshes(py::class_<SceneDescription>& d) {
    d.def("add_mesh", &add_mesh, py::arg("vertices"), py::arg("triangles"), py::kw_only(),
          py::arg("material") = 0, py::arg("normals") = py::none(), py::arg("uvs") = py::none(),
          py::arg("emission") = Float3{0, 0, 0}, py::arg("emits_two_sided") = false,
          py::arg("in_world") = true, py::arg("name") = "", py::arg("emission_texture") = -1,
          "Add a triangle mesh: vertices (V, 3), triangles (T, 3) indices, normals (V, 3) unit, uvs (V, "
          "2),\n"
          "emission in W/(m²·sr), emission_texture the index of an image that multiplies it, -1 for none.\n"
          "Returns its index.");
}

/// In the order of the struct's members: a member that is added has a place in both lists.
void bind_materials(py::class_<SceneDescription>& d) {
    d.def(
        "add_material",
        [](SceneDescription& d, MaterialKind kind, Float3 base_color, Float3 specular, float roughness,
           float eta, bool two_sided, int base_texture, int alpha_texture, float alpha_cutoff, CoatKind coat,
           bool nonlinear, bool thin, float opacity, float metallic, int metallic_roughness_texture,
           int roughness_texture, Float3 metal_eta, Float3 metal_k, bool beckmann, float f90,
           Float3 transmission) {
            d.materials.push_back({kind,
                                   vec3(base_color),
                                   vec3(specular),
                                   roughness,
                                   eta,
                                   two_sided,
                                   base_texture,
                                   alpha_texture,
                                   alpha_cutoff,
                                   coat,
                                   nonlinear,
                                   thin,
                                   opacity,
                                   metallic,
                                   metallic_roughness_texture,
                                   roughness_texture,
                                   {vec3(metal_eta), vec3(metal_k)},
                                   beckmann,
                                   f90,
                                   vec3(transmission)});
            return int(d.materials.size()) - 1;
        },
        py::arg("kind") = MaterialKind::kDiffuse, py::kw_only(),
        py::arg("base_color") = Float3{.5f, .5f, .5f}, py::arg("specular") = Float3{1, 1, 1},
        py::arg("roughness") = 0.1f, py::arg("eta") = 1.5f, py::arg("two_sided") = true,
        py::arg("base_texture") = -1, py::arg("alpha_texture") = -1, py::arg("alpha_cutoff") = 0.5f,
        py::arg("coat") = CoatKind::kNone, py::arg("nonlinear") = false, py::arg("thin") = false,
        py::arg("opacity") = 1.f, py::arg("metallic") = 0.f, py::arg("metallic_roughness_texture") = -1,
        py::arg("roughness_texture") = -1, py::arg("metal_eta") = Float3{0, 0, 0},
        py::arg("metal_k") = Float3{0, 0, 0}, py::arg("beckmann") = false, py::arg("f90") = 1.f,
        py::arg("transmission") = Float3{1, 1, 1},
        "Add a material; returns its index. Colours and roughness are in [0, 1], eta is the index of\n"
        "refraction, textures are indices of images, -1 for none. A coat covers a glossy material: a\n"
        "dielectric layer of index eta, smooth or of the roughness; then specular scales its\n"
        "reflection, and nonlinear lets light that scatters under it shift colours. A dielectric can be\n"
        "thin: a plate without thickness. opacity in [0, 1] is the share of the surface that is there;\n"
        "the rest are small holes in a fixed pattern. A negative alpha_cutoff takes alpha_texture for\n"
        "such shares too. A glossy material without a coat can be metallic\n"
        "in [0, 1]: that share of its base colour becomes its specular colour. Its roughness can have "
        "an\n"
        "image: the green channel of metallic_roughness_texture multiplies the root of roughness and "
        "the\n"
        "blue one multiplies metallic, as in glTF; the values of roughness_texture multiply roughness.\n"
        "A mirror, or a glossy material with a base_color of 0, can be a metal of the complex index\n"
        "metal_eta + i·metal_k, relative to what is outside; then specular scales its reflection. Both "
        "0:\n"
        "its reflectance at normal incidence is specular. Microfacets are GGX's, or Beckmann's with\n"
        "beckmann=True; those of a rough coat are named by its kind.\n"
        "With the coat fresnel_mix the base loses what the lobe's Schlick term, from specular to f90,\n"
        "reflects at the half vector, as glTF defines it; a thin dielectric with it reflects by that\n"
        "term. A thin glossy material with it is a sheet: it lets transmission, less what the lobe\n"
        "reflects, straight through. transmission is also the tint of glass: the factor of light at each\n"
        "surface that it passes; base_texture multiplies it. Rays to lights end at glass and sheets.");
}

void bind_instances(py::class_<SceneDescription>& d) {
    d.def(
        "add_instance",
        [](SceneDescription& d, std::vector<int> meshes, const DoubleArray& to_world) {
            d.instances.push_back({std::move(meshes), relative(d, affine_from(to_world))});
            return int(d.instances.size()) - 1;
        },
        py::arg("meshes"), py::arg("to_world"),
        "Add an instance of meshes (added with in_world=False) by an affine (3, 4) or (4, 4) matrix; "
        "returns\n"
        "its index.");
}

void bind_lights(py::class_<SceneDescription>& d) {
    d.def(
         "add_point_light",
         [](SceneDescription& d, Point position, Float3 intensity, const std::optional<Float3>& axis,
            std::array<float, 2> cone_deg, const std::string& falloff) {
             d.point_lights.push_back({relative(d, position), vec3(intensity),
                                       axis ? cone_from(*axis, cone_deg, falloff) : SpotCone{}});
         },
         py::arg("position"), py::arg("intensity"), py::kw_only(), py::arg("axis") = py::none(),
         py::arg("cone_deg") = std::array<float, 2>{30, 40}, py::arg("falloff") = "smooth",
         "Add a point light; intensity in W/sr. With an `axis` it is a spot light: the whole intensity "
         "within\n"
         "the first angle of `cone_deg`, none beyond the second (in degrees from the axis). Between "
         "them,\n"
         "`falloff` is t (\"angle\", t linear in the angle), or t² (\"quadratic\"), t⁴ (\"quartic\") or\n"
         "t²(3 - 2t) (\"smooth\") with t linear in the cosine.")
        .def(
            "add_point_lights",
            [](SceneDescription& d, const DoubleArray& positions, const FloatArray& intensities) {
                const std::vector<Vec3> p = relative(d, positions, "positions");
                const Vec3* i = rows3(intensities, "intensities");
                if (positions.shape(0) != intensities.shape(0))
                    throw py::value_error("positions and intensities must have equal numbers of rows, got " +
                                          shape_text(positions) + " and " + shape_text(intensities));
                for (size_t k = 0; k < p.size(); ++k) d.point_lights.push_back({p[k], i[k]});
            },
            py::arg("positions"), py::arg("intensities"),
            "Add point lights, (M, 3) each; intensities in W/sr.")
        .def(
            "add_directional_light",
            [](SceneDescription& d, Float3 direction, Float3 irradiance) {
                d.directional_lights.push_back({normalize(vec3(direction)), vec3(irradiance)});
            },
            py::arg("direction"), py::arg("irradiance"),
            "Add a directional light: `direction` points towards it, irradiance in W/m² across it.")
        .def(
            "add_sphere_light",
            [](SceneDescription& d, Point center, float radius, Float3 radiance) {
                d.sphere_lights.push_back({relative(d, center), radius, vec3(radiance)});
            },
            py::arg("center"), py::arg("radius"), py::arg("radiance"),
            "Add a sphere that emits; radiance in W/(m²·sr).");
}

void bind_images(py::class_<SceneDescription>& d) {
    d.def("add_image", &add_image, py::arg("pixels"), py::kw_only(), py::arg("nearest") = false,
          py::arg("wrap") = py::make_tuple("repeat", "repeat"),
          "Add an image (H, W, C), linear; returns its index. With nearest=True, its pixels have hard "
          "edges.\n"
          "`wrap` is what it shows beyond its borders along u and v: \"repeat\", \"mirror\" or \"clamp\".")
        .def("set_image", &set_image, py::arg("index"), py::arg("pixels"),
             "Set the pixels of a pending image.")
        .def_property_readonly(
            "images",
            [](const SceneDescription& d) {
                py::list out;
                for (const Image& i : d.images)
                    out.append(py::dict(
                        py::arg("path") = i.path, py::arg("where") = i.where, py::arg("srgb") = i.srgb,
                        py::arg("nearest") = i.nearest,
                        py::arg("wrap") =
                            py::make_tuple(kWrapNames[size_t(i.wrap_u)], kWrapNames[size_t(i.wrap_v)]),
                        py::arg("width") = i.width, py::arg("height") = i.height,
                        py::arg("channels") = i.channels, py::arg("bits") = i.bytes.empty() ? 32 : 8));
                return out;
            },
            "Path, place, size and bits per value of every image; width 0 = still to be decoded.");
}

void bind_sky_and_cameras(py::class_<SceneDescription>& d) {
    d.def(
         "set_environment",
         [](SceneDescription& d, Float3 scale, int image, const std::optional<DoubleArray>& to_world) {
             d.environment = Environment{vec3(scale), image, to_world ? affine_from(*to_world) : Affine{}};
         },
         py::arg("scale") = Float3{1, 1, 1}, py::kw_only(), py::arg("image") = -1,
         py::arg("to_world") = py::none(),
         "Light from infinity: constant radiance in W/(m²·sr), or a lat-long image (an index) times "
         "scale.")
        .def(
            "clear_environment", [](SceneDescription& d) { d.environment.reset(); },
            "Remove the environment.")
        .def(
            "add_camera",
            [](SceneDescription& d, Point origin, Point target, Float3 up, float fov_deg, int width,
               int height, bool horizontal, float view_height, const std::string& name) {
                Camera c = look_at(relative(d, origin), relative(d, target), vec3(up), fov_deg * kPi / 180.f);
                c.width = width;
                c.height = height;
                c.fov_is_horizontal = horizontal;
                c.view_height = view_height;
                c.name = name;
                d.cameras.push_back(c);
            },
            py::arg("origin"), py::arg("target"), py::kw_only(), py::arg("up") = Float3{0, 1, 0},
            py::arg("fov_deg") = 45.f, py::arg("width") = 640, py::arg("height") = 400,
            py::arg("horizontal") = false, py::arg("view_height") = 0.f, py::arg("name") = "camera",
            "Add a camera; `fov_deg` is its vertical angle unless horizontal=True, sizes are in pixels. "
            "With view_height > 0 it is orthographic, and its picture is so high in scene units.");
}

void bind_what_was_added(py::class_<SceneDescription>& d) {
    d.def(
         "warn",
         [](SceneDescription& d, std::string where, std::string text) {
             d.warnings.push_back({std::move(where), std::move(text)});
         },
         py::arg("where"), py::arg("text"), "Add a warning for the scene's users, with its place.")
        .def_property_readonly(
            "warnings",
            [](const SceneDescription& d) {
                std::vector<std::pair<std::string, std::string>> out;
                for (const Warning& w : d.warnings) out.emplace_back(w.where, w.text);
                return out;
            },
            "Place and text of every warning.")
        .def_property_readonly(
            "n_meshes", [](const SceneDescription& d) { return d.meshes.size(); }, "Meshes added so far.")
        .def_property_readonly(
            "n_lights",
            [](const SceneDescription& d) {
                size_t emitters = 0;
                // Triangles would be too many to count here, and meshes are what the user has added
                for (const Mesh& mesh : d.meshes) emitters += max_component(mesh.emission) > 0;
                return d.point_lights.size() + d.directional_lights.size() + d.sphere_lights.size() +
                       emitters + d.environment.has_value();
            },
            "Lights added so far: emitting meshes and the environment count as one each.");
}

}  // namespace

void bind_description(py::module_& m) {
    py::register_exception<SceneError>(m, "SceneError", PyExc_ValueError);

    py::native_enum<MaterialKind>(m, "MaterialKind", "enum.Enum", "Kinds of materials.")
        .value("DIFFUSE", MaterialKind::kDiffuse)
        .value("GLOSSY", MaterialKind::kGlossy)
        .value("MIRROR", MaterialKind::kMirror)
        .value("DIELECTRIC", MaterialKind::kDielectric)
        .finalize();

    py::native_enum<CoatKind>(m, "CoatKind", "enum.Enum", "Layers over a glossy material.")
        .value("NONE", CoatKind::kNone)
        .value("SMOOTH", CoatKind::kSmooth)
        .value("ROUGH", CoatKind::kRough)
        .value("BECKMANN", CoatKind::kBeckmann)
        .value("FRESNEL_MIX", CoatKind::kFresnelMix)
        .finalize();

    py::class_<SceneDescription> d(
        m, "SceneDescription",
        "A scene that can still be changed; `viscache.Scene.from_description` freezes it.\n\n"
        "Vectors are three numbers, lengths are in scene units, light is in linear RGB. Positions and\n"
        "transforms are given in the world. `origin` is subtracted from them in double precision, before\n"
        "they become floats: scenes far from the origin keep their digits.");
    d.def(py::init([](Point origin) {
              if (!std::isfinite(origin[0] + origin[1] + origin[2]))
                  throw py::value_error("origin must be finite");
              SceneDescription d;
              d.origin = origin;
              return d;
          }),
          py::arg("origin") = Point{})
        .def_readonly("origin", &SceneDescription::origin, "The point of the world at (0, 0, 0).")
        .def_readwrite("name", &SceneDescription::name, "Name that is shown with the scene.");
    bind_meshes(d);
    bind_materials(d);
    bind_instances(d);
    bind_lights(d);
    bind_images(d);
    bind_sky_and_cameras(d);
    bind_what_was_added(d);
    // For other processes; files of scenes have formats of their own
    d.def(py::pickle([](const SceneDescription& d) { return py::bytes(description_bytes(d)); },
                     [](const py::bytes& bytes) { return description_from(bytes); }));
}

}  // namespace viscache::bindings
