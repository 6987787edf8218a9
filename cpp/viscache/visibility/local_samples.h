#pragma once
// Light samples that belong to single eye points, stored for many eye points at once.
#include <cstdint>
#include <vector>

#include "viscache/visibility/shadow_ray.h"

namespace viscache {

/// Samples of one light group and semantic, one eye point after the other.
struct LocalSamples {
    Semantic semantic = Semantic::kSolidAngle;
    int group = 0;
    float t_max = kInfinity;            ///< length of directional rays; unused for positions
    std::vector<uint32_t> eye, end;     ///< the eye points, and the end of each one's samples
    std::vector<float> x, y, z;         ///< positions, or unit directions
    std::vector<Vec3> normal, ray_end;  ///< for positions, as in ShadowQuery; empty for directions
    std::vector<float> density;         ///< D_l of all techniques together
    /// D_l of light sampling alone; the same for every eye point.
    std::vector<float> light_density;

    size_t size() const { return x.size(); }
    bool is_direction() const { return viscache::is_direction(semantic); }
    size_t begin_of(size_t row) const { return row ? end[row - 1] : 0; }
    Vec3 far(size_t i) const { return {x[i], y[i], z[i]}; }
    /// Target of the ray of sample i: a direction or an end point.
    Vec3 target(size_t i) const { return is_direction() ? far(i) : ray_end[i]; }

    void clear() {
        eye.clear();
        end.clear();
        x.clear();
        y.clear();
        z.clear();
        normal.clear();
        ray_end.clear();
        density.clear();
        light_density.clear();
    }
    /// Adds a sample of the current eye point.
    void add(Vec3 to, float all_techniques, float light_alone) {
        x.push_back(to.x);
        y.push_back(to.y);
        z.push_back(to.z);
        density.push_back(all_techniques);
        light_density.push_back(light_alone);
    }
    // Branch-free insertion of many samples: make room for n, put or skip each one, then trim.
    void make_room(size_t n) {
        count_ = size();
        for (auto* v : {&x, &y, &z, &density, &light_density}) v->resize(count_ + n + 1);
    }
    size_t room() const { return x.size(); }
    size_t next() const { return count_; }
    void put(Vec3 to, float all_techniques, float light_alone, bool keep) {
        x[count_] = to.x;
        y[count_] = to.y;
        z[count_] = to.z;
        density[count_] = all_techniques;
        light_density[count_] = light_alone;
        count_ += keep;
    }
    void trim() {
        for (auto* v : {&x, &y, &z, &density, &light_density}) v->resize(count_);
    }
    /// Assigns the samples added since the last call to this eye point.
    void close(uint32_t eye_point) {
        eye.push_back(eye_point);
        end.push_back(uint32_t(size()));
    }

    ShadowQuery query(uint32_t eye_point, size_t i) const {
        ShadowQuery q;
        q.eye = eye_point;
        q.semantic = semantic;
        q.group = uint8_t(group);
        q.far = far(i);
        if (!is_direction()) {
            q.far_normal = normal[i];
            q.ray_end = ray_end[i];
        }
        q.density = density[i];
        q.t_max = t_max;
        return q;
    }
    /// Ray of sample i.
    Ray ray(const EyeBlock& eyes, uint32_t eye_point, size_t i) const {
        if (is_direction()) return {eyes.origin[eye_point], 0, far(i), t_max};
        return segment_to_point(eyes.origin[eye_point], ray_end[i]);
    }

private:
    size_t count_ = 0;  ///< number of samples while there is spare room
};

/// Calls visit(eye point, sample) for all samples.
template <class Visit>
void for_each_sample(const LocalSamples& samples, Visit visit) {
    for (size_t row = 0; row < samples.eye.size(); ++row)
        for (size_t i = samples.begin_of(row); i < samples.end[row]; ++i) visit(samples.eye[row], i);
}

}  // namespace viscache
