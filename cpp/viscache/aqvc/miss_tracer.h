#pragma once
// Traces the misses of a block: collects them, sorts them by light and traces 16 at a time.
#include <cstdint>
#include <vector>

#include "viscache/visibility/oracle.h"
#include "viscache/visibility/packet_choice.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

/// The ray from `eye` to `light` decides bit `column` of row `row`.
struct Miss {
    uint32_t eye, row, column, light;
};

class MissTracer {
public:
    explicit MissTracer(const RayCaster& caster) : caster_(caster) {}

    /// `flush` throws `Cancelled` soon after `control` requests it.
    void watch(const Control& control) { control_ = &control; }
    void add(const Miss& miss) { misses_.push_back(miss); }
    /// True if there are enough misses for a flush, which bounds the memory at any C_E.
    // 2^19 misses of 16 bytes are 8 MB.
    bool full() const { return misses_.size() >= size_t{1} << 19; }
    /// Traces the collected misses and sets the bits of the visible ones. Returns the number of rays.
    uint64_t flush(const EyeBlock& eyes, const FarEnds& lights, BitMatrix& value) {
        const uint64_t rays = misses_.size();
        // Packets of one light: rays that end at one point from neighbouring eye points are as coherent as
        // misses can be.
        sort_by_light(lights.count);
        for (size_t first = 0; first < misses_.size(); first += kPiece) {
            if (control_) control_->check();
            const std::span piece(sorted_.data() + first, std::min(kPiece, misses_.size() - first));
            for (size_t i = 0; i < piece.size(); i += 16)
                trace16(eyes, lights, piece.subspan(i, std::min<size_t>(16, piece.size() - i)), value);
        }
        misses_.clear();
        return rays;
    }

private:
    static constexpr size_t kPiece = 1024;  ///< rays between checks for cancellation
    /// Stable counting sort.
    void sort_by_light(size_t lights) {
        begin_.assign(lights + 1, 0);
        for (const Miss& m : misses_) ++begin_[m.light + 1];
        for (size_t k = 0; k < lights; ++k) begin_[k + 1] += begin_[k];
        sorted_.resize(misses_.size());
        for (const Miss& m : misses_) sorted_[begin_[m.light]++] = m;
    }
    void trace16(const EyeBlock& eyes, const FarEnds& lights, std::span<const Miss> rays, BitMatrix& value) {
        RayPacket16 packet;
        for (size_t i = 0; i < 16; ++i) {
            // Lanes past the last copy it and are not in the mask.
            const Miss& m = rays[std::min(i, rays.size() - 1)];
            packet.start(i, eyes.origin[m.eye]);
            packet.aim(i, {lights.tx[m.light], lights.ty[m.light], lights.tz[m.light]});
        }
        const Coherence flag = flag_from(caster_, packet);
        aim16(packet, lights);
        const uint32_t mask = (1u << rays.size()) - 1;
        uint32_t visible = mask & ~uint32_t(caster_.occluded16(uint16_t(mask), packet, flag));
        for (; visible; visible &= visible - 1) {
            const Miss& m = rays[size_t(std::countr_zero(visible))];
            value.set(m.row, m.column);
        }
    }

    const RayCaster& caster_;
    const Control* control_ = nullptr;
    std::vector<Miss> misses_, sorted_;
    std::vector<uint32_t> begin_;
};

}  // namespace viscache
