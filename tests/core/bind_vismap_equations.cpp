// The numbered equations of the visibility-map cache: control variates.
#include "arrays.h"
#include "viscache/vismap/control_variate.h"

namespace viscache::bindings {

void bind_vismap_equations(py::module_& t) {
    t.def("control_variate_estimate", py::vectorize(control_variate_estimate), py::arg("sum_f"),
          py::arg("sum_g"), py::arg("j"), py::arg("alpha"), py::arg("n"), "Eq. 2 for one channel.");
    t.def(
        "product_terms",
        [](double ratio, double visible, double approximate, double d) {
            const ProductTerms t = product_terms(ratio, visible, approximate, d);
            return std::pair(t.z, t.w);
        },
        py::arg("b_over_b_tilde"), py::arg("visible"), py::arg("approximate"), py::arg("d") = 1.0,
        "Eq. 3: Z and W.");
    t.def("residual_variance", py::vectorize(residual_variance), py::arg("var_z"), py::arg("var_w"),
          py::arg("covariance"), py::arg("alpha"), "Eq. 4: variance of Z − αW.");
    t.def("best_alpha", &best_alpha, py::arg("var_w"), py::arg("covariance"));
    t.def("least_residual_variance", &least_residual_variance, py::arg("var_z"), py::arg("rho"),
          "Eq. 5: variance at the best α.");
    t.def("correlation", &correlation, py::arg("var_z"), py::arg("var_w"), py::arg("covariance"),
          "Eq. 6: ρ.");
    t.def(
        "regressed_alpha",
        [](const DoubleArray& z, const DoubleArray& w, double var_w) {
            if (z.ndim() != 1 || w.ndim() != 1 || z.shape(0) != w.shape(0))
                throw py::value_error("z and w must have one shape (N,)");
            AlphaSums sums;
            for (py::ssize_t i = 0; i < z.shape(0); ++i) sums.add(z.at(i), w.at(i));
            return regressed_alpha(sums, var_w);
        },
        py::arg("z"), py::arg("w"), py::arg("var_w"),
        "α from samples (N,) of Z and W, both minus the mean of W.");
}

}  // namespace viscache::bindings
