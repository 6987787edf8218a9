#pragma once
// Selects the instruction set of the hand-dispatched kernels. All variants give the same bits.
#include <string_view>

namespace viscache {

enum class Isa { kPortable, kAvx2, kAvx512 };

/// Best variant that this CPU supports. AVX-512 needs F, BW, DQ, VL and VPOPCNTDQ; AVX2 also needs FMA and
/// BMI2.
Isa best_isa();
/// The variant in use: `best_isa`, or a lower one set by VISCACHE_ISA = portable | avx2 | avx512. The
/// variable is read once; an unknown or unsupported name throws std::invalid_argument.
Isa active_isa();
std::string_view isa_name(Isa isa);

}  // namespace viscache

// Attributes for the per-ISA copies of a kernel. Kernel bodies are always_inline templates, so that no
// instruction of a higher ISA can leak into shared inline functions.
#if defined(__x86_64__) && defined(__GNUC__)
#define VISCACHE_X86 1
#define VISCACHE_TARGET_AVX512                                                                              \
    __attribute__((                                                                                         \
        target("avx512f,avx512bw,avx512dq,avx512vl,avx512vpopcntdq,avx2,bmi,bmi2,fma,popcnt,prefer-vector-" \
               "width=512")))
#define VISCACHE_TARGET_AVX2 __attribute__((target("avx2,fma,bmi,bmi2,popcnt")))
#else
#define VISCACHE_X86 0
#endif
