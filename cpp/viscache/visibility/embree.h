#pragma once
// Embree 3.12+ and 4.x under one set of names. Included only by embree_packets.h, which is part of
// embree_caster.cpp.
#if VISCACHE_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include "viscache/visibility/ray_caster.h"

namespace viscache::rtc {

/// Traversal of one call: context and flags for both versions of Embree.
class Query {
public:
#if RTC_VERSION_MAJOR >= 4
    explicit Query(Coherence coherence) {
        rtcInitRayQueryContext(&context_);
        rtcInitOccludedArguments(&occluded_);
        rtcInitIntersectArguments(&intersect_);
        occluded_.context = intersect_.context = &context_;
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

private:
    RTCRayQueryContext context_;
    RTCOccludedArguments occluded_;
    RTCIntersectArguments intersect_;
#else
    explicit Query(Coherence coherence) {
        rtcInitIntersectContext(&context_);
        context_.flags = coherence == Coherence::kCoherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                           : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
    void occluded1(RTCScene s, RTCRay& r) { rtcOccluded1(s, &context_, &r); }
    void occluded4(const int* v, RTCScene s, RTCRay4& r) { rtcOccluded4(v, s, &context_, &r); }
    void occluded8(const int* v, RTCScene s, RTCRay8& r) { rtcOccluded8(v, s, &context_, &r); }
    void occluded16(const int* v, RTCScene s, RTCRay16& r) { rtcOccluded16(v, s, &context_, &r); }
    void intersect8(const int* v, RTCScene s, RTCRayHit8& r) { rtcIntersect8(v, s, &context_, &r); }
    void intersect16(const int* v, RTCScene s, RTCRayHit16& r) { rtcIntersect16(v, s, &context_, &r); }
    void intersect1(RTCScene s, RTCRayHit& r) { rtcIntersect1(s, &context_, &r); }

private:
    RTCIntersectContext context_;
#endif
};

}  // namespace viscache::rtc
