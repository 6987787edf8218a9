#pragma once
// Reads pbrt-v3 and pbrt-v4 scenes. Internal to the loader; one source file per kind of directive.
#include "viscache/formats/pbrt_tokens.h"
#include "viscache/formats/spectra.h"

namespace viscache::loading {

inline constexpr Rgb kZero{0, 0, 0}, kQuarter{.25f, .25f, .25f}, kHalf{.5f, .5f, .5f}, kOne{1, 1, 1};

struct PbrtTexture {
    Rgb color{1, 1, 1};
    int image = -1;
    UvTransform uv{};  ///< of the image
};

// pbrt_round_shapes.cpp
bool is_whole_sphere(const PbrtParams& params);
std::optional<Mesh> round_shape(const std::string& type, const PbrtParams& params, const std::string& where);
Mesh textured_disk(const PbrtParams& params);  ///< a whole disk

class PbrtReader {
public:
    explicit PbrtReader(Loading& loading) : loading_(loading) {}
    void read_scene(const std::string& path);

private:
    static constexpr int kNoMaterial = -1, kNoSurface = -2;

    struct AreaLight {
        Rgb radiance;
        bool two_sided = false;
        int image = -1;
        double power = 0;  ///< > 0: of a light of the colour `radiance`, instead of its radiance
    };
    template <class T>
    using Shared = std::shared_ptr<const std::map<std::string, T>>;
    struct Graphics {
        Affine ctm;
        Shared<PbrtTexture> textures = std::make_shared<std::map<std::string, PbrtTexture>>();
        Shared<int> named = std::make_shared<std::map<std::string, int>>();
        Shared<PbrtParams> defaults = std::make_shared<std::map<std::string, PbrtParams>>();
        int material = kNoMaterial;
        std::optional<AreaLight> area_light;
        bool reversed = false;
    };
    using Names = std::vector<std::string>;
    struct Plugin {
        std::string_view word;
        const char* attribute;  ///< the kind by which Attribute sets defaults; empty: none
        int names;              ///< strings before the parameters
        int shown;              ///< the name that warnings give; -1: none, as the file invents them
        void (PbrtReader::*read)(const Names&, const PbrtParams&, const std::string& where);
    };
    static const Plugin kPlugins[];
    struct Saved {
        Graphics graphics;
        char kind;  ///< 'a' attribute, 't' transform, 'o' object
        std::string where;
    };

    // load_pbrt.cpp: directives
    bool directive(const PbrtToken& token);
    bool transform_directive(const PbrtToken& token);
    bool block_directive(const PbrtToken& token);
    bool plugin_directive(const PbrtToken& token);
    void warn_unread(const PbrtParams::List& params, const std::string& of);
    void make_named_medium(const Names& names, const PbrtParams& params, const std::string& where);
    bool medium_interface(const PbrtToken& token);
    void rendering_settings(const Names&, const PbrtParams& params, const std::string&) {
        params.ignore_all();
    }
    void end_of_file(const PbrtToken& token);
    void save(char kind, const PbrtToken& token);
    void restore(char kind, const PbrtToken& token);
    Affine read_matrix(const PbrtToken& token);
    Affine read_look_at(const PbrtToken& token);
    void multiply(const Affine& t, const PbrtToken& token);
    void object_instance(const PbrtToken& token);
    std::string path_named(const std::string& name, const std::string& asked_at) const;
    std::string name_argument() {
        return std::string(tokens_.expect(PbrtToken::kString, "a name in quotes").text);
    }

    // pbrt_colors.cpp
    std::optional<Rgb> color_of(const PbrtParam& param);
    Rgb spectrum_of(const PbrtParam& param);
    std::vector<double> spectrum_file(const PbrtParam& param);
    Rgb color(const PbrtParams& params, const char* name, Rgb fallback);
    PbrtTexture color_texture(const PbrtParams& params, const char* name, Rgb fallback);
    void texture(const Names& names, const PbrtParams& params, const std::string& where);
    PbrtTexture image_map(const PbrtParams& params, const std::string& where);
    PbrtTexture checkerboard(const PbrtParams& params, const std::string& where);
    UvTransform mapping(const PbrtParams& params, const std::string& where);

    // pbrt_v4.cpp
    bool v4_directive(const PbrtToken& token);
    void option(const Names& names, const PbrtParams& params, const std::string& where);
    PbrtParams params_of(const std::string& kind);
    static bool is_v4_material(const std::string& type);
    float v4_alpha(const PbrtParams& params, const std::string& prefix, double fallback);
    float v4_eta(const PbrtParams& params, const char* name, double fallback, const std::string& where);
    Material v4_conductor(const PbrtParams& params, const std::string& prefix);
    Material v4_coated_diffuse(const PbrtParams& params, const std::string& where);
    Material v4_surface(const std::string& type, const PbrtParams& params, const std::string& where);
    static std::optional<Rgb> named_spectrum(const std::string& name);

    // pbrt_materials.cpp
    int material(const std::string& type, const PbrtParams& params, const std::string& where);
    int surface(const std::string& type, const PbrtParams& params, const std::string& where);
    int mix(const PbrtParams& params, const std::string& where);
    Material metal(const PbrtParams& params);
    Material coated(const std::string& type, const PbrtParams& params, const std::string& where);
    float roughness(const PbrtParams& params, double fallback);
    double isotropic(const PbrtParams& params, double u, double v);
    double plain_number(const PbrtParams& params, const std::string& name, double fallback);
    bool roughness_image(Material& m, const PbrtParams& params, const std::string& name);
    void set_material(const Names& names, const PbrtParams& params, const std::string& where);
    void make_named_material(const Names& names, const PbrtParams& params, const std::string& where);
    void set_named_material(const Names& names, const PbrtParams& params, const std::string& where);

    // pbrt_shapes.cpp: shapes and lights
    void shape(const Names& names, const PbrtParams& params, const std::string& where);
    std::optional<Mesh> shape_mesh(const std::string& type, const PbrtParams& params,
                                   const std::string& where);
    bool sphere_light(const PbrtParams& params, const std::string& where);
    Rgb radiance(const AreaLight& light, double area) const;
    Mesh bilinear_mesh(const PbrtParams& params, const std::string& where);
    std::optional<PbrtTexture> shape_alpha(const std::string& type, const PbrtParams& params);
    int shape_material(const std::optional<PbrtTexture>& alpha, const std::string& where);
    static void add_default_uvs(Mesh& mesh, const std::string& type, const PbrtParams& params);
    void orient(Mesh& mesh);
    void light(const Names& names, const PbrtParams& params, const std::string& where);
    void spot_light(const PbrtParams& params, const std::string& where);
    void infinite_light(const PbrtParams& params, const std::string& where);
    void area_light(const Names& names, const PbrtParams& params, const std::string& where);

    // pbrt_camera.cpp
    void camera(const Names& names, const PbrtParams& params, const std::string& where);
    void film(const Names& names, const PbrtParams& params, const std::string& where);
    void finish_camera();

    Loading& loading_;
    std::string main_path_;
    PbrtTokens tokens_;
    Graphics now_;
    std::vector<Saved> saved_;
    std::map<std::string, Affine> coordinate_systems_;
    std::map<std::string, std::vector<int>> objects_;
    PbrtParams::List defaults_;               ///< of all Attribute directives
    std::vector<int>* object_ = nullptr;      ///< the object being defined
    MaterialUv* uv_ = nullptr;                ///< of the material that is being read
    std::map<int, UvTransform> material_uv_;  ///< key: index of the material
    /// A camera until the size of the film is known.
    struct PendingCamera {
        Camera camera;
        double unit = 1;                              ///< size of one unit of the screen
        std::optional<std::array<double, 4>> window;  ///< of the screen: x from, to; y from, to
        std::optional<double> aspect;
        double exposure = 1;  ///< time that the shutter is open
        std::string where;
    };
    std::optional<PendingCamera> camera_;
    int film_width_ = 1280, film_height_ = 720;
    std::optional<std::array<int, 4>> crop_;  ///< pixels of the film: x from, to; y from, to
    bool in_world_ = false, world_ended_ = false;
    bool is_v4_ = false;  ///< words of pbrt-v4 were found
};

}  // namespace viscache::loading
