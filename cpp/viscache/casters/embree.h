#pragma once
// Embree 3.12+ and 4.x under one set of names. Included only by embree_packets.h, which is part of
// embree_caster.cpp, and by watertight_caster.cpp.
#include <new>
#include <stdexcept>
#include <string>

#if VISCACHE_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include "viscache/visibility/ray_caster.h"

namespace viscache::rtc {

/// The only Embree device of the process.
inline RTCDevice shared_device() {
    static const RTCDevice device = [] {
        RTCDevice d = rtcNewDevice(nullptr);
        if (!d)
            throw std::runtime_error("Embree could not be started: error " +
                                     std::to_string(rtcGetDeviceError(nullptr)));
        return d;
    }();
    return device;
}

/// Throws if Embree could not build a scene.
inline void require_built() {
    const RTCError error = rtcGetDeviceError(shared_device());
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_NONE)
        throw std::runtime_error("Embree could not build the scene: error " + std::to_string(error));
}

/// Context of a call, and data for the callbacks of user geometry.
template <class Base>
struct ContextWith {
    Base base;
    void* data = nullptr;
};

/// Traversal of one call: context and flags for both versions of Embree.
class Query {
public:
#if RTC_VERSION_MAJOR >= 4
    explicit Query(Coherence coherence, void* data = nullptr) {
        rtcInitRayQueryContext(&context_.base);
        context_.data = data;
        rtcInitOccludedArguments(&occluded_);
        rtcInitIntersectArguments(&intersect_);
        occluded_.context = intersect_.context = &context_.base;
        occluded_.flags = intersect_.flags =
            coherence == Coherence::kCoherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    }
    void occluded1(RTCScene s, RTCRay& r) { rtcOccluded1(s, &r, &occluded_); }
    void occluded4(const int* v, RTCScene s, RTCRay4& r) { rtcOccluded4(v, s, &r, &occluded_); }
    void occluded8(const int* v, RTCScene s, RTCRay8& r) { rtcOccluded8(v, s, &r, &occluded_); }
    void occluded16(const int* v, RTCScene s, RTCRay16& r) { rtcOccluded16(v, s, &r, &occluded_); }
    void intersect8(const int* v, RTCScene s, RTCRayHit8& r) { rtcIntersect8(v, s, &r, &intersect_); }
    void intersect16(const int* v, RTCScene s, RTCRayHit16& r) { rtcIntersect16(v, s, &r, &intersect_); }
    void intersect1(RTCScene s, RTCRayHit& r) { rtcIntersect1(s, &r, &intersect_); }

    /// The data of the call that a callback serves.
    static void* data_of(RTCRayQueryContext* context) { return reinterpret_cast<Context*>(context)->data; }

private:
    using Context = ContextWith<RTCRayQueryContext>;
    Context context_;
    RTCOccludedArguments occluded_;
    RTCIntersectArguments intersect_;
#else
    explicit Query(Coherence coherence, void* data = nullptr) {
        rtcInitIntersectContext(&context_.base);
        context_.data = data;
        context_.base.flags = coherence == Coherence::kCoherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                                : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
    void occluded1(RTCScene s, RTCRay& r) { rtcOccluded1(s, &context_.base, &r); }
    void occluded4(const int* v, RTCScene s, RTCRay4& r) { rtcOccluded4(v, s, &context_.base, &r); }
    void occluded8(const int* v, RTCScene s, RTCRay8& r) { rtcOccluded8(v, s, &context_.base, &r); }
    void occluded16(const int* v, RTCScene s, RTCRay16& r) { rtcOccluded16(v, s, &context_.base, &r); }
    void intersect8(const int* v, RTCScene s, RTCRayHit8& r) { rtcIntersect8(v, s, &context_.base, &r); }
    void intersect16(const int* v, RTCScene s, RTCRayHit16& r) { rtcIntersect16(v, s, &context_.base, &r); }
    void intersect1(RTCScene s, RTCRayHit& r) { rtcIntersect1(s, &context_.base, &r); }

    /// The data of the call that a callback serves.
    static void* data_of(RTCIntersectContext* context) { return reinterpret_cast<Context*>(context)->data; }

private:
    using Context = ContextWith<RTCIntersectContext>;
    Context context_;
#endif
};

}  // namespace viscache::rtc
