#pragma once
// x86 intrinsics without g++ 12's false warnings about the undefined operands in its own headers.
#include "viscache/math/isa.h"

#if VISCACHE_X86
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif
