#pragma once
// How rays are grouped into packets, and with which of Embree's flags a packet is traced. Never by timing:
// the flag changes one answer in 10⁹ by rounding, and every run gives the same bytes.
#include <optional>

#include "viscache/math/bits.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// The rays that share a packet.
enum class PacketOrder {
    kByLight,  ///< 16 neighbouring eye points towards one light: the fastest. Neighbours in space where many
               ///< lights share the cost of sorting, else in the order of the tile
    kByPixel,  ///< one eye point towards 16 lights
};

/// How rows first … first + 15 of a block are traced: by light, unless its packets would have fewer than
/// three rays on average, as where every point asks for a few lights of its own.
PacketOrder order_of_rows(const BitMatrix& wanted, size_t first);

/// The order for a random share of the queries, where it is known: of few queries of an eye point, packets of
/// one light would be nearly empty.
inline std::optional<PacketOrder> order_of_share(double share) {
    constexpr double kDense = 0.25;
    return share >= kDense ? std::nullopt : std::optional(PacketOrder::kByPixel);
}

/// Half the diagonal of the bounding box of 16 points.
float half_diagonal(const float* x, const float* y, const float* z);

/// The flag for rays from the origins of a packet to one point or along one direction.
Coherence flag_from(const RayCaster& caster, const RayPacket16& rays);
/// The flag for rays between neighbours at both ends, such as to samples of one lamp.
Coherence flag_between(const RayCaster& caster, const RayPacket16& rays);

}  // namespace viscache
