#pragma once
// One copy of a kernel per instruction set, from one body.
#include <array>
#include <cstddef>

#include "viscache/math/isa.h"

namespace viscache {

template <auto kBody>
struct IsaVariants;

// The attributes belong to the copies; the body is inlined into each and compiled for its instruction set.
template <class Result, class... Args, Result (*kBody)(Args...)>
struct IsaVariants<kBody> {
    static Result portable(Args... args) { return kBody(args...); }
#if VISCACHE_X86
    VISCACHE_TARGET_AVX2 static Result avx2(Args... args) { return kBody(args...); }
    VISCACHE_TARGET_AVX512 static Result avx512(Args... args) { return kBody(args...); }
#endif
};

/// The copy of `kBody` for an instruction set. The body is an always_inline function of the file's own
/// namespace: each copy compiles it anew.
template <auto kBody>
constexpr auto variant_of([[maybe_unused]] Isa isa) {
    using Variants = IsaVariants<kBody>;
#if VISCACHE_X86
    if (isa == Isa::kAvx512) return Variants::avx512;
    if (isa == Isa::kAvx2) return Variants::avx2;
#endif
    return Variants::portable;
}

/// The function of this name in the namespace of an instruction set, for kernels that are written in one file
/// which each namespace includes.
#if VISCACHE_X86
#define VISCACHE_REGION(isa, name) \
    ((isa) == Isa::kAvx512 ? avx512::name : (isa) == Isa::kAvx2 ? avx2::name : portable::name)
#else
#define VISCACHE_REGION(isa, name) ((void)(isa), portable::name)
#endif

/// What `kMake(isa)` gives: tables of such copies.
template <auto kMake>
const auto& table_of(Isa isa) {
    // Where a CPU lacks the sets, all three are the portable copy.
    static constexpr std::array tables{kMake(Isa::kPortable), kMake(Isa::kAvx2), kMake(Isa::kAvx512)};
    return tables[size_t(isa)];
}

}  // namespace viscache
