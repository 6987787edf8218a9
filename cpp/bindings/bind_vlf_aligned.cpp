// Aligned rays: visibility of points along shared axes.

#include "checked_rows.h"
#include "interrupt.h"
#include "isa_argument.h"
#include "real_numbers.h"
#include "viscache/vlf/engine_choice.h"
#include "viscache/vlf/field_rows.h"

namespace viscache::bindings {

namespace {

/// Orthonormal frames from an array (l, 3, 3) with the rows u, v, w.
std::span<const Frame3> checked_frames(const FloatArray& a) {
    if (a.ndim() != 3 || a.shape(1) != 3 || a.shape(2) != 3)
        throw py::value_error("frames must have shape (l, 3, 3), got " + shape_text(a));
    const std::span frames(reinterpret_cast<const Frame3*>(a.data()), size_t(a.shape(0)));
    // Rounded to single precision; a scaled or mirrored frame is off by far more.
    const auto is_one = [](float v) { return std::fabs(v - 1) < 1e-4f; };
    for (size_t i = 0; i < frames.size(); ++i) {
        const Frame3& f = frames[i];
        if (!is_one(length2(f.z)) || !is_one(length2(f.x)) || !is_one(dot(cross(f.x, f.y), f.z)))
            throw py::value_error("frames must be orthonormal and right-handed, row " + std::to_string(i) +
                                  " is not");
    }
    return frames;
}

using OrderArray = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;

/// The order of n points: each index once.
/// Points in another order would be traced all the same, but an index that is missing would leave its row
/// without bits.
std::span<const uint32_t> checked_order(const OrderArray& a, size_t n) {
    const std::span<const uint32_t> order(a.data(), size_t(a.size()));
    std::vector<bool> seen(n);
    for (const uint32_t i : order) {
        if (i >= n || seen[i]) throw py::value_error("order must hold the index of each point once");
        seen[i] = true;
    }
    if (order.size() != n) throw py::value_error("order must hold the index of each point once");
    return order;
}

OrderArray point_order(const FloatArray& positions) {
    const auto points = usable(positions, "points");
    std::vector<uint32_t> order =
        run_interruptible([&](Control& control) { return kd_order(points, control); });
    return OrderArray(py::ssize_t(order.size()), order.data());
}

/// The checked arguments of a call. Ray origins are offset from their surfaces.
struct Call {
    std::vector<Vec3> origin;
    AlignedInput input;
    py::array_t<uint64_t> bits;

    Call(float extent, const FloatArray& positions, const FloatArray& normals, const FloatArray& frames,
         float t_max, const std::optional<OrderArray>& order = std::nullopt) {
        const auto p = usable(positions, "points"), n = units(normals, "normals");
        if (p.size() != n.size())
            throw py::value_error("points and normals must have equal numbers of rows, got " +
                                  shape_text(positions) + " and " + shape_text(normals));
        if (!(t_max > 0)) throw py::value_error("t_max must be > 0, got " + std::to_string(t_max));
        origin = spawned(p, n, extent);
        input = {origin, n, checked_frames(frames), t_max, {}};
        if (order) input.order = checked_order(*order, p.size());
        bits = py::array_t<uint64_t>({p.size(), words_for(input.axes.size())});
    }
    /// Runs work(rows, control) without the interpreter's lock.
    template <class Work>
    void run(Work work, const py::object& progress) {
        run_interruptible(
            // Taken before the lock is released
            [&, rows = std::span(bits.mutable_data(), size_t(bits.size()))](Control& control) {
                control.total = input.axes.size();
                work(rows, control);
            },
            progress);
    }
};

py::tuple batch_rows(const AlignedBatch& batch, const Scene& scene, const FloatArray& positions,
                     const FloatArray& normals, const FloatArray& frames, float t_max,
                     const std::optional<OrderArray>& order, int threads,
                     const std::optional<std::string>& isa, const py::object& progress) {
    Call call(aligned_extent(scene), positions, normals, frames, t_max, order);
    // An unknown variant raises before anything is traced.
    const Isa variant = isa_of(isa);
    AlignedCounts counts;
    call.run([&](std::span<Word> rows,
                 Control& control) { counts = batch.rows(call.input, rows, threads, control, variant); },
             progress);
    py::dict d(py::arg("blocks") = counts.blocks, py::arg("nodes") = counts.nodes,
               py::arg("pairs") = counts.pairs, py::arg("tests") = counts.tests,
               py::arg("wide") = counts.wide, py::arg("exact") = counts.exact);
    return py::make_tuple(call.bits, d);
}

/// The work per ray that a sample predicts.
py::dict sample(const AlignedBatch& batch, const Scene& scene, const FloatArray& positions,
                const FloatArray& normals, const FloatArray& frames, float t_max,
                const std::optional<OrderArray>& order, int threads) {
    Call call(scene.offset_extent(), positions, normals, frames, t_max, order);
    AlignedWork w = run_interruptible(
        [&](Control& control) { return sampled_work(batch, call.input, threads, control); });
    return py::dict(py::arg("blocks") = w.blocks, py::arg("nodes") = w.nodes, py::arg("pairs") = w.pairs,
                    py::arg("tests") = w.tests, py::arg("wide") = w.wide, py::arg("exact") = w.exact,
                    py::arg("free") = w.free);
}

/// (whether the batch is faster, ns per ray of the batch and of Embree)
std::tuple<bool, double, double> choose(const AlignedBatch& batch, const Scene& scene,
                                        const FloatArray& positions, const FloatArray& normals,
                                        const FloatArray& frames, float t_max,
                                        const std::optional<OrderArray>& order, int threads) {
    Call call(scene.offset_extent(), positions, normals, frames, t_max, order);
    EngineChoice c = run_interruptible(
        [&](Control& control) { return choose_engine(batch, call.input, threads, control); });
    return {c.engine == AlignedEngine::kBatch, c.batch_ns, c.embree_ns};
}

py::array_t<uint64_t> embree_rows(const EmbreeCaster& caster, const FloatArray& positions,
                                  const FloatArray& normals, const FloatArray& frames, float t_max,
                                  std::optional<bool> by_axis, int width, std::optional<bool> coherent,
                                  const std::optional<OrderArray>& sorted, int threads,
                                  const py::object& progress) {
    Call call(caster.scene().offset_extent(), positions, normals, frames, t_max, sorted);
    // Not given: the order that is predicted to be faster
    const AlignedOrder order = by_axis ? (*by_axis ? AlignedOrder::kByAxis : AlignedOrder::kByPoint)
                                       : embree_order(caster.scene().placed_triangles(), call.origin.size());
    std::optional<Coherence> flag;
    if (coherent) flag = *coherent ? Coherence::kCoherent : Coherence::kIncoherent;
    call.run(
        [&](std::span<Word> rows, Control& control) {
            viscache::embree_rows(caster, call.input, rows, order, width, flag, threads, control);
        },
        progress);
    return call.bits;
}

py::array_t<uint64_t> field_rows(const VisibilityField& field, const FloatArray& positions,
                                 const FloatArray& normals, const FloatArray& frames, float t_max,
                                 int threads, const py::object& progress) {
    Call call(field.scene().offset_extent(), positions, normals, frames, t_max);
    call.run([&](std::span<Word> rows,
                 Control& control) { viscache::field_rows(field, call.input, rows, threads, control); },
             progress);
    return call.bits;
}

py::dict predict_field_rows(const std::shared_ptr<Scene>& scene, const FieldSettings& settings) {
    // Reading the triangles takes a while for large scenes.
    FieldPrediction p = run_interruptible([&](Control&) {
        return viscache::predict_field_rows({scene, settings.kernel, settings.head_room}, settings);
    });
    return py::dict(py::arg("tests") = p.tests, py::arg("ray_ns") = p.ray_ns, py::arg("build_s") = p.build_s,
                    py::arg("bytes") = p.bytes);
}

}  // namespace

void bind_vlf_aligned(py::module_& m) {
    // The submodule was made by the bindings of the field.
    py::module_ v = m.attr("vlf");
    py::class_<AlignedBatch>(v, "AlignedBatch")
        .def(py::init<std::shared_ptr<const Scene>>(), py::arg("scene"), py::call_guard<WithoutGil>())
        .def("rows", &batch_rows, py::arg("scene"), py::arg("points"), py::arg("normals"), py::arg("frames"),
             py::kw_only(), py::arg("t_max") = kInfinity, py::arg("order") = py::none(),
             py::arg("threads") = 0, py::arg("isa") = py::none(), py::arg("progress") = py::none(),
             "Bit rows (N, words), 1 = free, and counts of the work.")
        .def("sample", &sample, py::arg("scene"), py::arg("points"), py::arg("normals"), py::arg("frames"),
             py::kw_only(), py::arg("t_max") = kInfinity, py::arg("order") = py::none(),
             py::arg("threads") = 0, "Work per ray of the batch, estimated from a sample of the rays.")
        .def("choose", &choose, py::arg("scene"), py::arg("points"), py::arg("normals"), py::arg("frames"),
             py::kw_only(), py::arg("t_max") = kInfinity, py::arg("order") = py::none(),
             py::arg("threads") = 0,
             "True if the batch is the faster engine; predicted ns per ray of the batch and of Embree.")
        .def_property_readonly("triangles", [](const AlignedBatch& b) { return b.triangles().triangles; })
        .def_property_readonly("bytes", [](const AlignedBatch& b) { return b.triangles().bytes(); });
    v.def("is_hopeless", &is_hopeless, py::arg("scene"), py::arg("points"), py::arg("t_max") = kInfinity,
          "True if the batch is slower whatever the scene looks like.");
    v.def("point_order", &point_order, py::arg("points"),
          "Indices (N,) of points in the compact order of the engines for aligned rays.");
    v.def("embree_rows", &embree_rows, py::arg("caster"), py::arg("points"), py::arg("normals"),
          py::arg("frames"), py::kw_only(), py::arg("t_max") = kInfinity, py::arg("by_axis") = py::none(),
          py::arg("width") = 16, py::arg("coherent") = py::none(), py::arg("order") = py::none(),
          py::arg("threads") = 0, py::arg("progress") = py::none(), "The same bits, traced by Embree.");
    v.def("field_rows", &field_rows, py::arg("field"), py::arg("points"), py::arg("normals"),
          py::arg("frames"), py::kw_only(), py::arg("t_max") = kInfinity, py::arg("threads") = 0,
          py::arg("progress") = py::none(), "The same bits, looked up in a field of these directions.");
    v.def("predict_field_rows", &predict_field_rows, py::arg("scene"), py::arg("settings"),
          "Predicted cost in a field that is still to be built: tests per ray, ray_ns, build_s, bytes (at "
          "least).");
    v.attr("FIELD_RAY_NS") = kFieldRayNs;
}

}  // namespace viscache::bindings
