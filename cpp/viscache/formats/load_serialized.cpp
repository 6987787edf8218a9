// Mitsuba's .serialized mesh files (versions 3 and 4): zlib streams with a dictionary of offsets at the end.
#include <zlib.h>

#include <cstring>

#include "viscache/formats/loading.h"

namespace viscache::loading {

namespace {

constexpr uint32_t kHasNormals = 0x0001, kHasUvs = 0x0002, kHasColors = 0x0008, kFaceNormals = 0x0010;
constexpr uint32_t kDoublePrecision = 0x2000;
constexpr uint64_t kMostDeflateRatio = 1040;  ///< upper bound of zlib's compression ratio

template <class T>
T get(std::string_view bytes, size_t at) {
    T v;
    std::memcpy(&v, bytes.data() + at, sizeof v);
    return v;
}

std::string at_byte(const std::string& path, size_t byte) { return path + ": byte " + std::to_string(byte); }

uint16_t check_magic(const std::string& path, std::string_view bytes, size_t at) {
    if (bytes.size() < 8 || at + 4 > bytes.size())
        fail(at_byte(path, at), "the file ends inside a shape's header");
    if (get<uint16_t>(bytes, at) != 0x041C) fail(at_byte(path, at), "no .serialized shape starts here");
    const auto version = get<uint16_t>(bytes, at + 2);
    if (version != 3 && version != 4)
        fail(at_byte(path, at + 2), "version " + std::to_string(version) + "; 3 and 4 are read");
    return version;
}

/// A zlib stream that is decompressed in pieces.
class Inflate {
public:
    Inflate(std::string_view packed, const std::string& where) : where_(where), packed_size_(packed.size()) {
        if (packed.size() > 0xffffffffu) fail(where, "a packed shape is larger than 4 GiB");
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
        stream_.avail_in = uInt(packed.size());
        if (inflateInit(&stream_) != Z_OK) fail(where, "zlib cannot start");
    }
    ~Inflate() { inflateEnd(&stream_); }
    Inflate(const Inflate&) = delete;
    Inflate& operator=(const Inflate&) = delete;

    void read(void* to, uint64_t bytes) {
        auto* out = static_cast<Bytef*>(to);
        while (bytes > 0) {
            const auto piece = uInt(std::min<uint64_t>(bytes, 1u << 30));
            stream_.next_out = out;
            stream_.avail_out = piece;
            const int status = inflate(&stream_, Z_SYNC_FLUSH);
            const uInt done = piece - stream_.avail_out;
            out += done;
            bytes -= done;
            if (bytes > 0 && (status != Z_OK || done == 0))
                fail(where_,
                     "the packed data is broken or ends early (zlib status " + std::to_string(status) + ")");
        }
    }

    template <class T>
    T value() {
        T v;
        read(&v, sizeof v);
        return v;
    }

    /// Reads `count` pairs or triples of float or double as floats.
    template <class V>
    std::vector<V> vectors(uint64_t count, bool is_double) {
        constexpr size_t n = sizeof(V) / sizeof(float);
        std::vector<V> out(count);
        auto* flat = reinterpret_cast<float*>(out.data());
        if (!is_double) {
            read(flat, count * sizeof(V));
            return out;
        }
        for (uint64_t i = 0; i < count * n; ++i) flat[i] = float(value<double>());
        return out;
    }

    /// Refuses counts larger than the packed bytes can decompress to.
    void check_room(uint64_t count, uint64_t each, const char* what) const {
        const uint64_t most = packed_size_ * kMostDeflateRatio + 1024;
        if (count > most / each)
            fail(where_, std::to_string(count) + " " + what + " cannot come from " +
                             std::to_string(packed_size_) + " packed bytes");
    }

private:
    z_stream stream_{};
    const std::string& where_;
    uint64_t packed_size_;
};

/// Byte offset of each shape.
std::vector<uint64_t> offsets_of(const std::string& path, std::string_view bytes) {
    const uint16_t version = check_magic(path, bytes, 0);
    const uint64_t count = get<uint32_t>(bytes, bytes.size() - 4);
    const uint64_t width = version == 4 ? 8 : 4;
    if (count == 0 || count * width + 4 > bytes.size())
        fail(at_byte(path, bytes.size() - 4),
             "the dictionary lists " + std::to_string(count) + " shapes, the file cannot hold them");
    const uint64_t dictionary = bytes.size() - 4 - count * width;
    std::vector<uint64_t> offsets(count);
    for (uint64_t i = 0; i < count; ++i) {
        const uint64_t at = dictionary + i * width;
        offsets[i] = version == 4 ? get<uint64_t>(bytes, at) : get<uint32_t>(bytes, at);
        if (offsets[i] >= dictionary || dictionary - offsets[i] < 4)
            fail(at_byte(path, at), "shape " + std::to_string(i) + " is said to start at byte " +
                                        std::to_string(offsets[i]) + ", outside of the file");
    }
    offsets.push_back(dictionary);
    return offsets;
}

}  // namespace

size_t serialized_count(const std::string& path, std::string_view bytes) {
    return offsets_of(path, bytes).size() - 1;
}

Mesh read_serialized(const std::string& path, std::string_view bytes, size_t index, bool* has_colors) {
    const auto offsets = offsets_of(path, bytes);
    if (index + 1 >= offsets.size())
        fail(path,
             "shape index " + std::to_string(index) + ", the file has " + std::to_string(offsets.size() - 1));
    const uint64_t begin = offsets[index];
    const std::string where = path + ": shape " + std::to_string(index);
    const uint16_t version = check_magic(path, bytes, begin);
    // A shape ends where the next one in the file starts; the dictionary may be in any order.
    uint64_t end = offsets.back();
    for (uint64_t other : offsets)
        if (other > begin) end = std::min(end, other);
    Inflate in(bytes.substr(begin + 4, end - begin - 4 > end ? 0 : end - begin - 4), where);

    Mesh mesh;
    const auto flags = in.value<uint32_t>();
    if (version == 4)
        for (char c; (c = in.value<char>()) != '\0';) mesh.name += c;
    const auto vertices = in.value<uint64_t>(), triangles = in.value<uint64_t>();
    const bool is_double = flags & kDoublePrecision;
    in.check_room(vertices, is_double ? 24 : 12, "vertices");
    in.check_room(triangles, 12, "triangles");
    if (vertices > 0xffffffffu) fail(where, "more than 2^32 - 1 vertices");
    mesh.vertices = in.vectors<Vec3>(vertices, is_double);
    if (flags & kHasNormals) mesh.normals = in.vectors<Vec3>(vertices, is_double);
    if (flags & kHasUvs) mesh.uvs = in.vectors<Vec2>(vertices, is_double);
    if (has_colors && flags & kHasColors) *has_colors = true;
    if (flags & kHasColors) in.vectors<Vec3>(vertices, is_double);
    if (flags & kFaceNormals) mesh.normals.clear();
    mesh.triangles.resize(triangles);
    in.read(mesh.triangles.data(), triangles * sizeof(Vec3u));
    // Row 0 of an image is v = 0 in these files.
    for (Vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
    check_mesh(mesh, where);
    return mesh;
}

void load_serialized(const std::string& path, Loading& loading) {
    const std::string bytes = read_file(path);
    const int material = loading.add_material({});
    bool has_colors = false;
    for (size_t i = 0; i < serialized_count(path, bytes); ++i) {
        Mesh mesh = read_serialized(path, bytes, i, &has_colors);
        mesh.material = material;
        loading.add_mesh(std::move(mesh), path);
    }
    if (has_colors) loading.warn(path, "colours of vertices are not read from this format");
}

}  // namespace viscache::loading
