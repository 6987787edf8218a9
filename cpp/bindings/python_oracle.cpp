#include "python_oracle.h"
#include "real_numbers.h"

#include <map>

#include "arrays.h"
#include "gil.h"
#include "oracle_arrays.h"
#include "rows.h"

namespace viscache::bindings {

namespace {

constexpr size_t kEyesPerRun = 4096;  // eye points whose samples are asked for in one call

using Index = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;

void pack_into(const py::object& wanted, BitMatrix& bits) {
    // None: all queries are wanted.
    if (wanted.is_none()) {
        for (size_t r = 0; r < bits.rows(); ++r)
            for (size_t k = 0; k < bits.columns(); ++k) bits.set(r, k);
        return;
    }
    const auto a = BoolArray::ensure(wanted);
    if (!a || a.ndim() != 2 || size_t(a.shape(0)) != bits.rows() || size_t(a.shape(1)) != bits.columns())
        throw py::value_error("wanted must have shape (" + std::to_string(bits.rows()) + ", " +
                              std::to_string(bits.columns()) + ")");
    const bool* from = a.data();
    for (size_t r = 0; r < bits.rows(); ++r)
        for (size_t k = 0; k < bits.columns(); ++k)
            // Shifted in instead of set one by one: no branch per query.
            bits.row(r)[k / kWordBits] |= Word(*from++) << (k % kWordBits);
}

/// The far ends of connections with the same semantic, group and t_max.
FarEnds ends_of(std::span<const ShadowQuery> queries, std::span<const uint32_t> numbers) {
    FarEnds e;
    const ShadowQuery& first = queries[numbers.front()];
    e.semantic = first.semantic;
    e.group = first.group;
    e.t_max = first.t_max;
    e.count = numbers.size();
    for (const uint32_t i : numbers) {
        const ShadowQuery& q = queries[i];
        // A direction has no point at which a ray could end.
        const bool direction = q.semantic == Semantic::kDirection || q.semantic == Semantic::kSolidAngle;
        const Vec3 end = direction ? q.far : q.ray_end;
        e.x.push_back(q.far.x);
        e.y.push_back(q.far.y);
        e.z.push_back(q.far.z);
        e.nx.push_back(q.far_normal.x);
        e.ny.push_back(q.far_normal.y);
        e.nz.push_back(q.far_normal.z);
        e.tx.push_back(end.x);
        e.ty.push_back(end.y);
        e.tz.push_back(end.z);
        e.density.push_back(q.density);
    }
    return e;
}

}  // namespace

py::array_t<uint64_t> PythonTracer::block(const py::dict& eyes, const py::dict& ends,
                                          const py::object& wanted) {
    const EyeBlock points = eye_block_from(eyes, extent_);
    const FarEnds lights = far_ends_from(ends, extent_);
    BitMatrix asked(points.size(), lights.count);
    pack_into(wanted, asked);
    Answer seen;
    // The arrays are read and checked; the rays are traced without the lock.
    {
        const WithoutGil release;
        Counters counters;
        seen = exact_.block({points, lights, asked}, counters);
        rays_ += counters.rays();
    }
    return packed(*seen.bits);
}

py::array_t<bool> PythonTracer::pairs(const py::dict& eyes, const Index& index, const py::dict& ends) {
    const EyeBlock points = eye_block_from(eyes, extent_);
    const FarEnds lights = far_ends_from(ends, extent_);
    if (index.ndim() != 1 || size_t(index.shape(0)) != lights.count)
        throw py::value_error("index must have shape (" + std::to_string(lights.count) + ",), got " +
                              shape_text(index));
    for (py::ssize_t k = 0; k < index.shape(0); ++k)
        if (index.at(k) >= points.size())
            throw py::value_error("index must be in [0, " + std::to_string(points.size()) + "), row " +
                                  std::to_string(k) + " is " + std::to_string(index.at(k)));
    const auto queries = queries_from(lights, {index.data(), lights.count});
    Answer seen;
    {
        const WithoutGil release;
        Counters counters;
        seen = exact_.pairs({points, queries}, counters);
        rays_ += counters.rays();
    }
    py::array_t<bool> out(py::ssize_t(queries.size()));
    for (size_t k = 0; k < queries.size(); ++k) out.mutable_at(py::ssize_t(k)) = seen.bits->get(0, k);
    return out;
}

PythonOracle::~PythonOracle() {
    // The last reference to a Python object must be given up with the lock.
    const WithGil lock;
    written_ = py::object();
    tracer_.reset();
}

void PythonOracle::watch(const Control& control) {
    VisibilityOracle::watch(control);
    tracer_->watch(control);
}

template <class Ask>
void PythonOracle::call(Ask ask) {
    // A cancelled frame need not wait for the lock.
    check_cancelled();
    with_python([&] {
        try {
            ask();
        } catch (const py::error_already_set&) {
            // A cancelled frame stops the tracer; this is not an error of the oracle
            check_cancelled();
            throw;
        }
    });
}

void PythonOracle::begin_tile(const EyeBlock& eyes) {
    call([&] { written_.attr("begin_tile")(eye_block_dict(eyes)); });
}

Answer PythonOracle::block(const BlockAsk& ask, Counters& counters) {
    const BitMatrix& wanted = ask.wanted;
    BitMatrix& visible = new_bits(wanted.rows(), wanted.columns());
    weights_.clear();
    call([&] {
        const py::tuple answer = written_.attr("block")(far_ends_dict(ask.lights), unpacked(wanted));
        // Its bits count where they were asked for, and its weights if it has any
        const auto bits = answer[0].cast<WordArray>();
        const size_t words = words_for(wanted.columns());
        if (bits.ndim() != 2 || size_t(bits.shape(0)) != wanted.rows() || size_t(bits.shape(1)) != words)
            throw std::logic_error("an answer must have a row of bits per eye point");
        for (size_t r = 0; r < wanted.rows(); ++r)
            for (size_t w = 0; w < words; ++w)
                // Answers to queries that are not wanted are dropped.
                visible.row(r)[w] = bits.data(py::ssize_t(r), 0)[w] & wanted.row(r)[w];
        if (!answer[1].is_none()) {
            const auto weights = answer[1].cast<FloatArray>();
            if (size_t(weights.size()) != wanted.rows() * wanted.columns())
                throw std::logic_error("an answer must have a weight per query");
            weights_.assign(weights.data(), weights.data() + weights.size());
        }
        // Rays that the oracle traced in this call
        counters.group(ask.lights.group).rays += tracer_->take_rays();
    });
    const uint64_t asked = count_bits(wanted);
    counters.group(ask.lights.group).queries += asked;
    counters.group(ask.lights.group).occluded += asked - count_bits(visible);
    return {.bits = &visible, .weights = weights_};
}

/// Its own order: only runs, which bound the size of a call.
PairOrder PythonOracle::order(const EyeBlock& eyes, std::optional<int>) {
    run_end_.clear();
    for (size_t end = kEyesPerRun; end < eyes.size(); end += kEyesPerRun) run_end_.push_back(uint32_t(end));
    run_end_.push_back(uint32_t(eyes.size()));
    return {{}, run_end_};
}

Answer PythonOracle::pairs(const PairsAsk& ask, Counters& counters) {
    std::vector<ShadowQuery> made;
    const std::span<const ShadowQuery> queries = ask.as_queries(made);
    BitMatrix& visible = new_bits(1, queries.size());
    weights_.clear();
    if (queries.empty()) return {.bits = &visible};
    // One call for all connections of one kind
    std::map<std::tuple<Semantic, uint8_t, float>, std::vector<uint32_t>> kinds;
    for (uint32_t i = 0; i < queries.size(); ++i)
        // `far_ends_dict` has one semantic, group and length for all ends.
        kinds[{queries[i].semantic, queries[i].group, queries[i].t_max}].push_back(i);
    call([&] {
        for (const auto& [kind, numbers] : kinds) {
            py::array_t<uint32_t> index(py::ssize_t(numbers.size()));
            for (size_t k = 0; k < numbers.size(); ++k)
                index.mutable_at(py::ssize_t(k)) = queries[numbers[k]].eye;
            const py::tuple answer = written_.attr("pairs")(index, far_ends_dict(ends_of(queries, numbers)));
            const auto seen = answer[0].cast<BoolArray>();
            if (seen.ndim() != 1 || size_t(seen.size()) != numbers.size())
                throw std::logic_error("an answer must have a bit per connection");
            const bool weighted = !answer[1].is_none();
            const auto weights = weighted ? answer[1].cast<FloatArray>() : FloatArray();
            // Kinds without weights count as they are.
            if (weighted && weights_.empty()) weights_.assign(queries.size(), 1.f);
            GroupCounters& group = counters.group(std::get<1>(kind));
            for (size_t k = 0; k < numbers.size(); ++k) {
                if (seen.at(py::ssize_t(k))) visible.set(0, numbers[k]);
                if (weighted) weights_[numbers[k]] = weights.at(py::ssize_t(k));
                group.occluded += !seen.at(py::ssize_t(k));
            }
            group.queries += numbers.size();
            group.rays += tracer_->take_rays();
        }
    });
    return {.bits = &visible, .weights = weights_};
}

PythonSource::~PythonSource() {
    const WithGil lock;
    written_ = py::object();
}

void PythonSource::prepare(FrameStart& frame, Control&) {
    // Called from the thread that renders, which does not hold the lock.
    with_python([&] {
        py::list lights;
        for (const FarEnds* ends : frame.lights()) lights.append(far_ends_dict(*ends));
        written_.attr("begin_frame")(lights);
    });
}

std::unique_ptr<VisibilityOracle> PythonSource::make() {
    return with_python([&] {
        // Each thread has an oracle and a tracer of its own.
        auto tracer = std::make_shared<PythonTracer>(caster_, extent_);
        return std::make_unique<PythonOracle>(written_.attr("oracle")(tracer), tracer);
    });
}

}  // namespace viscache::bindings
