// The choice among area lights and the picks of shared lights.

#include <tuple>

#include "checked_rows.h"
#include "real_numbers.h"
#include "viscache/render/emitter_rays.h"
#include "viscache/render/light_choice.h"
#include "viscache/render/light_pick.h"

namespace viscache::bindings {

namespace {

constexpr py::ssize_t kMostPicks = LightsAt::kMostPicks;

ChoiceWay way_named(const std::string& name) {
    if (name == "each") return ChoiceWay::kEach;
    if (name == "tree") return ChoiceWay::kTree;
    throw py::value_error("way must be each or tree, got " + name);
}

/// Receivers of a scene with area lights.
struct Receivers {
    const Scene& scene;
    ChoiceWay way;
    std::span<const Vec3> positions, normals;

    Receivers(const Scene& s, const std::string& name, const FloatArray& x, const FloatArray& n)
        : scene(s), way(way_named(name)), positions(usable(x, "positions")), normals(units(n, "normals")) {
        if (normals.size() != positions.size())
            throw py::value_error("positions and normals must have equal numbers of rows");
        const size_t lights = scene.area_lights().size();
        if (lights == 0) throw py::value_error("scene must have area lights");
        if (way == ChoiceWay::kEach && lights > kMostLightsEach)
            throw py::value_error("way must not be each for more than " + std::to_string(kMostLightsEach) +
                                  " lights, got " + std::to_string(lights));
    }
    size_t size() const { return positions.size(); }
    LightsAt at(size_t i) const { return {scene, way, {positions[i], normals[i]}}; }
};

std::tuple<py::array_t<int64_t>, py::array_t<double>> choose(const Scene& scene, const std::string& way,
                                                             const FloatArray& positions,
                                                             const FloatArray& normals,
                                                             const DoubleArray& u) {
    const Receivers receivers(scene, way, positions, normals);
    if (u.ndim() != 2 || size_t(u.shape(0)) != receivers.size() || u.shape(1) > kMostPicks)
        throw py::value_error("u must have shape (N, K) with K <= " + std::to_string(kMostPicks) + ", got " +
                              shape_text(u));
    const size_t count = size_t(u.shape(1));
    py::array_t<int64_t> light({u.shape(0), u.shape(1)});
    py::array_t<double> pmf({u.shape(0), u.shape(1)});
    std::vector<LightPick> picks(count);
    for (size_t i = 0; i < receivers.size(); ++i) {
        receivers.at(i).pick({u.data() + i * count, count}, picks);
        for (size_t k = 0; k < count; ++k) {
            light.mutable_data()[i * count + k] = picks[k].pmf > 0 ? int64_t(picks[k].light) : -1;
            pmf.mutable_data()[i * count + k] = picks[k].pmf;
        }
    }
    return {light, pmf};
}

py::array_t<double> probabilities(const Scene& scene, const std::string& way, const FloatArray& positions,
                                  const FloatArray& normals) {
    const Receivers receivers(scene, way, positions, normals);
    const size_t lights = scene.area_lights().size();
    py::array_t<double> pmf({py::ssize_t(receivers.size()), py::ssize_t(lights)});
    for (size_t i = 0; i < receivers.size(); ++i) {
        const LightsAt at = receivers.at(i);
        for (size_t k = 0; k < lights; ++k) pmf.mutable_data()[i * lights + k] = at.pmf(k);
    }
    return pmf;
}

py::array_t<double> shares_of_power(const Scene& scene) {
    const AreaLights& lights = scene.area_lights();
    py::array_t<double> share(py::ssize_t(lights.size()));
    for (size_t k = 0; k < lights.size(); ++k) share.mutable_data()[k] = lights.choice.pmf(k);
    return share;
}

std::tuple<py::array_t<int64_t>, py::array_t<float>> nearest(const Scene& scene, const FloatArray& origins,
                                                             const FloatArray& directions) {
    const auto o = usable(origins, "origins"), d = units(directions, "directions");
    if (d.size() != o.size()) throw py::value_error("origins and directions must have equal numbers of rows");
    py::array_t<int64_t> light(origins.shape(0));
    std::vector<Vec3> points(o.size());
    for (size_t i = 0; i < o.size(); ++i) {
        const auto hit = nearest_emitter(scene, {o[i], 0, d[i], kInfinity});
        light.mutable_data()[i] = hit ? int64_t(hit->light) : -1;
        if (hit) points[i] = hit->point;
    }
    return {light, from_vec3s(points)};
}

py::array_t<float> picked(const FloatArray& contributions, size_t most, const DoubleArray& u) {
    const std::span<const float> c(contributions.data(), size_t(contributions.size()));
    py::array_t<float> weights({u.size(), contributions.size()});
    std::fill_n(weights.mutable_data(), weights.size(), 0.f);
    std::vector<PickedLight> picks;
    for (py::ssize_t i = 0; i < u.size(); ++i) {
        float* row = weights.mutable_data(i, 0);
        picks.clear();
        if (!pick_columns(c, most, u.data()[i], picks)) std::fill_n(row, c.size(), 1.f);
        for (const PickedLight& p : picks) row[p.column] += p.weight;
    }
    return weights;
}

}  // namespace

void bind_light_choice(py::module_& t) {
    t.def("choose_light", &choose, py::arg("scene"), py::arg("way"), py::arg("positions"), py::arg("normals"),
          py::arg("u"),
          "Lights (N, K) chosen at points with shading normals by numbers u (N, K), and their probabilities. "
          "Lights are counted over triangles, then spheres; -1: none contributes.");
    t.def("light_probabilities", &probabilities, py::arg("scene"), py::arg("way"), py::arg("positions"),
          py::arg("normals"), "Probabilities (N, lights) of the choice at points with shading normals.");
    t.def("shares_of_power", &shares_of_power, py::arg("scene"),
          "Each light's share (lights,) of the power.");
    t.def("pick_columns", &picked, py::arg("contributions"), py::arg("most"), py::arg("u"),
          "Weights (N, M) of the columns that are picked with the offsets u (N,); 0: not picked. All 1 where "
          "every column counts.");
    t.def("nearest_emitter", &nearest, py::arg("scene"), py::arg("origins"), py::arg("directions"),
          "Lights (N,) that rays find among the lights alone, -1 for none, and the points (N, 3).");
}

}  // namespace viscache::bindings
