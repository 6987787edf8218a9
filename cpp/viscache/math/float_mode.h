#pragma once
// The floating-point mode of a thread. Other programs of a process may flush denormals to zero, round in
// another direction or trap; results must not depend on that.
#include "viscache/math/isa.h"

#if VISCACHE_X86
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace viscache {

/// While it lives, its thread rounds to nearest, keeps denormals and traps nothing. Threads that are started
/// meanwhile inherit this.
class DefaultFloats {
public:
    DefaultFloats(const DefaultFloats&) = delete;
    DefaultFloats& operator=(const DefaultFloats&) = delete;

#if VISCACHE_X86
    DefaultFloats() : before_(_mm_getcsr()) { _mm_setcsr(kDefault); }
    ~DefaultFloats() { _mm_setcsr(before_); }

private:
    // MXCSR as the processor starts: all exceptions masked, rounding to nearest, no flushing of denormals.
    static constexpr unsigned kDefault = 0x1f80;
    unsigned before_;
#else
    DefaultFloats() {
        std::fegetenv(&before_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~DefaultFloats() { std::fesetenv(&before_); }

private:
    std::fenv_t before_;
#endif
};

}  // namespace viscache
