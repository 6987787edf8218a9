#pragma once
// Oracles written in Python. There is one call per tile and light group, so the overhead is small.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "viscache/oracles/exact.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache::bindings {

/// Traces exact rays for an oracle written in Python, on one thread.
class PythonTracer {
public:
    PythonTracer(const RayCaster& caster, float extent) : exact_(caster), extent_(extent) {}
    void watch(const Control& control) { exact_.watch(control); }
    /// Bits (N, words) of eye points × far ends; `wanted` is None or (N, M) bool.
    pybind11::array_t<uint64_t> block(const pybind11::dict& eyes, const pybind11::dict& ends,
                                      const pybind11::object& wanted);
    /// (K,) bool of connections eyes[index[k]] → far end k.
    pybind11::array_t<bool> pairs(
        const pybind11::dict& eyes,
        const pybind11::array_t<uint32_t, pybind11::array::c_style | pybind11::array::forcecast>& index,
        const pybind11::dict& ends);
    /// The number of rays since the last call.
    uint64_t take_rays() { return std::exchange(rays_, 0); }

private:
    ExactOracle exact_;
    float extent_;
    uint64_t rays_ = 0;
};

/// Passes the queries of a tile to `viscache.oracles.written.WrittenOracle`.
class PythonOracle final : public VisibilityOracle {
public:
    PythonOracle(pybind11::object written, std::shared_ptr<PythonTracer> tracer)
        : written_(std::move(written)), tracer_(std::move(tracer)) {}
    ~PythonOracle() override;
    void watch(const Control& control) override;
    void begin_tile(const EyeBlock& eyes) override;
    PairOrder order(const EyeBlock& eyes, std::optional<int> group) override;
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

private:
    /// Calls `ask` with the interpreter's lock. An exception ends the frame and keeps its traceback.
    template <class Ask>
    void call(Ask ask);

    pybind11::object written_;
    std::shared_ptr<PythonTracer> tracer_;
    std::vector<float> weights_;
    std::vector<uint32_t> run_end_;
};

class PythonSource final : public OracleSource {
public:
    /// `written`: a `viscache.oracles.written.WrittenSource`.
    PythonSource(pybind11::object written, const RayCaster& caster, float extent)
        : written_(std::move(written)), caster_(caster), extent_(extent) {}
    ~PythonSource() override;
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override;

private:
    pybind11::object written_;
    const RayCaster& caster_;
    float extent_;
};

}  // namespace viscache::bindings
