#pragma once
// The intrinsics of x86, without g++ 12's false alarms: it takes the undefined operands in its own header for
// mistakes.
#include "viscache/math/isa.h"

#if VISCACHE_X86
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif
