// Caches as modules: the oracles of a source answer queries between arrays of eye points and far ends.

#include "arrays.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "oracle_arrays.h"
#include "real_numbers.h"
#include "viscache/visibility/ask.h"

namespace viscache::bindings {

namespace {

/// The tiles of a frame if they are given, else tiles along a Morton curve.
EyeTiles tiles_of(const py::object& eyes, float extent, size_t most) {
    if (!py::isinstance<py::list>(eyes))
        return EyeTiles::along_curve(eye_block_from(eyes.cast<py::dict>(), extent), most);
    EyeTiles tiles;
    for (const py::handle tile : eyes) {
        tiles.eyes.push_back(eye_block_from(tile.cast<py::dict>(), extent));
        auto& row = tiles.row.emplace_back(tiles.eyes.back().size());
        // Rows of the answer follow the list: tile by tile, point by point.
        for (uint32_t& number : row) number = uint32_t(tiles.size++);
    }
    return tiles;
}

/// Counters and report of queries in the form that frames give them, so that Python reads both in one way.
py::dict answer_dict(const Counters& counters, const SourceReport& report) {
    FrameResult account;
    account.width = account.height = account.spp = 1;
    account.counters = counters;
    account.source = report;
    return account_dict(account);
}

py::array_t<AskedQuery> log_array(const std::vector<AskedQuery>& log) {
    return py::array_t<AskedQuery>(py::ssize_t(log.size()), log.data());
}

py::dict block(OracleSource& source, const py::object& eyes, const py::dict& ends,
               const std::optional<WordArray>& wanted, const std::optional<FloatArray>& contributions,
               std::pair<size_t, size_t> log, float extent, size_t most, int threads) {
    const EyeTiles tiles = tiles_of(eyes, extent, most);
    const FarEnds lights = far_ends_from(ends, extent);
    const size_t words = words_for(lights.count);
    // Sizes are checked here, where the message can name the array; the core takes pointers.
    if (wanted &&
        (wanted->ndim() != 2 || size_t(wanted->shape(0)) != tiles.size || size_t(wanted->shape(1)) != words))
        throw py::value_error("wanted must have shape (" + std::to_string(tiles.size) + ", " +
                              std::to_string(words) + "), got " + shape_text(*wanted));
    if (contributions && (contributions->ndim() != 2 || size_t(contributions->shape(0)) != tiles.size ||
                          size_t(contributions->shape(1)) != lights.count))
        throw py::value_error("contributions must have shape (" + std::to_string(tiles.size) + ", " +
                              std::to_string(lights.count) + "), got " + shape_text(*contributions));
    const BlockQuestion question{.lights = &lights,
                                 .wanted = wanted ? wanted->data() : nullptr,
                                 .contributions = contributions ? contributions->data() : nullptr,
                                 .log_begin = log.first,
                                 .log_end = log.second};
    // From here on, nothing touches Python objects: the lock is free while the rays are traced.
    BlockAnswer answer = run_interruptible(
        [&](Control& control) { return ask_block(source, tiles, question, threads, control); });
    py::dict out = answer_dict(answer.counters, answer.report);
    py::array_t<uint64_t> bits({py::ssize_t(tiles.size), py::ssize_t(words)});
    std::memcpy(bits.mutable_data(), answer.bits.data(), answer.bits.size() * sizeof(Word));
    out["bits"] = bits;
    if (!answer.weights.empty()) {
        py::array_t<float> weights({py::ssize_t(tiles.size), py::ssize_t(lights.count)});
        std::memcpy(weights.mutable_data(), answer.weights.data(), answer.weights.size() * sizeof(float));
        out["weights"] = weights;
    }
    if (log.second > log.first) out["log"] = log_array(answer.log);
    return out;
}

py::dict pairs(OracleSource& source, const py::object& eyes, const UintArray& index, const py::dict& ends,
               float extent, size_t most, int threads) {
    const EyeTiles tiles = tiles_of(eyes, extent, most);
    const FarEnds lights = far_ends_from(ends, extent);
    if (index.ndim() != 1 || size_t(index.shape(0)) != lights.count)
        throw py::value_error("index must have shape (" + std::to_string(lights.count) + ",), got " +
                              shape_text(index));
    // An index beyond the eye points would be read by the core as it is.
    for (py::ssize_t k = 0; k < index.shape(0); ++k)
        if (index.at(k) >= tiles.size)
            throw py::value_error("index must be in [0, " + std::to_string(tiles.size) + "), row " +
                                  std::to_string(k) + " is " + std::to_string(index.at(k)));
    const PairQuestion question{queries_from(lights, {index.data(), lights.count})};
    PairAnswer answer = run_interruptible(
        [&](Control& control) { return ask_pairs(source, tiles, question, threads, control); });
    py::dict out = answer_dict(answer.counters, answer.report);
    py::array_t<bool> visible(py::ssize_t(lights.count));
    std::copy(answer.visible.begin(), answer.visible.end(), visible.mutable_data());
    out["visible"] = visible;
    if (!answer.weights.empty())
        out["weights"] = py::array_t<float>(py::ssize_t(answer.weights.size()), answer.weights.data());
    return out;
}

}  // namespace

void bind_ask(py::module_& m) {
    PYBIND11_NUMPY_DTYPE(AskedQuery, row, column, cluster, representative, level, traced);
    m.def("ask_block", &block, py::arg("source"), py::arg("eyes"), py::arg("ends"), py::kw_only(),
          py::arg("wanted") = py::none(), py::arg("contributions") = py::none(),
          py::arg("log") = std::pair<size_t, size_t>(0, 0), py::arg("extent"), py::arg("most"),
          py::arg("threads"),
          "All eye points × all far ends: bits, weights, counters, timings and log. `eyes` is one dict of "
          "arrays, cut into tiles of `most` points, or a list of the tiles of a frame.");
    m.def("ask_pairs", &pairs, py::arg("source"), py::arg("eyes"), py::arg("index"), py::arg("ends"),
          py::kw_only(), py::arg("extent"), py::arg("most"), py::arg("threads"),
          "Connection k joins eye point index[k] with far end k.");
}

}  // namespace viscache::bindings
