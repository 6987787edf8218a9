#pragma once
// Traces rays from NumPy arrays through any ray caster: the methods of the bound classes.
#include "arrays.h"
#include "interrupt.h"
#include "row_view.h"
#include "viscache/casters/check_rays.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/visibility/visible_matrix.h"

namespace viscache::bindings {

// Rays between two looks for Ctrl-C, and the piece of work of a thread
constexpr size_t kChunk = 1 << 13;
constexpr size_t kQuick = 1 << 18;  // calls with fewer rays end too soon for Ctrl-C to matter

inline void require_usable(const Rows& rows, size_t n, const char* name) {
    if (const auto i = first_unusable(rows, n)) {
        const Vec3 row = rows[*i];
        throw py::value_error(std::string(name) + " must be finite and at most 1e16 in size, row " +
                              std::to_string(*i) + " is (" + std::to_string(row.x) + ", " +
                              std::to_string(row.y) + ", " + std::to_string(row.z) + ")");
    }
}

inline void require_usable(const FloatArray& a, const char* name) {
    require_rows(a, 3, name);
    require_usable(Rows{a.data()}, size_t(a.shape(0)), name);
}

inline void require_same_rows(const py::array& a, const py::array& b, const char* names) {
    if (a.shape(0) != b.shape(0))
        throw py::value_error(std::string(names) + " must have equal numbers of rows, got " + shape_text(a) +
                              " and " + shape_text(b));
}

/// t_max as an array: one number for all rays, or one per ray. Its values are not checked yet.
inline FloatArray distances_of_shape(const py::object& t_max, size_t n) {
    require_real(t_max);
    auto a = FloatArray::ensure(t_max);
    // NumPy's own error is replaced by one that says what must hold.
    if (!a) PyErr_Clear();
    if (!a || a.ndim() > 1 || (a.ndim() == 1 && size_t(a.shape(0)) != n))
        throw py::value_error("t_max must be a number or have shape (" + std::to_string(n) + ",)");
    return a;
}

inline void require_distances(const FloatArray& t_max) {
    for (py::ssize_t i = 0; i < t_max.size(); ++i)
        if (!(t_max.data()[i] >= 0))
            throw py::value_error("t_max must be >= 0, got " + std::to_string(t_max.data()[i]));
}

/// The same, checked. Throws for NaN.
inline FloatArray distances(const py::object& t_max, size_t n) {
    FloatArray a = distances_of_shape(t_max, n);
    require_distances(a);
    return a;
}

/// A ray without an end. It is empty if its direction is zero.
inline Ray endless(Vec3 origin, Vec3 direction) {
    // Length 0 in the end: rays without a direction hit nothing.
    return {origin, 0, direction, direction == Vec3{} ? 0.f : kInfinity};
}

/// Checked origins and directions of rays.
struct RayRows {
    size_t n;
    const Vec3 *origins, *directions;

    RayRows(const FloatArray& o, const FloatArray& d) {
        require_usable(o, "origins");
        require_usable(d, "directions");
        require_same_rows(o, d, "origins and directions");
        n = size_t(o.shape(0));
        origins = rows3(o, "origins");
        directions = rows3(d, "directions");
    }
    Ray operator[](size_t i) const { return endless(origins[i], directions[i]); }
    std::vector<Ray> part(size_t first, size_t last) const {
        std::vector<Ray> rays(last - first);
        for (size_t i = first; i < last; ++i) rays[i - first] = (*this)[i];
        return rays;
    }
};

/// Calls work(first, last, worker) for chunks of [0, n) on several threads.
template <class Work>
void in_chunks(size_t n, int threads, Work work, size_t size = kChunk) {
    const auto chunk = [&](size_t c, int worker) { work(c * size, std::min(n, (c + 1) * size), worker); };
    const size_t chunks = (n + size - 1) / size;
    // Quick calls need no second thread that looks for Ctrl-C.
    if (n < kQuick) {
        const WithoutGil release;
        parallel_for(chunks, threads, chunk);
    } else {
        run_interruptible([&](Control& control) {
            parallel_for(chunks, threads, [&](size_t c, int worker) {
                control.check();
                chunk(c, worker);
            });
        });
    }
}

/// Whether each ray hits anything in [0, t_max].
inline py::array_t<bool> any_hits(const RayCaster& caster, const FloatArray& o, const FloatArray& d,
                                  const py::object& t_max, int threads) {
    const RayRows given(o, d);
    const FloatArray t = distances(t_max, given.n);
    const float* ends = t.data();
    // 0 for one distance of all rays: every ray reads the same one.
    const size_t stride = size_t(t.ndim() == 1);
    py::array_t<bool> result{py::ssize_t(given.n)};
    auto* out = reinterpret_cast<uint8_t*>(result.mutable_data());
    in_chunks(given.n, threads, [&](size_t first, size_t last, int) {
        std::vector<Ray> rays = given.part(first, last);
        for (size_t i = first; i < last; ++i)
            // A ray without a direction stays empty.
            rays[i - first].t_max = std::min(rays[i - first].t_max, ends[i * stride]);
        caster.occluded(rays, {out + first, last - first});
    });
    return result;
}

inline py::array_t<bool> visible_rows(const RayCaster& caster, const FloatArray& xs, const FloatArray& ys,
                                      int threads) {
    require_usable(xs, "x");
    require_usable(ys, "y");
    require_same_rows(xs, ys, "x and y");
    const Vec3 *x = rows3(xs, "x"), *y = rows3(ys, "y");
    const size_t n = size_t(xs.shape(0));
    py::array_t<bool> result{py::ssize_t(n)};
    bool* out = result.mutable_data();
    in_chunks(n, threads, [&](size_t first, size_t last, int) {
        const size_t count = last - first;
        visible_pairs(caster, {x + first, count}, {y + first, count}, {out + first, count});
    });
    return result;
}

/// Checked points and targets, and their matrix of (N, ceil(M / 64)) words.
struct MatrixCall {
    std::span<const Vec3> from, to;
    py::array_t<Word> bits;
    std::span<Word> rows;

    MatrixCall(const FloatArray& points, const FloatArray& targets) {
        require_usable(points, "points");
        require_usable(targets, "targets");
        from = {rows3(points, "points"), size_t(points.shape(0))};
        to = {rows3(targets, "targets"), size_t(targets.shape(0))};
        bits = py::array_t<Word>({py::ssize_t(from.size()), py::ssize_t(words_for(to.size()))});
        rows = {bits.mutable_data(), size_t(bits.size())};
    }
};

/// Visibility of every target from every point.
inline py::array_t<Word> visible_bits(const RayCaster& caster, const FloatArray& points,
                                      const FloatArray& targets, int threads, const py::object& progress) {
    MatrixCall call(points, targets);
    run_interruptible(
        [&](Control& control) { visible_matrix(caster, call.from, call.to, call.rows, threads, control); },
        progress);
    return call.bits;
}

/// Nearest hits. Triangles have the numbers of `caster.scene()`.
template <class Caster>
py::tuple nearest_hits(const Caster& caster, const FloatArray& o, const FloatArray& d, int threads) {
    const RayRows given(o, d);
    const size_t n = given.n;
    py::array_t<float> t{py::ssize_t(n)}, uv({py::ssize_t(n), py::ssize_t(2)});
    py::array_t<int64_t> triangle{py::ssize_t(n)}, instance{py::ssize_t(n)};
    float *t_out = t.mutable_data(), *uv_out = uv.mutable_data();
    int64_t *triangle_out = triangle.mutable_data(), *instance_out = instance.mutable_data();
    run_interruptible([&](Control& control) {
        parallel_for((n + kChunk - 1) / kChunk, threads, [&](size_t chunk, int) {
            control.check();
            const size_t first = chunk * kChunk, last = std::min(n, first + kChunk);
            std::vector<Hit> hits(last - first);
            // Nothing is known about the rays of a user.
            caster.intersect(given.part(first, last), hits, Coherence::kIncoherent);
            for (size_t i = first; i < last; ++i) {
                const Hit& h = hits[i - first];
                const float nan = std::numeric_limits<float>::quiet_NaN();
                t_out[i] = h.t;
                triangle_out[i] =
                    h.valid() ? int64_t(caster.scene().first_triangle(h.mesh) + h.triangle) : -1;
                instance_out[i] = h.valid() && h.instance != kNoHit ? int64_t(h.instance) : -1;
                uv_out[2 * i] = h.valid() ? h.u : nan;
                uv_out[2 * i + 1] = h.valid() ? h.v : nan;
            }
        });
    });
    return py::make_tuple(t, triangle, uv, instance);
}

/// Binds `visible` and `visible_matrix` on a class.
template <class Class>
void bind_segments(Class& bound) {
    bound.def("visible", &visible_rows, py::arg("x"), py::arg("y"), py::arg("threads") = 0)
        .def("visible_matrix", &visible_bits, py::arg("points"), py::arg("targets"), py::arg("threads") = 0,
             py::arg("progress") = py::none());
}

/// Binds all queries on a class. `intersect` needs Caster::scene.
template <class Class>
void bind_queries(Class& bound) {
    using Caster = typename Class::type;
    bound
        .def("occluded", &any_hits, py::arg("origins"), py::arg("directions"), py::arg("t_max"),
             py::arg("threads") = 0)
        .def("intersect", &nearest_hits<Caster>, py::arg("origins"), py::arg("directions"),
             py::arg("threads") = 0);
    bind_segments(bound);
}

}  // namespace viscache::bindings
