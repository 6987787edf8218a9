#pragma once
// The argument that selects the variant of a kernel by name.
#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "viscache/math/isa.h"

namespace viscache::bindings {

/// The variant with this name; without a name, the active one.
inline Isa isa_of(const std::optional<std::string>& name) {
    if (!name) return active_isa();
    for (Isa isa : {Isa::kPortable, Isa::kAvx2, Isa::kAvx512})
        if (isa_name(isa) == *name && isa <= best_isa()) return isa;
    throw pybind11::value_error("isa must be portable, avx2 or avx512, and this CPU must have it, got " +
                                *name);
}

}  // namespace viscache::bindings
