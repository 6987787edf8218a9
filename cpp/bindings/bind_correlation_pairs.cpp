// Statistics of pairs of bit rows.

#include "arrays.h"
#include "interrupt.h"
#include "isa_argument.h"
#include "real_numbers.h"
#include "viscache/correlation/neighbourhood.h"

namespace viscache::bindings {

namespace {

using IntArray = py::array_t<int32_t, py::array::c_style | py::array::forcecast>;

PairDomain domain_of(const std::string& name) {
    if (name == "sphere") return PairDomain::kSphere;
    if (name == "joint") return PairDomain::kJoint;
    if (name == "union") return PairDomain::kUnion;
    throw py::value_error("domain must be sphere, joint or union, got " + name);
}

void require_bits(const WordArray& bits, const char* name) {
    if (bits.ndim() != 2)
        throw py::value_error(std::string(name) + " must have shape (N, words), got " + shape_text(bits));
}

/// The checked arguments of a call. It keeps the arrays that the rows refer to.
struct RowsArgument {
    RowsArgument(WordArray bits_, int n_directions, FloatArray position_, FloatArray normal_, IntArray group_,
                 size_t n_groups, const std::string& domain, FloatArray direction_, int min_bits,
                 bool one_if_both)
        : bits(std::move(bits_)),
          position(std::move(position_)),
          normal(std::move(normal_)),
          direction(std::move(direction_)),
          group(std::move(group_)) {
        require_bits(bits, "bits");
        // The core takes pointers and one count, so all arrays must have as many rows as the bits.
        const auto n = bits.shape(0);
        for (const auto& [name, size] : {std::pair{"positions", position.shape(0)},
                                         {"normals", normal.shape(0)},
                                         {"group", group.shape(0)}})
            if (size != n)
                throw py::value_error(std::string(name) + " must have one row per row of bits, " +
                                      std::to_string(n) + ", got " + std::to_string(size));
        // Taken from the members, which live as long as the rows.
        rows.bits = bits.data();
        rows.words = size_t(bits.shape(1));
        rows.n_directions = n_directions;
        rows.position = {rows3(position, "positions"), size_t(n)};
        rows.normal = {rows3(normal, "normals"), size_t(n)};
        rows.direction = {rows3(direction, "directions"), size_t(direction.shape(0))};
        rows.group = {group.data(), size_t(n)};
        rows.n_groups = n_groups;
        rows.domain = domain_of(domain);
        rows.min_bits = min_bits;
        rows.one_if_both = one_if_both;
    }
    WordArray bits;
    FloatArray position, normal, direction;
    IntArray group;
    PairRows rows;
};

/// An array that owns the values of a table.
/// A table of fine bins has a hundred megabytes: the array takes the vector over instead of copying it. The
/// capsule deletes it with the last array.
py::array_t<int64_t> array_that_owns(std::vector<int64_t>& v, const PairTable& t) {
    auto* kept = new std::vector<int64_t>(std::move(v));
    const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<int64_t>*>(p); });
    return py::array_t<int64_t>({t.n_pairs, t.n_distances, t.n_angles}, kept->data(), owner);
}

/// Σq² may exceed 64 bits: it is high·2³² + low, which Python adds up.
py::dict dict_of(PairTable t) {
    using namespace py::literals;
    return py::dict("n"_a = array_that_owns(t.n, t), "n_undefined"_a = array_that_owns(t.n_undefined, t),
                    "sum_q"_a = array_that_owns(t.sum_q, t),
                    "sum_q2_high"_a = array_that_owns(t.sum_q2_high, t),
                    "sum_q2_low"_a = array_that_owns(t.sum_q2_low, t));
}

PairWork work_of(int threads, const std::optional<std::string>& isa, bool skip_dead = true) {
    return {.threads = threads, .isa = isa_of(isa), .skip_dead = skip_dead};
}

py::dict pair_statistics_dict(const RowsArgument& a, const std::vector<double>& d_edges,
                              const std::vector<double>& theta_edges_deg,
                              const std::optional<std::vector<uint64_t>>& chosen, size_t tile, int threads,
                              const std::optional<std::string>& isa, bool skip_dead,
                              const py::object& progress) {
    const PairWork work = work_of(threads, isa, skip_dead);
    const PairTiles tiles(a.rows.group, a.rows.n_groups, tile);
    // Without a choice, all tiles
    std::vector<uint64_t> all;
    if (!chosen)
        for (size_t t = 0; t < tiles.tiles.size(); ++t) all.push_back(t);
    return dict_of(run_interruptible(
        [&](Control& control) {
            return pair_statistics(a.rows, tiles, chosen ? *chosen : all, BinEdges::distances(d_edges),
                                   BinEdges::angles(theta_edges_deg), work, control);
        },
        progress));
}

py::dict near_pairs_dict(const RowsArgument& a, const std::vector<double>& d_edges,
                         const std::vector<double>& theta_edges_deg, int threads,
                         const std::optional<std::string>& isa, const py::object& progress) {
    const PairWork work = work_of(threads, isa);
    return dict_of(run_interruptible(
        [&](Control& control) {
            return near_pairs(a.rows, BinEdges::distances(d_edges), BinEdges::angles(theta_edges_deg),
                              d_edges.back(), work, control);
        },
        progress));
}

py::array_t<float> spatial_map_array(const RowsArgument& a, double d_max, double theta_max_deg, int threads,
                                     const std::optional<std::string>& isa, const py::object& progress) {
    const PairWork work = work_of(threads, isa);
    std::vector<float> mean = run_interruptible(
        [&](Control& control) { return spatial_map(a.rows, d_max, theta_max_deg, work, control); }, progress);
    return py::array_t<float>(py::ssize_t(mean.size()), mean.data());
}

/// Throws unless the rows of both arrays have equally many words and the kernel takes that many.
void require_alike(const WordArray& a, const WordArray& b) {
    require_bits(a, "bits_a");
    require_bits(b, "bits_b");
    if (a.shape(1) != b.shape(1))
        throw py::value_error("bits_a and bits_b must have rows of the same length, got " + shape_text(a) +
                              " and " + shape_text(b));
    // Products of two counts stay below 2³¹ in the kernels
    if (size_t(a.shape(1)) > words_for(kMaxDirections))
        throw py::value_error("bits must have at most " + std::to_string(words_for(kMaxDirections)) +
                              " words a row, got " + std::to_string(a.shape(1)));
}

py::array_t<int32_t> intersections_array(const WordArray& a, const WordArray& b, int threads,
                                         const std::optional<std::string>& isa) {
    require_alike(a, b);
    const PairWork work = work_of(threads, isa);
    py::array_t<int32_t> out({a.shape(0), b.shape(0)});
    // Pointers are taken with the lock; the call below has none.
    const Word *rows_a = a.data(), *rows_b = b.data();
    int32_t* counts = out.mutable_data();
    const size_t n_a = size_t(a.shape(0)), n_b = size_t(b.shape(0)), words = size_t(a.shape(1));
    run_interruptible(
        [&](Control& control) { intersections(rows_a, n_a, rows_b, n_b, words, work, counts, control); });
    return out;
}

uint64_t total_intersections_of(const WordArray& a, const WordArray& b, int threads,
                                const std::optional<std::string>& isa, bool skip_dead) {
    require_alike(a, b);
    const PairWork work = work_of(threads, isa, skip_dead);
    const Word *rows_a = a.data(), *rows_b = b.data();
    const size_t n_a = size_t(a.shape(0)), n_b = size_t(b.shape(0)), words = size_t(a.shape(1));
    return run_interruptible([&](Control& control) {
        return total_intersections(rows_a, n_a, rows_b, n_b, words, work, control);
    });
}

py::array_t<int64_t> tiles_array(const IntArray& group, size_t n_groups, size_t tile) {
    const PairTiles all({group.data(), size_t(group.size())}, n_groups, tile);
    py::array_t<int64_t> out({py::ssize_t(all.tiles.size()), py::ssize_t(7)});
    int64_t* row = out.mutable_data();
    for (const PairTile& t : all.tiles) {
        // Groups and ranges of points, as the documentation of `tiles` lists them
        const PointBlock &a = all.blocks[t.a], &b = all.blocks[t.b];
        for (size_t v : {a.group, b.group, a.first, a.last, b.first, b.last}) *row++ = int64_t(v);
        *row++ = t.pairs;
    }
    return out;
}

}  // namespace

void bind_correlation_pairs(py::module_& m) {
    py::module_ c = m.def_submodule("correlation", "Correlation statistics of visibility.");
    const auto no_isa = py::arg("isa") = py::none();

    py::class_<RowsArgument>(c, "PairRows", "Points, their bit rows, and the rules of the statistics.")
        .def(py::init<WordArray, int, FloatArray, FloatArray, IntArray, size_t, const std::string&,
                      FloatArray, int, bool>(),
             py::arg("bits"), py::arg("n_directions"), py::arg("positions"), py::arg("normals"),
             py::arg("group"), py::arg("n_groups"), py::arg("domain"), py::arg("directions"),
             py::arg("min_bits"), py::arg("one_if_both"));
    c.def("pair_statistics", &pair_statistics_dict, py::arg("rows"), py::arg("d_edges"),
          py::arg("theta_edges_deg"), py::arg("tiles"), py::arg("tile"), py::arg("threads") = 0, no_isa,
          py::arg("skip_dead") = true, py::arg("progress") = py::none(),
          "Sums over the pairs of tiles; see viscache.correlation.pair_statistics.");
    c.def("near_pairs", &near_pairs_dict, py::arg("rows"), py::arg("d_edges"), py::arg("theta_edges_deg"),
          py::arg("threads") = 0, no_isa, py::arg("progress") = py::none(),
          "Sums over all pairs that are closer than the last edge of distance.");
    c.def("spatial_map", &spatial_map_array, py::arg("rows"), py::arg("d_max"), py::arg("theta_max_deg"),
          py::arg("threads") = 0, no_isa, py::arg("progress") = py::none(),
          "Mean ρ between every point and its neighbours.");
    c.def("tiles", &tiles_array, py::arg("group"), py::arg("n_groups"), py::arg("tile"),
          "One row (K, 7) per tile: groups a and b, first and last point of a and of b, number of pairs.");
    c.def("intersections", &intersections_array, py::arg("bits_a"), py::arg("bits_b"), py::arg("threads") = 0,
          no_isa, "Number of directions that are visible in both rows, (NA, NB).");
    c.def("total_intersections", &total_intersections_of, py::arg("bits_a"), py::arg("bits_b"),
          py::arg("threads") = 0, no_isa, py::arg("skip_dead") = true,
          "Sum of the intersections over all pairs of rows.");
    c.def("and_popcount_add", &and_popcount_add, py::arg("steps"), py::call_guard<WithoutGil>(),
          "Baseline of the bench: and, popcount and add of 512 bits, repeated `steps` times.");
}

}  // namespace viscache::bindings
