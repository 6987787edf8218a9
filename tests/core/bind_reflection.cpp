// BSDFs for rows of arrays; batched kernels of reflection, directions and places in images, each with a
// chosen instruction set.

#include "isa_argument.h"
#include "real_numbers.h"
#include "rows.h"
#include "viscache/render/glossy_sums.h"
#include "viscache/sampling/sphere_batch.h"
#include "viscache/scene/bsdf.h"
#include "viscache/scene/latlong_batch.h"
#include "viscache/scene/lobes.h"

namespace viscache::bindings {
namespace {

using IsaName = std::optional<std::string>;

struct Arrays {
    std::vector<float> x, y, z;
    explicit Arrays(size_t n) : x(n), y(n), z(n) {}
    std::vector<Vec3> rows(size_t n) const {
        std::vector<Vec3> out;
        for (size_t i = 0; i < n; ++i) out.push_back({x[i], y[i], z[i]});
        return out;
    }
};

py::tuple reflected(const ShadingPoint& sp, const FloatArray& wi, const IsaName& isa) {
    const auto w = vec3s(wi, "wi");
    const size_t n = (w.size() + 15) / 16 * 16;
    Arrays d(n), f(n);
    std::vector<float> pdf(n);
    for (size_t i = 0; i < w.size(); ++i) {
        d.x[i] = w[i].x;
        d.y[i] = w[i].y;
        d.z[i] = w[i].z;
    }
    reflect_directions(lobe_constants(sp),
                       {d.x.data(), d.y.data(), d.z.data(), f.x.data(), f.y.data(), f.z.data(), pdf.data()},
                       n, isa_of(isa));
    return py::make_tuple(from_vec3s(f.rows(w.size())), py::array_t<float>(w.size(), pdf.data()));
}

py::array_t<float> sphere(uint32_t scramble_x, uint32_t scramble_y, uint32_t first, size_t n,
                          const IsaName& isa) {
    Arrays d((n + 15) / 16 * 16);
    sphere_batch(scramble_x, scramble_y, first, d.x.size(), d.x.data(), d.y.data(), d.z.data(), isa_of(isa));
    return from_vec3s(d.rows(n));
}

py::array_t<float> latlong(const std::array<std::array<double, 3>, 3>& to_world, float y, float first,
                           float step, size_t n, const IsaName& isa) {
    Affine a;
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) a.m[i][j] = to_world[i][j];
    py::array_t<float> out({py::ssize_t(2), py::ssize_t(n)});
    latlong_batch(LatLongTurn(a), y, first, step, n, out.mutable_data(0, 0), out.mutable_data(1, 0),
                  isa_of(isa));
    return out;
}

py::tuple bilinear(const FloatArray& u, const FloatArray& v, int width, int height, const IsaName& isa) {
    const auto n = size_t(u.size());
    if (n != size_t(v.size()) || n > BilinearPlaces::kMost)
        throw py::value_error("u and v must have one length, of at most 512");
    BilinearPlaces p;
    bilinear_places({u.data(), n}, {v.data(), n}, width, height, p, isa_of(isa));
    py::array_t<int32_t> pixels({py::ssize_t(4), py::ssize_t(n)});
    py::array_t<float> shares({py::ssize_t(2), py::ssize_t(n)});
    const int32_t* corners[] = {p.up_left, p.up_right, p.down_left, p.down_right};
    for (size_t c = 0; c < 4; ++c) std::copy_n(corners[c], n, pixels.mutable_data(py::ssize_t(c), 0));
    std::copy_n(p.right, n, shares.mutable_data(0, 0));
    std::copy_n(p.down, n, shares.mutable_data(1, 0));
    return py::make_tuple(pixels, shares);
}

py::tuple glossy_sum(const ShadingPoint& sp, Float3 position, int semantic, const FloatArray& far,
                     const FloatArray& normal, const FloatArray& value, float bound2,
                     const std::vector<bool>& seen, const IsaName& isa) {
    const auto y = vec3s(far, "far"), m = vec3s(normal, "normal"), v = vec3s(value, "value");
    SharedLights lights;
    lights.ends.semantic = Semantic(semantic);
    lights.bound2 = bound2;
    for (size_t k = 0; k < y.size(); ++k) lights.add(y[k], m.at(k), y[k], v.at(k), 0);
    lights.pad();
    BitMatrix row(1, y.size());
    for (size_t k = 0; k < y.size(); ++k)
        if (seen.at(k)) row.set(0, k);
    const Rgb sum = sum_row_glossy(lights, {vec3(position), sp.ng, sp.ns}, sp, row.row(0), isa_of(isa));
    return py::make_tuple(sum.x, sum.y, sum.z);
}

void bind_bsdf(py::module_& t) {
    t.def(
        "diffuse_albedo", [](const ShadingPoint& sp) { return array3(diffuse_albedo(sp)); }, py::arg("sp"),
        "Albedo of the diffuse part for light from wo.");
    t.def(
        "pdf_bsdf",
        [](const ShadingPoint& sp, const FloatArray& wi) {
            return map_rows<Vec3>(wi, "wi", [&](Vec3 w) { return pdf_bsdf(sp, w); });
        },
        py::arg("sp"), py::arg("wi"), "Density of `sample_bsdf` per solid angle, (N,).");
    t.def(
        "sample_bsdf",
        [](const ShadingPoint& sp, const FloatArray& u) {
            std::vector<Vec3> wi, weight;
            const auto pdf = map_rows<Vec3>(u, "u", [&](Vec3 v) {
                const auto sample = sample_bsdf(sp, v.x, {v.y, v.z});
                wi.push_back(sample ? sample->wi : Vec3{});
                weight.push_back(sample ? sample->weight : Rgb{});
                return sample ? sample->pdf : 0.f;
            });
            return std::tuple(from_vec3s(wi), from_vec3s(weight), pdf);
        },
        py::arg("sp"), py::arg("u"),
        "Directions (N, 3), weights f·cos/pdf (N, 3) and densities (N,) for u (N, 3); density 0: no sample.");
}

}  // namespace

void bind_reflection(py::module_& t) {
    bind_bsdf(t);
    t.def("reflect_directions", &reflected, py::arg("sp"), py::arg("wi"), py::kw_only(),
          py::arg("isa") = py::none(), "f·cos (N, 3) and densities of `sample_bsdf` (N,).");
    t.def("sphere_batch", &sphere, py::arg("scramble_x"), py::arg("scramble_y"), py::kw_only(),
          py::arg("first") = 0, py::arg("n"), py::arg("isa") = py::none(),
          "Directions (n, 3) of a randomised (0,2)-sequence, uniform on the sphere.");
    t.def(
        "latlong_batch", &latlong, py::arg("to_world"), py::kw_only(), py::arg("y"), py::arg("first"),
        py::arg("step"), py::arg("n"), py::arg("isa") = py::none(),
        "Columns and rows (2, n) in a lat-long image of points ((first + i)·step, y) of the equal-area map.");
    t.def("bilinear_places", &bilinear, py::arg("u"), py::arg("v"), py::kw_only(), py::arg("width"),
          py::arg("height"), py::arg("isa") = py::none(),
          "The four pixels (4, n) around places of a lat-long image, row by row of the image, and the shares "
          "(2, n) of the right column and the lower row.");
    t.def("glossy_sum", &glossy_sum, py::arg("sp"), py::arg("position"), py::kw_only(), py::arg("semantic"),
          py::arg("far"), py::arg("normal"), py::arg("value"), py::arg("bound2"), py::arg("seen"),
          py::arg("isa") = py::none(), "Sum of f·g·value over the visible columns.");
}

}  // namespace viscache::bindings
