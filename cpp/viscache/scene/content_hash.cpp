#include "viscache/scene/content_hash.h"

#include <cstring>

namespace viscache {

namespace {

/// Two 64-bit multiply-xorshift chains over a stream of words.
class Hasher {
public:
    /// Two chains that differ in their first operation and constants. Equal results by chance need 128 equal
    /// bits; they are not meant to resist an attacker.
    void word(uint64_t w) {
        a_ = (a_ ^ w) * 0x9E3779B97F4A7C15ull;
        a_ ^= a_ >> 29;
        b_ = (b_ + w) * 0xC2B2AE3D27D4EB4Full;
        b_ ^= b_ >> 32;
    }
    void bytes(const void* data, size_t n) {
        const char* p = static_cast<const char*>(data);
        for (; n >= 8; p += 8, n -= 8) {
            uint64_t w;
            std::memcpy(&w, p, 8);
            word(w);
        }
        // The last bytes are filled up with zeros; lengths are hashed apart
        uint64_t rest = 0;
        if (n) std::memcpy(&rest, p, n);
        word(rest);
    }
    template <class T>
    void array(const std::vector<T>& v) {
        // The length stands before the content: otherwise two arrays could trade elements without a change.
        word(v.size());
        bytes(v.data(), v.size() * sizeof(T));
    }
    /// Linear values: an image of bytes has the hash of the floats that it stands for.
    void values(const Image& image) {
        if (image.bytes.empty()) return array(image.pixels);
        const size_t n = image.size();
        word(n);
        for (size_t i = 0; i < n; i += 2) {
            const float pair[2] = {image.value(i), i + 1 < n ? image.value(i + 1) : 0.f};
            uint64_t w;
            std::memcpy(&w, pair, 8);
            word(w);
        }
        if (n % 2 == 0) word(0);  // the rest of `bytes`
    }
    void look_up(const Image& i) {
        word(uint64_t(i.width) << 32 | uint64_t(i.wrap_v) << 20 | uint64_t(i.wrap_u) << 18 |
             uint64_t(i.nearest) << 16 | uint64_t(i.channels));
    }
    void floats(std::initializer_list<float> v) { bytes(v.begin(), v.size() * sizeof(float)); }
    void vec(Vec3 v) { floats({v.x, v.y, v.z}); }
    std::string hex() const {
        char text[33];
        std::snprintf(text, sizeof text, "%016llx%016llx", (unsigned long long)a_, (unsigned long long)b_);
        return text;
    }

private:
    uint64_t a_ = 0x243F6A8885A308D3ull, b_ = 0x13198A2E03707344ull;
};

void add(Hasher& h, const Material& m) {
    h.word(uint64_t(m.thin) << 11 | uint64_t(m.nonlinear) << 10 | uint64_t(m.coat) << 8 |
           uint64_t(m.kind) << 1 | uint64_t(m.two_sided));
    h.vec(m.base_color);
    h.vec(m.specular);
    h.floats({m.roughness, m.eta, m.alpha_cutoff, float(m.base_texture), float(m.alpha_texture)});
    // The same for all fields that came later
    if (m.opacity < 1) h.floats({m.opacity});
    if (m.mixes_metal())
        h.floats({m.metallic, float(m.metallic_roughness_texture), float(m.roughness_texture)});
    if (m.beckmann) h.word(6);
    if (m.coat == CoatKind::kFresnelMix) h.floats({m.f90});
    if (m.transmits() && (m.transmission.x != 1 || m.transmission.y != 1 || m.transmission.z != 1)) {
        h.word(7);
        h.vec(m.transmission);
    }
    if (m.metal.is_given()) {
        h.vec(m.metal.eta);
        h.vec(m.metal.k);
    }
}

void add(Hasher& h, const Camera& c) {
    h.vec(c.origin);
    h.vec(c.right);
    h.vec(c.up);
    h.vec(c.forward);
    h.floats({c.fov_y_rad, float(c.fov_is_horizontal)});
    if (c.is_orthographic()) h.floats({c.view_height});
    if (c.shift_x != 0 || c.shift_y != 0) {
        h.word(5);
        h.floats({c.shift_x, c.shift_y});
    }
}

}  // namespace

std::string content_hash(const SceneDescription& d) {
    Hasher h;
    for (const Mesh& m : d.meshes) {
        h.array(m.vertices);
        h.array(m.triangles);
        h.array(m.normals);
        h.array(m.uvs);
        h.word(uint64_t(m.material) << 2 | uint64_t(m.emits_two_sided) << 1 | uint64_t(m.in_world));
        h.vec(m.emission);
        // Only where it is given, with a number that marks it: scenes without such a field keep the
        // hash that they had before there was one
        if (m.emission_texture >= 0) h.word(uint64_t(m.emission_texture) << 8 | 5);
        if (!m.colors.empty()) {
            h.word(7);
            h.array(m.colors);
        }
    }
    h.word(d.instances.size());
    for (const Instance& i : d.instances) {
        h.array(i.meshes);
        h.bytes(i.to_world.m.data(), sizeof i.to_world.m);
    }
    for (const Material& m : d.materials) add(h, m);
    // Pixels count, not paths: a scene that was moved has the same hash
    for (const Image& i : d.images) {
        h.look_up(i);
        h.values(i);
    }
    for (const PointLight& l : d.point_lights) {
        // Kinds of lights have numbers, so that no list runs into the next
        h.word(1);
        h.vec(l.position);
        h.vec(l.intensity);
        if (l.cone.falloff == Falloff::kNone) continue;
        h.word(uint64_t(l.cone.falloff));
        h.vec(l.cone.axis);
        h.floats({l.cone.cos_inner, l.cone.cos_outer});
    }
    for (const DirectionalLight& l : d.directional_lights) {
        h.word(2);
        h.vec(l.direction);
        h.vec(l.irradiance);
    }
    for (const SphereLight& l : d.sphere_lights) {
        h.word(3);
        h.vec(l.center);
        h.floats({l.radius});
        h.vec(l.radiance);
    }
    if (d.environment) {
        h.word(4);
        h.vec(d.environment->scale);
        h.word(uint64_t(d.environment->image + 1));
        h.bytes(d.environment->to_world.m.data(), sizeof d.environment->to_world.m);
    }
    for (const Camera& c : d.cameras) add(h, c);
    return h.hex();
}

/// What rays can hit, and holes in it. Names, colours and lights are left out.
std::string geometry_hash(const SceneDescription& d) {
    Hasher h;
    for (const Mesh& m : d.meshes) {
        h.array(m.vertices);
        h.array(m.triangles);
        h.word(m.in_world);
        const Material& material = d.materials[size_t(m.material)];
        if (material.opacity < 1) h.floats({material.opacity});
        if (has_alpha(m.colors)) {
            h.floats({material.alpha_cutoff});
            h.word(m.colors.size());
            for (VertexColor c : m.colors) h.word(c.a);
        }
        if (material.alpha_texture < 0) continue;
        const Image& alpha = d.images[size_t(material.alpha_texture)];
        h.floats({material.alpha_cutoff});
        h.array(m.uvs);
        h.look_up(alpha);
        h.values(alpha);
    }
    h.word(d.instances.size());
    for (const Instance& i : d.instances) {
        h.array(i.meshes);
        h.bytes(i.to_world.m.data(), sizeof i.to_world.m);
    }
    for (const SphereLight& l : d.sphere_lights) {
        h.vec(l.center);
        h.floats({l.radius});
    }
    return h.hex();
}

}  // namespace viscache
