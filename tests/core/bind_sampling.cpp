// Random numbers, low-discrepancy points, discrete distributions and octahedral maps.
#include "isa_argument.h"
#include "rows.h"
#include "viscache/math/equal_area_batch.h"
#include "viscache/math/octahedral.h"
#include "viscache/sampling/distribution.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache::bindings {

namespace {

/// Calls draw(rng) `count` times for every key: (seed, purpose, pixel, pass).
template <class Value, class Draw>
py::array_t<Value> draws(const WordArray& keys, py::ssize_t count, Draw draw) {
    require_rows(keys, 4, "keys");
    if (count < 0) throw py::value_error("count must be >= 0, got " + std::to_string(count));
    py::array_t<Value> out({keys.shape(0), count});
    Value* to = out.mutable_data();
    for (py::ssize_t i = 0; i < keys.shape(0); ++i) {
        const uint64_t* k = keys.data(i, 0);
        Rng rng(k[0], Purpose(k[1]), k[2], k[3]);
        for (py::ssize_t j = 0; j < count; ++j) *to++ = draw(rng);
    }
    return out;
}

void bind_sequences(py::module_& t) {
    t.def(
        "random_u32",
        [](const WordArray& keys, py::ssize_t count) {
            return draws<uint32_t>(keys, count, [](Rng& rng) { return rng.next_u32(); });
        },
        py::arg("keys"), py::arg("count"),
        "First `count` numbers of each stream; keys (N, 4) are (seed, purpose, pixel, pass). (N, count) "
        "uint32.");
    t.def(
        "random",
        [](const WordArray& keys, py::ssize_t count) {
            return draws<float>(keys, count, [](Rng& rng) { return rng.next(); });
        },
        py::arg("keys"), py::arg("count"), "The same numbers as floats in [0, 1).");
    t.def(
        "sobol02",
        [](const UintArray& index, uint32_t scramble_x, uint32_t scramble_y) {
            if (index.ndim() != 1)
                throw py::value_error("index must have shape (N,), got " + shape_text(index));
            py::array_t<float> out = rows_of<Vec2>(index.shape(0));
            auto* to = reinterpret_cast<Vec2*>(out.mutable_data());
            for (py::ssize_t i = 0; i < index.shape(0); ++i)
                to[i] = sobol02(index.at(i), scramble_x, scramble_y);
            return out;
        },
        py::arg("index"), py::arg("scramble_x"), py::arg("scramble_y"),
        "Points of the Owen-scrambled (0, 2)-sequence, (N, 2) in [0, 1).");
    t.def(
        "radical_inverse",
        [](uint32_t base, uint64_t index) {
            if (base < 2) throw py::value_error("base must be >= 2, got " + std::to_string(base));
            return radical_inverse(base, index);
        },
        py::arg("base"), py::arg("index"), "Digits of `index` mirrored at the radix point, in [0, 1).");
}

void bind_distribution(py::module_& t) {
    py::class_<Distribution1D>(t, "Distribution1D", "Discrete distribution of indices with given weights.")
        .def(py::init([](const DoubleArray& weights) {
                 if (weights.ndim() != 1)
                     throw py::value_error("weights must have shape (N,), got " + shape_text(weights));
                 return Distribution1D({weights.data(), size_t(weights.size())});
             }),
             py::arg("weights"))
        .def(
            "sample",
            [](const Distribution1D& d, const DoubleArray& u) {
                py::array_t<int64_t> index(u.size());
                py::array_t<double> pmf(u.size());
                py::array_t<float> rest(u.size());
                for (py::ssize_t i = 0; i < u.size(); ++i) {
                    if (!(u.data()[i] >= 0 && u.data()[i] < 1))
                        throw py::value_error("u must be in [0, 1), got " + std::to_string(u.data()[i]));
                    const auto pick = d.sample(u.data()[i]);
                    index.mutable_at(i) = int64_t(pick.index);
                    pmf.mutable_at(i) = pick.pmf;
                    rest.mutable_at(i) = pick.u;
                }
                return std::tuple(index, pmf, rest);
            },
            py::arg("u"), "Index, its probability, and u rescaled to [0, 1) inside its interval, each (N,).")
        .def(
            "pmf",
            [](const Distribution1D& d, size_t index) {
                if (index >= d.size())
                    throw py::index_error("index must be < " + std::to_string(d.size()) + ", got " +
                                          std::to_string(index));
                return d.pmf(index);
            },
            py::arg("index"), "Probability of an index.")
        .def_property_readonly("total", &Distribution1D::total)
        .def("__len__", &Distribution1D::size);
}

/// Points (N, 2), N a multiple of kEqualAreaLanes, to directions and back, in batches.
py::tuple equal_area_round_trip(const FloatArray& points, const std::optional<std::string>& isa) {
    require_rows(points, 2, "points");
    const py::ssize_t rows = points.shape(0);
    const size_t n = size_t(rows);
    if (n % kEqualAreaLanes)
        throw py::value_error("the number of points must be a multiple of 16, got " + std::to_string(n));
    std::vector<float> u(n), v(n), x(n), y(n), z(n);
    for (size_t i = 0; i < n; ++i) {
        u[i] = *points.data(i, 0);
        v[i] = *points.data(i, 1);
    }
    equal_area_to_directions(u.data(), v.data(), n, x.data(), y.data(), z.data(), isa_of(isa));
    directions_to_equal_area(x.data(), y.data(), z.data(), n, u.data(), v.data(), isa_of(isa));
    py::array_t<float> directions = rows_of<Vec3>(rows), back = rows_of<Vec2>(rows);
    auto* d = reinterpret_cast<Vec3*>(directions.mutable_data());
    auto* p = reinterpret_cast<Vec2*>(back.mutable_data());
    for (size_t i = 0; i < n; ++i) {
        d[i] = {x[i], y[i], z[i]};
        p[i] = {u[i], v[i]};
    }
    return py::make_tuple(directions, back);
}

void bind_octahedral(py::module_& t) {
    t.def(
        "direction_to_octahedral",
        [](const FloatArray& d) { return map_rows<Vec3>(d, "d", direction_to_octahedral); }, py::arg("d"),
        "Octahedral map of directions (N, 3) into [0, 1]², (N, 2).");
    t.def(
        "octahedral_to_direction",
        [](const FloatArray& p) { return map_rows<Vec2>(p, "p", octahedral_to_direction); }, py::arg("p"),
        "Its inverse: (N, 2) to unit vectors (N, 3).");
    t.def("equal_area_round_trip", &equal_area_round_trip, py::arg("points"), py::arg("isa") = py::none(),
          "Equal-area map of points (N, 2) to directions (N, 3), and these back, in batches.");
}

}  // namespace

void bind_sampling(py::module_& t) {
    bind_sequences(t);
    bind_distribution(t);
    bind_octahedral(t);
}

}  // namespace viscache::bindings
