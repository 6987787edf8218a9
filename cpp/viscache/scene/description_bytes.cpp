#include "viscache/scene/description_bytes.h"

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace viscache {

namespace {

constexpr uint64_t kTag = 0x3545435343564cull;  // changes with the fields below

/// The fields of each type, in one order for both directions.
template <class Archive>
void fields(Archive& a, Mesh& m) {
    a(m.name, m.vertices, m.triangles, m.normals, m.uvs, m.colors, m.material, m.emission, m.emission_texture,
      m.emits_two_sided, m.in_world);
}
template <class Archive>
void fields(Archive& a, Instance& i) {
    a(i.meshes, i.to_world);
}
template <class Archive>
void fields(Archive& a, Image& i) {
    a(i.path, i.where, i.srgb, i.width, i.height, i.channels, i.pixels, i.bytes, i.nearest, i.wrap_u,
      i.wrap_v);
}
template <class Archive>
void fields(Archive& a, Camera& c) {
    a(c.name, c.origin, c.right, c.up, c.forward, c.fov_y_rad, c.width, c.height, c.fov_is_horizontal,
      c.view_height, c.shift_x, c.shift_y);
}
template <class Archive>
void fields(Archive& a, Warning& w) {
    a(w.where, w.text);
}
template <class Archive>
void fields(Archive& a, SceneDescription& d) {
    a(d.name, d.meshes, d.instances, d.materials, d.images, d.point_lights, d.directional_lights,
      d.sphere_lights, d.environment, d.added_environments, d.cameras, d.warnings, d.origin);
}

template <class T>
/// Copied as they lie in memory. The bytes are for processes of the same build, which the tag
/// ensures.
constexpr bool kPlain = std::is_trivially_copyable_v<T>;

class Writer {
public:
    template <class... T>
    void operator()(T&... values) {
        (one(values), ...);
    }
    std::string bytes;

private:
    void raw(const void* data, size_t n) { bytes.append(static_cast<const char*>(data), n); }
    // Lengths stand before contents
    void count(uint64_t n) { raw(&n, sizeof n); }
    template <class T>
    void one(T& value) {
        if constexpr (kPlain<T>)
            raw(&value, sizeof value);
        else
            fields(*this, value);
    }
    void one(std::string& text) {
        count(text.size());
        raw(text.data(), text.size());
    }
    template <class T>
    void one(std::vector<T>& values) {
        count(values.size());
        if constexpr (kPlain<T>)
            raw(values.data(), values.size() * sizeof(T));
        else
            for (T& value : values) one(value);
    }
    void one(std::optional<Environment>& value) {
        count(value.has_value());
        if (value) one(*value);
    }
};

class DescriptionReader {
public:
    explicit DescriptionReader(std::string_view bytes) : rest_(bytes) {}
    template <class... T>
    void operator()(T&... values) {
        (one(values), ...);
    }
    bool at_end() const { return rest_.empty(); }

private:
    void raw(void* data, size_t n) {
        // Never reads beyond the end, whatever a damaged length says
        if (n > rest_.size()) throw SceneError("the bytes of a scene must be whole, some are missing");
        if (n) std::memcpy(data, rest_.data(), n);
        rest_.remove_prefix(n);
    }
    /// A number of things that take `least` bytes each, at least.
    size_t count(size_t least) {
        uint64_t n = 0;
        raw(&n, sizeof n);
        // A length that the rest cannot hold is refused before memory is taken for it
        if (n > rest_.size() / least)
            throw SceneError("the bytes of a scene must be whole, some are missing");
        return size_t(n);
    }
    template <class T>
    void one(T& value) {
        if constexpr (kPlain<T>)
            raw(&value, sizeof value);
        else
            fields(*this, value);
    }
    void one(std::string& text) {
        text.resize(count(1));
        raw(text.data(), text.size());
    }
    template <class T>
    void one(std::vector<T>& values) {
        if constexpr (kPlain<T>) {
            values.resize(count(sizeof(T)));
            raw(values.data(), values.size() * sizeof(T));
        } else {
            values.resize(count(1));
            for (T& value : values) one(value);
        }
    }
    void one(std::optional<Environment>& value) {
        uint64_t there = 0;
        raw(&there, sizeof there);
        // Whether there is one was written as a number
        if (there) one(value.emplace());
    }
    std::string_view rest_;
};

}  // namespace

std::string description_bytes(const SceneDescription& description) {
    Writer writer;
    uint64_t tag = kTag;
    SceneDescription copy = description;  // one list of fields serves both directions: it takes no const
    writer(tag, copy);
    return std::move(writer.bytes);
}

SceneDescription description_from(std::string_view bytes) {
    DescriptionReader reader(bytes);
    uint64_t tag = 0;
    SceneDescription description;
    reader(tag);
    if (tag != kTag) throw SceneError("the bytes must be those of a scene of this version of viscache");
    reader(description);
    // Bytes that are left over would be those of another version
    if (!reader.at_end()) throw SceneError("the bytes of a scene must be whole, some are left over");
    return description;
}

}  // namespace viscache
