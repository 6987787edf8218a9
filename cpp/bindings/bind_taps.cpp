// The queries of a frame as arrays, and frames from given answers.

#include "arrays.h"
#include "frame_dict.h"
#include "interrupt.h"
#include "oracle_arrays.h"
#include "real_numbers.h"
#include "viscache/render/frame.h"
#include "viscache/render/taps.h"
#include "viscache/visibility/ask.h"

namespace viscache::bindings {

namespace {

/// All queries of a frame.
class FrameTaps {
public:
    FrameTaps(const Scene& scene, const RayCaster& caster, const Camera& camera,
              const IntegratorSettings& integrator, const FrameSettings& frame)
        : scene_(scene), caster_(caster), camera_(camera), integrator_(integrator), frame_(frame) {
        // Rendered once with a source that writes down all queries. It answers "blocked"; the picture does
        // not matter.
        render(source_);
        size_t rows = 0;
        // Tiles one after the other: an eye point's number in the frame is its tile's first row plus its
        // place.
        for (const TileTap& tile : source_.tiles()) {
            first_row_.push_back(rows);
            rows += tile.eyes.size();
        }
        rows_ = rows;
        // Only groups of which some tile has samples
        for (const TileTap& tile : source_.tiles())
            for (const auto& [group, samples] : tile.samples)
                if (samples.at.size() > 0) groups_[group] = true;
        for (auto& [group, joined] : groups_) join(group);
    }
    py::list tiles() const {
        py::list out;
        for (const TileTap& tile : source_.tiles()) out.append(eye_block_dict(tile.eyes));
        return out;
    }
    py::list lights() const {
        py::list out;
        for (const FarEnds& ends : source_.lights()) out.append(far_ends_dict(ends));
        return out;
    }
    py::array_t<uint64_t> wanted(size_t light) const {
        const size_t words = words_for(source_.lights().at(light).count);
        py::array_t<uint64_t> out({py::ssize_t(rows_), py::ssize_t(words)});
        // Copied row by row: rows of a tile are padded, those of the array are not.
        uint64_t* to = out.mutable_data();
        for (const TileTap& tile : source_.tiles())
            for (size_t r = 0; r < tile.eyes.size(); ++r, to += words)
                std::memcpy(to, tile.wanted[light].row(r), words * sizeof(Word));
        return out;
    }
    py::list sample_groups() const {
        py::list out;
        for (const auto& [group, there] : groups_) out.append(group);
        return out;
    }
    /// Eye point, position or direction, normal, density and contribution of each sample of a group.
    py::dict samples(int group) const {
        const SamplesTap& s = joined(group);
        const py::ssize_t n = py::ssize_t(s.at.size());
        py::array_t<uint32_t> index(n);
        // Eye points by their numbers in the frame
        for_each_sample(s.at, [&](uint32_t eye, size_t i) { index.mutable_at(py::ssize_t(i)) = eye; });
        FarEnds ends;
        ends.semantic = s.at.semantic;
        ends.group = group;
        ends.t_max = s.at.t_max;
        ends.count = s.at.size();
        for (size_t i = 0; i < s.at.size(); ++i) {
            const Vec3 far = s.at.far(i), end = s.at.target(i);
            // Directions have no surface at their end.
            const Vec3 normal = s.at.is_direction() ? Vec3{} : s.at.normal[i];
            for (auto [to, from] : {std::pair{&ends.x, far.x},
                                    {&ends.y, far.y},
                                    {&ends.z, far.z},
                                    {&ends.nx, normal.x},
                                    {&ends.ny, normal.y},
                                    {&ends.nz, normal.z},
                                    {&ends.tx, end.x},
                                    {&ends.ty, end.y},
                                    {&ends.tz, end.z}})
                to->push_back(from);
        }
        ends.density = s.at.density;
        py::dict out = far_ends_dict(ends);
        out["index"] = index;
        out["contributions"] = from_vec3s(s.contribution);
        return out;
    }
    /// Contributions are not kept with the queries: three floats per query would be most of the memory. The
    /// frame is rendered again, and the values of these rows are written down.
    py::array_t<float> contributions(int group, size_t begin, size_t end) {
        if (begin > end || end > rows_) throw py::value_error("rows must lie inside the frame's eye points");
        ContributionSource source(first_row_, group, begin, end);
        render(source);
        const size_t rows = end - begin, columns = rows ? source.values().size() / rows : 0;
        py::array_t<float> out({py::ssize_t(rows), py::ssize_t(columns), py::ssize_t(3)});
        std::memcpy(out.mutable_data(), source.values().data(), source.values().size() * sizeof(Rgb));
        return out;
    }
    /// The answers of a source to all queries, asked as the frame asks them: {"lights": [...], "samples":
    /// {group: ...}}.
    py::dict ask(OracleSource& inner) const {
        AnswerSource source(inner);
        // The same code renders the frame, so the source sees exactly the queries of a frame.
        py::dict out = account_dict(render(source)), samples;
        py::list lights;
        for (size_t light = 0; light < source_.lights().size(); ++light)
            lights.append(block_of(source, light, source_.lights()[light].count));
        for (const auto& [group, there] : groups_) samples[py::int_(group)] = samples_of(source, group);
        out["lights"] = lights;
        out["samples"] = samples;
        return out;
    }
    /// Answers that are still empty.
    /// Numbered like the queries: the rows of tile t begin at first_row[t].
    GivenAnswers answers() const {
        GivenAnswers out;
        out.first_row = first_row_;
        return out;
    }
    size_t rows() const { return rows_; }
    const SamplesTap& joined(int group) const {
        const auto found = joined_.find(group);
        if (found == joined_.end()) throw py::value_error("the frame asks for no samples of this group");
        return found->second;
    }

private:
    FrameResult render(OracleSource& source) const {
        return run_interruptible([&](Control& control) {
            return render_frame(scene_, caster_, camera_, integrator_, frame_, source, control);
        });
    }
    /// Bits and weights of a shared group, in the order of the tiles.
    py::dict block_of(const AnswerSource& source, size_t light, size_t columns) const {
        const size_t words = words_for(columns);
        py::array_t<uint64_t> bits({py::ssize_t(rows_), py::ssize_t(words)});
        uint64_t* to = bits.mutable_data();
        bool weighted = false;
        for (const TileAnswers& tile : source.tiles()) {
            for (size_t r = 0; r < tile.bits[light].rows(); ++r, to += words)
                std::memcpy(to, tile.bits[light].row(r), words * sizeof(Word));
            // One tile with weights is enough for an array of them.
            weighted |= !tile.weights[light].empty();
        }
        py::dict out;
        out["bits"] = bits;
        if (!weighted) return out;
        py::array_t<float> weights({py::ssize_t(rows_), py::ssize_t(columns)});
        float* next = weights.mutable_data();
        for (const TileAnswers& tile : source.tiles()) {
            const size_t n = tile.bits[light].rows() * columns;
            const std::vector<float>& from = tile.weights[light];
            // Tiles without weights count as they are.
            next = from.empty() ? std::fill_n(next, n, 1.f) : std::copy(from.begin(), from.end(), next);
        }
        out["weights"] = weights;
        return out;
    }
    /// Answers and weights of a group's samples in the order of the eye points, and the order in which every
    /// tile asked for them.
    py::dict samples_of(const AnswerSource& source, int group) const {
        std::vector<uint8_t> visible;
        std::vector<float> weights;
        std::vector<std::vector<uint32_t>> order, run_end;
        bool weighted = false;
        for (const TileAnswers& tile : source.tiles()) {
            const auto found = tile.samples.find(group);
            const TileAnswers::Samples none, &s = found == tile.samples.end() ? none : found->second;
            // In the order of the eye points, whatever the order in which they were asked
            for (const auto& [eye, row] : s.rows) {
                visible.insert(visible.end(), row.first.begin(), row.first.end());
                weights.insert(weights.end(), row.second.begin(), row.second.end());
            }
            weighted |= s.weighted;
            order.push_back(s.order);
            run_end.push_back(s.run_end);
        }
        py::array_t<bool> seen(py::ssize_t(visible.size()));
        std::copy(visible.begin(), visible.end(), seen.mutable_data());
        py::dict out;
        out["visible"] = seen;
        if (weighted) out["weights"] = py::array_t<float>(py::ssize_t(weights.size()), weights.data());
        out["order"] = order;
        out["run_end"] = run_end;
        return out;
    }
    /// Joins the samples of a group from all tiles. Eye points get their numbers in the frame.
    void join(int group) {
        SamplesTap& all = joined_[group];
        for (size_t t = 0; t < source_.tiles().size(); ++t) {
            const auto& samples = source_.tiles()[t].samples;
            const auto found = samples.find(group);
            if (found == samples.end()) continue;
            // `append` adds the tile's first row to its eye points.
            all.append(found->second.at, found->second.contribution, uint32_t(first_row_[t]));
        }
    }

    const Scene& scene_;
    const RayCaster& caster_;
    const Camera camera_;
    const IntegratorSettings integrator_;
    const FrameSettings frame_;
    TapSource source_;
    std::vector<size_t> first_row_;
    size_t rows_ = 0;
    std::map<int, bool> groups_;
    std::map<int, SamplesTap> joined_;
};

/// Answers for a frame. They keep the arrays alive that they refer to.
class Answers {
public:
    explicit Answers(const FrameTaps& taps) : taps_(taps), given_(taps.answers()) {}
    void block(int group, const WordArray& bits, const std::optional<FloatArray>& weights, size_t columns) {
        const size_t words = words_for(columns);
        if (bits.ndim() != 2 || size_t(bits.shape(0)) != taps_.rows() || size_t(bits.shape(1)) != words)
            throw py::value_error("bits must have shape (" + std::to_string(taps_.rows()) + ", " +
                                  std::to_string(words) + "), got " + shape_text(bits));
        if (weights && (weights->ndim() != 2 || size_t(weights->shape(0)) != taps_.rows() ||
                        size_t(weights->shape(1)) != columns))
            throw py::value_error("weights must have shape (" + std::to_string(taps_.rows()) + ", " +
                                  std::to_string(columns) + "), got " + shape_text(*weights));
        // Pointers into the arrays, which `keep_` holds for as long as answers are given from them.
        given_.blocks[group] = {words, bits.data(), weights ? weights->data() : nullptr, columns};
        keep_.append(bits);
        if (weights) keep_.append(*weights);
    }
    void samples(int group, const BoolArray& visible, const std::optional<FloatArray>& weights,
                 std::vector<std::vector<uint32_t>> order, std::vector<std::vector<uint32_t>> run_end) {
        const LocalSamples& s = taps_.joined(group).at;
        if (visible.ndim() != 1 || size_t(visible.size()) != s.size())
            throw py::value_error("visible must have shape (" + std::to_string(s.size()) + ",), got " +
                                  shape_text(visible));
        if (weights && (weights->ndim() != 1 || size_t(weights->size()) != s.size()))
            throw py::value_error("weights must have shape (" + std::to_string(s.size()) + ",), got " +
                                  shape_text(*weights));
        GivenSamples given;
        given.visible = reinterpret_cast<const uint8_t*>(visible.data());
        given.weights = weights ? weights->data() : nullptr;
        given.order = std::move(order);
        given.run_end = std::move(run_end);
        // Where each eye point's samples begin; those without samples begin at 0 and have none.
        given.first_sample.assign(taps_.rows() + 1, 0);
        for (size_t row = 0; row < s.eye.size(); ++row) given.first_sample[s.eye[row]] = s.begin_of(row);
        given_.samples[group] = std::move(given);
        keep_.append(visible);
        if (weights) keep_.append(*weights);
    }
    std::unique_ptr<GivenSource> source() const { return std::make_unique<GivenSource>(given_); }

private:
    const FrameTaps& taps_;
    GivenAnswers given_;
    py::list keep_;
};

}  // namespace

void bind_taps(py::module_& m) {
    py::class_<FrameTaps>(m, "FrameTaps", "All queries of a frame; see viscache.connections.")
        .def(py::init<const Scene&, const RayCaster&, const Camera&, const IntegratorSettings&,
                      const FrameSettings&>(),
             py::arg("scene"), py::arg("caster"), py::arg("camera"), py::arg("integrator"), py::arg("frame"),
             py::keep_alive<1, 2>(), py::keep_alive<1, 3>())
        .def("tiles", &FrameTaps::tiles)
        .def("lights", &FrameTaps::lights)
        .def("wanted", &FrameTaps::wanted, py::arg("light"))
        .def("sample_groups", &FrameTaps::sample_groups)
        .def("samples", &FrameTaps::samples, py::arg("group"))
        .def("contributions", &FrameTaps::contributions, py::arg("group"), py::arg("begin"), py::arg("end"))
        .def("ask", &FrameTaps::ask, py::arg("source"))
        .def_property_readonly("rows", &FrameTaps::rows);
    py::class_<GivenSource, OracleSource>(m, "GivenSource", "Oracles that give stored answers.");
    py::class_<Answers>(m, "GivenAnswers", "Stored answers for one frame.")
        .def(py::init<const FrameTaps&>(), py::arg("taps"), py::keep_alive<1, 2>())
        .def("block", &Answers::block, py::arg("group"), py::arg("bits"), py::arg("weights"),
             py::arg("columns"))
        .def("samples", &Answers::samples, py::arg("group"), py::arg("visible"), py::arg("weights"),
             py::arg("order"), py::arg("run_end"))
        .def("source", &Answers::source, py::keep_alive<0, 1>());
}

}  // namespace viscache::bindings
