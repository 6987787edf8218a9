#pragma once
// Numbers from Python that must be real. NumPy would drop the imaginary part of complex ones, with a warning
// alone. Bindings include this instead of pybind11/stl.h, so that every conversion is the same one.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <string>

namespace viscache::bindings {

/// A NumPy array parameter of real numbers, converted if it has another type or layout.
template <class T, int flags>
class RealArray : public pybind11::array_t<T, flags> {
public:
    using Base = pybind11::array_t<T, flags>;
    using Base::Base;
    RealArray(Base a) : Base(std::move(a)) {}
};

/// Whether a number, or the elements of an array, are complex.
inline bool is_complex(pybind11::handle value) {
    if (PyComplex_Check(value.ptr())) return true;
    const pybind11::object type = pybind11::getattr(value, "dtype", pybind11::none());
    return pybind11::isinstance<pybind11::dtype>(type) &&
           pybind11::reinterpret_borrow<pybind11::dtype>(type).kind() == 'c';
}

[[noreturn]] inline void refuse_complex(const std::string& given) {
    throw pybind11::value_error("arguments must be real numbers, got " + given);
}

/// Throws if an array, or what NumPy makes an array of, is complex.
inline void require_real(pybind11::handle value) {
    // Lists and other sequences become arrays first: their numbers may be complex, too.
    const auto array = pybind11::array::ensure(value);
    if (!array) return;  // the conversion refuses it
    if (is_complex(array)) refuse_complex("an array of " + std::string(pybind11::str(array.dtype())));
    // Arrays of Python objects are looked through, number by number.
    if (array.dtype().kind() == 'O')
        for (const pybind11::handle element : array.attr("flat"))
            if (is_complex(element)) refuse_complex(pybind11::repr(element));
}

}  // namespace viscache::bindings

namespace pybind11::detail {

template <class T, int flags>
struct pyobject_caster<viscache::bindings::RealArray<T, flags>> {
    using type = viscache::bindings::RealArray<T, flags>;

    bool load(handle source, bool convert) {
        // As pybind11 does for its arrays: without conversion, only the type itself.
        if (!convert && !type::check_(source)) return false;
        viscache::bindings::require_real(source);
        value = type::ensure(source);
        return bool(value);
    }
    static handle cast(const handle& source, return_value_policy, handle) { return source.inc_ref(); }
    PYBIND11_TYPE_CASTER(type, handle_type_name<typename type::Base>::name);
};

/// A fixed count of numbers, such as a colour.
template <class T, size_t count>
struct real_sequence_caster : array_caster<std::array<T, count>, T, false, count> {
    using Base = array_caster<std::array<T, count>, T, false, count>;

    bool load(handle source, bool convert) {
        // Before the conversion, which would drop imaginary parts.
        if (isinstance<sequence>(source) || isinstance<array>(source))
            for (const handle element : source)
                if (viscache::bindings::is_complex(element))
                    viscache::bindings::refuse_complex(repr(element));
        return Base::load(source, convert);
    }
};

template <size_t count>
struct type_caster<std::array<float, count>> : real_sequence_caster<float, count> {};
template <size_t count>
struct type_caster<std::array<double, count>> : real_sequence_caster<double, count> {};

}  // namespace pybind11::detail
