// Estimates at one point with tabulated light, reflection and maps.
#include <pybind11/native_enum.h>

#include "bound_maps.h"
#include "interrupt.h"
#include "table_reflection.h"
#include "viscache/vismap/point_estimate.h"

namespace viscache::bindings {

namespace {

/// η is the share of the density that no map can take away; 1 means product sampling.
void require_eta(double eta) {
    if (!(eta > 0 && eta <= 1)) throw py::value_error("eta must be in (0, 1], got " + std::to_string(eta));
}

/// A point with tabulated reflection and maps.
struct BoundPoint {
    std::shared_ptr<const EnvironmentPyramid> light;
    TableReflection b;
    BoundMaps maps;
    PointEstimate point;

    BoundPoint(std::shared_ptr<const EnvironmentPyramid> l, const FloatArray& table, const BoolArray& bits,
               const FloatArray& beta, const std::vector<BoolArray>& dilated, double eta)
        : light(std::move(l)), b(table), maps(bits, beta, dilated) {
        require_eta(eta);
        // Dilated maps shape the density and nothing else.
        if (eta < 1 && maps.view.count && !maps.dilated())
            throw py::value_error("dilated must be given where eta < 1");
        // B is constant in a cell of its table; finer cells than texels could not be sampled.
        if (b.level() > light->levels()) throw py::value_error("b must not be finer than the environment");
        point.begin(*light, b, maps.view.m);
        point.look(maps.view, maps.dilated());
        if (eta < 1) point.guide(eta);
    }
    DirectionSample draw(Point2 u) const {
        const ProductTree::Sample s = point.draw(u);
        return point.complete(s, b.value(light->levels(), s.texel));
    }
    // Tables of Python are in rows, the core's in Morton order.
    uint32_t row_major(uint32_t texel) const {
        return gather2(texel >> 1) << light->levels() | gather2(texel);
    }
};

py::dict samples_of(const BoundPoint& p, const DoubleArray& u) {
    require_rows(u, 2, "u");
    if (p.point.dark()) throw py::value_error("total must be > 0 to draw samples, got 0");
    const py::ssize_t n = u.shape(0);
    py::array_t<int64_t> texel(n);
    py::array_t<double> f({n, py::ssize_t(3)}), g({n, py::ssize_t(3)}), z(n), w(n), d(n);
    for (py::ssize_t i = 0; i < n; ++i) {
        const double x = u.at(i, 0), y = u.at(i, 1);
        if (!(x >= 0 && x < 1 && y >= 0 && y < 1)) throw py::value_error("u must be in [0, 1)");
        const DirectionSample s = p.draw({x, y});
        texel.mutable_at(i) = p.row_major(s.texel);
        for (int c = 0; c < 3; ++c) {
            f.mutable_at(i, c) = s.f[size_t(c)];
            g.mutable_at(i, c) = s.g[size_t(c)];
        }
        z.mutable_at(i) = s.z;
        w.mutable_at(i) = s.w;
        d.mutable_at(i) = s.d;
    }
    return py::dict(py::arg("texel") = texel, py::arg("f") = f, py::arg("g") = g, py::arg("z") = z,
                    py::arg("w") = w, py::arg("d") = d);
}

/// Independent passes; each has its own number of samples.
py::array_t<double> simulate(const BoundPoint& p, const BoolArray& visible, const std::vector<int>& sizes,
                             int replicates, PointSet set, AlphaMode mode, double value, uint64_t seed,
                             int threads) {
    const py::ssize_t edge = py::ssize_t{1} << p.light->levels();
    if (visible.ndim() != 2 || visible.shape(0) != edge || visible.shape(1) != edge)
        throw py::value_error("visible must have shape (" + std::to_string(edge) + ", " +
                              std::to_string(edge) + "), got " + shape_text(visible));
    const bool some = !sizes.empty() && *std::min_element(sizes.begin(), sizes.end()) >= 1;
    if (!some || replicates < 1) throw py::value_error("n, passes, sizes and replicates must be >= 1");
    // Samples of an even set are not independent, and leaving one out would bias α.
    if (mode == AlphaMode::kLeaveOneOut && set != PointSet::kIndependent)
        throw py::value_error("leave-one-out needs independent points");
    py::array_t<double> out({py::ssize_t(replicates), py::ssize_t(sizes.size()), py::ssize_t(3)});
    double* to = out.mutable_data();
    const bool* v = visible.data();
    // The pointers were taken with the lock; replicates write to places of their own.
    run_interruptible([&](Control& control) {
        parallel_for(size_t(replicates), threads, [&](size_t r, int) {
            control.check();
            // Sums of the passes so far: what α of the next pass may depend on
            AlphaSums earlier;
            std::vector<DirectionSample> samples;
            std::vector<uint8_t> seen;
            for (size_t pass = 0; pass < sizes.size(); ++pass) {
                // Every replicate and pass has its own points.
                const PointStream stream(set, seed, Purpose::kProduct, r, pass);
                samples.resize(size_t(sizes[pass]));
                seen.resize(samples.size());
                for (size_t i = 0; i < samples.size() && !p.point.dark(); ++i) {
                    samples[i] = p.draw(stream.at(uint32_t(i)));
                    seen[i] = v[p.row_major(samples[i].texel)];
                }
                const Rgbd e = p.point.dark()
                                   ? Rgbd{}
                                   : finish_pass(p.point.moments(), samples, seen, {mode, value}, earlier);
                std::copy(e.begin(), e.end(), to + (r * sizes.size() + pass) * 3);
            }
        });
    });
    return out;
}

/// Reorders cell values from the Morton curve to an image.
py::array_t<double> cells(const std::vector<double>& values, int level) {
    const py::ssize_t edge = py::ssize_t{1} << level;
    py::array_t<double> out({edge, edge});
    for (uint32_t z = 0; z < values.size(); ++z) out.mutable_at(gather2(z >> 1), gather2(z)) = values[z];
    return out;
}

template <class F>
py::array_t<double> of_texels(const BoundPoint& p, F f) {
    const py::ssize_t edge = py::ssize_t{1} << p.light->levels();
    py::array_t<double> out({edge, edge});
    for (uint32_t z = 0; z < uint32_t(edge * edge); ++z) out.mutable_at(gather2(z >> 1), gather2(z)) = f(z);
    return out;
}

void bind_texels(py::class_<BoundPoint>& point) {
    point
        .def(
            "cells", [](const BoundPoint& p) { return cells(p.point.cells().visible, p.maps.view.m); },
            "Ṽ, (2^m, 2^m).")
        .def(
            "density",
            [](const BoundPoint& p) { return of_texels(p, [&](uint32_t z) { return p.point.density(z); }); },
            "D of the texels, (R, R).")
        .def(
            "probabilities",
            [](const BoundPoint& p) {
                const auto m = p.point.tree().texel_masses();
                return of_texels(
                    p, [&](uint32_t z) { return m[z] * p.point.density(z) / p.point.moments().l_ns; });
            },
            "Probability of every texel, (R, R).")
        .def(
            "guided_masses",
            [](const BoundPoint& p, int level) {
                // The density is constant in the cells of the maps.
                if (level < 0 || level > p.maps.view.m) throw py::value_error("level must be in [0, m]");
                const auto m = p.point.tree().density_masses(level);
                return py::array_t<double>(py::ssize_t(m.size()), m.data());
            },
            py::arg("level"), "∫ L·B̃·D over the nodes of a level, along the Morton curve.")
        .def(
            "b_tilde",
            [](const BoundPoint& p) {
                return of_texels(p, [&](uint32_t z) { return double(p.point.tree().b(z)); });
            },
            "Luminance of B̃ of the texels, (R, R).");
}

void bind_integrals_and_samples(py::class_<BoundPoint>& point) {
    point
        .def(
            "flat",
            [](const BoundPoint& p, const std::string& isa) {
                CellTables t;
                // By name: tests compare the variants that this CPU has.
                for (const Isa i : {Isa::kPortable, Isa::kAvx2, Isa::kAvx512})
                    if (isa_name(i) == isa && i <= best_isa()) {
                        const MapIntegrals m =
                            integrate_maps(p.point.tree(), p.maps.view, p.maps.dilated(), t, i);
                        return std::tuple(m.j, m.w2, m.j_colour, m.dilated);
                    }
                throw py::value_error("isa must be one this CPU has, got " + isa);
            },
            py::arg("isa"), "J, ∫ L·B̃·Ṽ², J per channel and ∫ L·B̃·Ṽ^k, computed with one instruction set.")
        .def(
            "walk",
            [](const BoundPoint& p) {
                const WalkIntegrals w = walk_maps(p.point.tree(), p.maps.view);
                return std::tuple(w.j, w.w2, w.nodes);
            },
            "J and ∫ L·B̃·Ṽ² by a joint walk of the quadtrees, and the number of visited nodes.")
        .def("sample", &samples_of, py::arg("u"),
             "texel, f, g, z, w and D of the points (N, 2) of the square.")
        .def(
            "simulate",
            [](const BoundPoint& p, const BoolArray& visible, int n, int passes, int replicates, PointSet set,
               AlphaMode mode, double alpha, uint64_t seed, int threads) {
                // Passes of equal size
                const std::vector<int> sizes(size_t(std::max(passes, 0)), n);
                return simulate(p, visible, sizes, replicates, set, mode, alpha, seed, threads);
            },
            py::arg("visible"), py::kw_only(), py::arg("n"), py::arg("passes") = 1, py::arg("replicates") = 1,
            py::arg("set") = PointSet::kIndependent, py::arg("mode") = AlphaMode::kFixed,
            py::arg("alpha") = 1.0, py::arg("seed") = 0, py::arg("threads") = 1,
            "Estimates (replicates, passes, 3); `visible` (R, R) of bool is the true visibility.")
        .def("simulate", &simulate, py::arg("visible"), py::kw_only(), py::arg("sizes"),
             py::arg("replicates") = 1, py::arg("set") = PointSet::kIndependent,
             py::arg("mode") = AlphaMode::kFixed, py::arg("alpha") = 1.0, py::arg("seed") = 0,
             py::arg("threads") = 1,
             "The same for passes of these sizes. `alpha` belongs to the first pass.");
}

void bind_point(py::module_& s) {
    py::class_<BoundPoint> point(s, "PointEstimate",
                                 "Light × reflection × maps at one point, all given as tables.");
    point
        .def(
            py::init([](std::shared_ptr<EnvironmentPyramid> light, const FloatArray& b, const BoolArray& maps,
                        const FloatArray& beta, const std::vector<BoolArray>& dilated, double eta) {
                return std::make_unique<BoundPoint>(std::move(light), b, maps, beta, dilated, eta);
            }),
            py::arg("light"), py::arg("b"), py::arg("maps"), py::arg("beta"), py::kw_only(),
            py::arg("dilated") = std::vector<BoolArray>{}, py::arg("eta") = 1.0,
            "b (N, N, 3); maps (n, 2^m, 2^m) of bool; dilated: two dilations of the maps (m < 6) or three.")
        .def_property_readonly("l_ns", [](const BoundPoint& p) { return p.point.moments().l_ns; })
        .def_property_readonly("guided", [](const BoundPoint& p) { return p.point.guided(); })
        .def_property_readonly(
            "j", [](const BoundPoint& p) { return p.point.moments().j; }, "J per channel.")
        .def_property_readonly("j_luminance", [](const BoundPoint& p) { return p.point.integrals().j; })
        .def_property_readonly(
            "w2", [](const BoundPoint& p) { return p.point.integrals().w2; }, "∫ L·B̃·Ṽ² of luminances.")
        .def_property_readonly(
            "dilated", [](const BoundPoint& p) { return p.point.integrals().dilated; }, "∫ L·B̃·Ṽ^k.")
        .def_property_readonly("mean_w", [](const BoundPoint& p) { return p.point.moments().mean_w; })
        .def_property_readonly("variance_w",
                               [](const BoundPoint& p) { return p.point.moments().variance_w; });
    bind_texels(point);
    bind_integrals_and_samples(point);
}

}  // namespace

void bind_vismap_estimate(py::module_& m) {
    py::native_enum<AlphaMode>(m, "AlphaMode", "enum.Enum", "How the control variate's α is chosen.")
        .value("FIXED", AlphaMode::kFixed)
        .value("LEAVE_ONE_OUT", AlphaMode::kLeaveOneOut)
        .value("PREVIOUS_PASS", AlphaMode::kPreviousPass)
        .finalize();
    py::module_ s = m.def_submodule("vismap");
    bind_point(s);
}

}  // namespace viscache::bindings
