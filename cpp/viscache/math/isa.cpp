#include "viscache/math/isa.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace viscache {

Isa best_isa() {
#if VISCACHE_X86
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512vpopcntdq"))
        return Isa::kAvx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
        return Isa::kAvx2;
#endif
    return Isa::kPortable;
}

namespace {
Isa choose_isa() {
    const char* wish = std::getenv("VISCACHE_ISA");
    const Isa best = best_isa();
    if (!wish || !*wish) return best;
    // Tests select lower variants; a higher one would end in an illegal instruction.
    for (Isa isa : {Isa::kPortable, Isa::kAvx2, Isa::kAvx512})
        if (isa_name(isa) == wish) {
            if (isa > best)
                throw std::invalid_argument("VISCACHE_ISA must be supported by this CPU (best: " +
                                            std::string(isa_name(best)) + "), got " + wish);
            return isa;
        }
    throw std::invalid_argument(std::string("VISCACHE_ISA must be portable, avx2 or avx512, got ") + wish);
}
}  // namespace

Isa active_isa() {
    // Read once: kernels of one process always agree.
    static const Isa isa = choose_isa();
    return isa;
}

std::string_view isa_name(Isa isa) {
    switch (isa) {
        case Isa::kPortable: return "portable";
        case Isa::kAvx2: return "avx2";
        case Isa::kAvx512: return "avx512";
    }
    return "unknown";
}

}  // namespace viscache
