#pragma once
// Lines of Wavefront files, and the materials of MTL files. Internal to the loader of OBJ.
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "viscache/formats/loading.h"

namespace viscache::loading {

std::string_view next_word(std::string_view& line);
std::string_view trimmed(std::string_view text);
std::string quoted(std::string_view text);

/// The lines of a text, trimmed. A line ends with LF, CR or both; a `\` at its end joins it with the next
/// one.
class WavefrontLines {
public:
    WavefrontLines(std::string_view text, const std::string& path);
    bool next(std::string_view& line);
    size_t number() const { return number_; }  ///< where the line begins
    std::string where() const { return at_line(path_, number_); }

private:
    std::string_view physical();

    std::string_view text_;
    const std::string& path_;
    std::string joined_;
    size_t begin_ = 0, newline_ = 0, number_ = 0, read_ = 0;
};

/// The numbers of the rest of a line.
struct Numbers {
    Vec3 first{}, next{};  ///< three of them, and the three that follow
    size_t count = 0;
    std::string_view wrong;  ///< a word that is no finite number; empty: none
};
Numbers numbers_of(std::string_view rest);

/// A texture line: `map_Kd -s 2 2 2 my wood.png`.
struct MtlImage {
    std::string name;
    size_t line = 0;
    UvTransform uv;
    LookUp look_up;
    bool srgb = true;
};

/// What the lines of a material say.
struct MtlMaterial {
    std::string name;
    size_t file = 0, line = 0;
    std::optional<Rgb> ka, kd, ks, ke, tf;
    std::optional<float> ns, ni, d, tr, illum, pr, pm;
    std::optional<MtlImage> map_kd, map_ks, map_ns, map_d, map_ke, map_pr;
};

/// The materials of the MTL files that an OBJ file names.
class MtlReader {
public:
    /// A material, and what it makes of a mesh.
    struct Look {
        Material material;
        Rgb emission{};
        int emission_texture = -1;
        MaterialUv uv;
    };
    explicit MtlReader(Loading& loading) : loading_(loading) {}

    void read(const std::string& path, const std::string& asked_at);
    /// Index of a material; -1: none has this name.
    int find(const std::string& name) const;
    const std::string& name(int index) const { return materials_[size_t(index)].name; }
    Look look(int index);

private:
    /// Who wrote a file, where that decides what a value means.
    enum class Writer { kOther, kBlender, kVtk };
    struct File {
        std::string path;
        Writer writer = Writer::kOther;
        bool tr_is_opacity = false;
    };

    void read_line(std::string_view key, std::string_view rest, const WavefrontLines& lines);
    MtlImage image(std::string_view rest, const WavefrontLines& lines);
    float opacity(const MtlMaterial& in);
    bool is_glass(const MtlMaterial& in, float opacity) const;
    void glass(Material& m, const MtlMaterial& in);
    void lobe(Material& m, const MtlMaterial& in, bool has_base);
    int add_image(Look& look, const MtlImage& image, const std::string& path, bool srgb);
    std::string where(const MtlMaterial& in) const { return at_line(files_[in.file].path, in.line); }
    bool by_blender(const MtlMaterial& in) const { return files_[in.file].writer == Writer::kBlender; }

    Loading& loading_;
    std::vector<File> files_;
    std::vector<MtlMaterial> materials_;
    std::map<std::string, int> by_name_;
};

}  // namespace viscache::loading
