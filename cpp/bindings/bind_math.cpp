// Which variant of the kernels runs, and which could.
#include <pybind11/pybind11.h>

#include "viscache/math/isa.h"

namespace py = pybind11;

namespace viscache::bindings {

void bind_math(py::module_& m) {
    m.def(
        "active_isa", [] { return std::string(isa_name(active_isa())); },
        "Variant of the SIMD kernels in use: portable, avx2 or avx512.");
    m.def(
        "best_isa", [] { return std::string(isa_name(best_isa())); }, "Best variant that this CPU supports.");
}

}  // namespace viscache::bindings
