#pragma once
// Reads Mitsuba XML scenes (3.x and the 0.4-0.6 dialect). Internal to the loader; one source file per kind
// of element.
#include <memory>
#include <pugixml.hpp>

#include "viscache/formats/loading.h"
#include "viscache/formats/spectra.h"

namespace viscache::loading {

/// A colour with an optional image that multiplies it.
struct ColorTexture {
    Rgb color{};
    int image = -1;
    std::string attribute{};  ///< of the mesh, which multiplies it, too; empty: none
};

/// Compares camelCase with snake_case: "diffuseReflectance" equals "diffuse_reflectance", "intIOR" equals
/// "int_ior".
bool same_name(const char* given, std::string_view snake);

class MitsubaReader {
public:
    using Node = pugi::xml_node;

    explicit MitsubaReader(Loading& loading) : loading_(loading) {}
    void read_scene(const std::string& path);

private:
    static constexpr size_t kMaxFiles = 10'000;  ///< a file counts each time it is included

    struct XmlFile {
        XmlFile(std::string path, std::string text)
            : path(std::move(path)),
              text(std::move(text)),
              lines(this->text),
              is_read(this->text.size() + 1) {}
        std::string path, text;
        LineIndex lines;
        std::vector<bool> is_read;  ///< by the offset of an element
        pugi::xml_document document;
    };

    // load_mitsuba.cpp: files, ids and the elements of a scene
    XmlFile& open(const std::string& path, const std::string& asked_at);
    void register_ids(Node root);
    void read_elements(Node scene);
    void include(Node node);
    XmlFile& file_of(Node node) const;
    static size_t offset_of(Node node) { return size_t(std::max<std::ptrdiff_t>(node.offset_debug(), 0)); }
    std::string where(Node node) const;
    [[noreturn]] void fail_at(Node node, const std::string& what) const { fail(where(node), what); }
    void warn_at(Node node, const std::string& what) { loading_.warn(where(node), what); }
    Node target_of(Node ref) const;
    std::string path_of(Node owner) const;  ///< the file that its `filename` names
    std::string find_file(const std::string& name, Node asker) const;
    void add_folder(Node node);

    // mitsuba_unread.cpp: elements that nobody asks for are warned of
    void use(Node node) const { file_of(node).is_read[offset_of(node)] = true; }
    void use_rest(Node owner) const;  ///< what is inside and was not read
    /// Says that what was not read of an element does not count.
    void skip(Node node, const std::string& what);
    void warn_of_unread(Node owner);

    // mitsuba_values.cpp: properties and values
    std::string attribute(Node node, const char* name) const;  ///< with $parameters replaced
    std::string type_of(Node node) const { return attribute(node, "type"); }
    /// `name` is in snake_case, and matches camelCase in the file too. The property counts as read.
    Node property(Node owner, const char* name) const;
    std::vector<double> numbers(Node node, const std::string& text) const;
    double attribute_number(Node node, const char* name, double fallback) const;
    double number(Node owner, const char* name, double fallback);
    int integer(Node owner, const char* name, int fallback);
    bool boolean(Node owner, const char* name, bool fallback);
    std::string string(Node owner, const char* name, const std::string& fallback);
    std::optional<Vec3> vector(Node owner, const char* name);
    Affine transform(Node owner, const char* name = "to_world");
    Affine transform_step(Node step);
    Affine look_at_matrix(Node step);
    Rgb rgb_value(Node node) const;
    Rgb color(Node owner, const char* name, Rgb fallback);
    ColorTexture color_texture(Node owner, const char* name, Rgb fallback, bool may_be_attribute = false);
    ColorTexture texture(Node node, int depth = 0);
    ColorTexture bitmap(Node node);
    ColorTexture checkerboard(Node node);
    void note_uv(Node node);  ///< of an image of the current material

    // mitsuba_spectra.cpp
    SpectrumOf spectrum_use(Node node) const;
    Rgb converted(const Spectrum& spectrum, Node node) const;
    Rgb spectrum_pairs(const std::vector<double>& numbers, Node node) const;
    std::string spectrum_file(Node node) const;
    Rgb spectrum_value(Node node) const;
    Rgb spectrum_samples(Node node, bool regular);
    Rgb blackbody(Node node, bool plugin);
    std::optional<Rgb> spectrum_plugin(Node node, const std::string& type);

    // mitsuba_bsdfs.cpp
    int material(Node bsdf);  ///< index; the same element gives the same material. -1: no surface (null)
    int material_of(Node shape);
    Node bsdf_of(Node child) const;
    Material bsdf(Node node, int depth);
    Material nested(Node node, int depth);
    bool is_beckmann(Node node);
    /// Types of bsdfs. `depth`: so many bsdfs stand around the node.
    using ReadBsdf = Material(Node node, int depth);
    ReadBsdf two_sided, mask, diffuse, plastic, phong, conductor, dielectric, principled, first_inside;
    float roughness(Node node, double fallback);
    double ior(Node owner, const char* name, double fallback);
    void set_base(Material& m, const ColorTexture& base);
    void set_roughness(Material& m, Node node);

    // mitsuba_shapes.cpp
    void shape(Node node);
    std::optional<Mesh> shape_mesh(Node node, const std::string& type, bool has_image, FileColors& colors);
    std::optional<Mesh> mesh_file(Node node, const std::string& type, FileColors& colors);
    void set_colors(Node node, Mesh& mesh, FileColors& colors, const std::string& attribute);
    Mesh serialized_mesh(Node node, const std::string& path);
    Mesh cylinder(Node node);
    void sphere(Node node, const ColorTexture& emission, int material, bool in_group,
                std::vector<int>* group);
    void instance(Node node);
    void add_shape(Node node, std::vector<int>* group);
    const std::vector<int>& group_meshes(Node node);

    // mitsuba_emitters.cpp
    ColorTexture area_emission(Node shape);
    void emitter(Node node);
    void envmap(Node node);
    void spot(Node node);
    void directional(Node node);

    // mitsuba_sky.cpp
    void sky(Node node, const std::string& type);
    Vec3 sky_to_sun(Node node, const Affine& to_world, bool z_is_up);

    // mitsuba_sensor.cpp
    void sensor(Node node);
    void field_of_view(Node node, Camera& camera);
    void view_extent(Node node, Camera& camera);
    void crop(Node film, Camera& camera);
    void check_clip_planes();

    Loading& loading_;
    std::vector<std::unique_ptr<XmlFile>> files_;
    mutable XmlFile* last_ = nullptr;   ///< that was asked for
    std::vector<std::string> open_;     ///< chain of open includes
    std::vector<std::string> folders_;  ///< of <path> elements, each with a slash at its end
    std::map<std::string, std::string> parameters_;
    std::map<std::string, Node> ids_;
    std::map<size_t, int> materials_;                ///< key: bsdf element
    MaterialUv* uv_ = nullptr;                       ///< of the material that is being read
    std::map<int, UvTransform> material_uv_;         ///< key: index of the material
    std::string attribute_;                          ///< of meshes that is the base colour of the material
    std::map<int, std::string> material_attribute_;  ///< the same; key: index of the material
    std::map<size_t, std::vector<int>> groups_;      ///< key: shapegroup element
    std::map<std::string, std::string> serialized_;  ///< file contents; key: path
    struct Clipped {
        Node sensor;
        size_t camera;
    };
    std::vector<Clipped> clip_planes_;  ///< the sensors, whose planes are judged at the end
    int version_major_ = 3;
};

}  // namespace viscache::loading
