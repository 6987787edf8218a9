// Batches, orders and ways of rays in arrays.

#include "caster_queries.h"
#include "isa_argument.h"
#include "real_numbers.h"
#include "viscache/casters/ray_batch.h"
#include "viscache/casters/ray_order.h"
#include "viscache/visibility/packet_choice.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache::bindings {

namespace {

RayArrays rays_of(const RowView& origins, const RowView& directions, const FloatArray& t) {
    return {origins.rows, directions.rows, t.data(), size_t(t.ndim() == 1)};
}

/// Lanes (packets, 8, 16) and masks (packets, 16) of a batch; None if it must not be traced.
py::object packed(const AnyFloatArray& o, const AnyFloatArray& d, const py::object& t_max,
                  const std::optional<UintArray>& order, const std::optional<std::string>& isa) {
    const RowView origins(o, "origins"), directions(d, "directions");
    const FloatArray t = distances_of_shape(t_max, size_t(o.shape(0)));
    if (size_t(o.shape(0)) > RayBatch::kMost) throw py::value_error("a batch has at most 256 rays");
    const RayArrays rays = rays_of(origins, directions, t);
    const auto batch = std::make_unique<RayBatch>(isa_of(isa));
    const bool usable = order ? batch->take(rays, {order->data(), size_t(order->size())})
                              : batch->take(rays, 0, size_t(o.shape(0)));
    if (!usable) return py::none();
    const py::ssize_t packets = py::ssize_t(batch->size() + 15) / 16;
    const RayLanes& lanes = batch->lanes();
    return py::make_tuple(py::array_t<float>({packets, py::ssize_t(8), py::ssize_t(16)}, lanes.packet[0].ox),
                          py::array_t<int32_t>({packets, py::ssize_t(16)}, lanes.asked[0]));
}

/// The order of all rays as one block, and the share of them in the class of their predecessor.
py::tuple order_of(const AnyFloatArray& o, const AnyFloatArray& d, const std::optional<std::string>& isa) {
    const RowView origins(o, "origins"), directions(d, "directions");
    const float end = kInfinity;
    const RayArrays rays{origins.rows, directions.rows, &end, 0};
    RayOrder order(isa_of(isa));
    const size_t n = size_t(o.shape(0));
    const double share = order.share_in_order(rays, 0, n);
    const std::span<const uint32_t> sorted = order.sort(rays, 0, n);
    return py::make_tuple(py::array_t<uint32_t>(py::ssize_t(sorted.size()), sorted.data()), share);
}

/// True if rays between 16 pairs of points are traced with the coherent flag.
bool coherent_between(const RayCaster& caster, const FloatArray& from, const FloatArray& to) {
    const Vec3 *origins = rows3(from, "origins"), *ends = rows3(to, "ends");
    if (from.shape(0) != 16 || to.shape(0) != 16)
        throw py::value_error("origins and ends must have shape (16, 3)");
    RayPacket16 packet;
    for (size_t i = 0; i < 16; ++i) packet.set(i, {origins[i], 0, ends[i] - origins[i], 1});
    return flag_between(caster, packet) == Coherence::kCoherent;
}

/// True if the first 16 rows of bits are traced by light.
bool by_light(const py::array_t<bool, py::array::c_style>& wanted) {
    if (wanted.ndim() != 2) throw py::value_error("wanted must have shape (rows, lights)");
    BitMatrix bits(size_t(wanted.shape(0)), size_t(wanted.shape(1)));
    for (size_t row = 0; row < bits.rows(); ++row)
        for (size_t k = 0; k < bits.columns(); ++k)
            if (wanted.at(row, k)) bits.set(row, k);
    return order_of_rows(bits, 0) == PacketOrder::kByLight;
}

}  // namespace

void bind_ray_batches(py::module_& t) {
    t.def("packed_rays", &packed, py::arg("origins"), py::arg("directions"), py::arg("t_max"), py::kw_only(),
          py::arg("order") = py::none(), py::arg("isa") = py::none(),
          "Lanes and masks of up to 256 rays as Embree gets them; None if one of them must not be traced.");
    t.def("ray_order", &order_of, py::arg("origins"), py::arg("directions"), py::kw_only(),
          py::arg("isa") = py::none(),
          "The order in which rays without order are traced, and their share in order.");
    t.def("coherent_between", &coherent_between, py::arg("caster"), py::arg("origins"), py::arg("ends"),
          "Whether rays between 16 pairs of points (16, 3) are traced with Embree's coherent flag.");
    t.def("by_light", &by_light, py::arg("wanted"),
          "Whether a block of up to 16 rows, with these bits asked, is traced by light.");
}

}  // namespace viscache::bindings
