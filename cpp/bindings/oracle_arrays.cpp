#include "oracle_arrays.h"
#include "real_numbers.h"

#include "arrays.h"
#include "caster_queries.h"
#include "checked_rows.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache::bindings {

namespace {

// In the order of Semantic
constexpr const char* kKinds[] = {"points", "directions", "surfaces", "solid_angle"};

/// An optional entry of a dict as an array.
/// An array of another type is converted; what cannot be is named in the error.
std::optional<FloatArray> given(const py::dict& d, const char* name) {
    if (!d.contains(name) || d[name].is_none()) return std::nullopt;
    auto a = FloatArray::ensure(d[name]);
    if (!a) throw py::value_error(std::string(name) + " must be numbers");
    return a;
}

FloatArray needed(const py::dict& d, const char* name) {
    auto a = given(d, name);
    if (!a) throw py::value_error(std::string(name) + " must be given");
    return *a;
}

// Without the array, all rows have one value.
std::vector<float> numbers(const py::dict& d, const char* name, size_t n, float otherwise) {
    const auto a = given(d, name);
    if (!a) return std::vector<float>(n, otherwise);
    if (a->ndim() != 1 || size_t(a->shape(0)) != n)
        throw py::value_error(std::string(name) + " must have shape (" + std::to_string(n) + ",), got " +
                              shape_text(*a));
    for (size_t i = 0; i < n; ++i)
        if (!(a->data()[i] >= 0) || !std::isfinite(a->data()[i]))
            throw py::value_error(std::string(name) + " must be finite and >= 0, row " + std::to_string(i) +
                                  " is " + std::to_string(a->data()[i]));
    return {a->data(), a->data() + n};
}

std::span<const Vec3> same_rows(std::span<const Vec3> rows, size_t n, const char* name) {
    if (rows.size() != n)
        throw py::value_error(std::string(name) + " must have " + std::to_string(n) + " rows, got " +
                              std::to_string(rows.size()));
    return rows;
}

Semantic semantic_of(const std::string& kind) {
    for (int i = 0; i < 4; ++i)
        if (kind == kKinds[i]) return Semantic(i);
    throw py::value_error("kind must be points, directions, surfaces or solid_angle, got " + kind);
}

}  // namespace

EyeBlock eye_block_from(const py::dict& d, float extent) {
    EyeBlock eyes;
    const FloatArray p = needed(d, "positions"), n = needed(d, "normals");
    const auto positions = usable(p, "positions");
    const auto normals = same_rows(units(n, "normals"), positions.size(), "normals");
    eyes.position.assign(positions.begin(), positions.end());
    eyes.normal.assign(normals.begin(), normals.end());
    // An oracle written in Python gets the origins of the frame; users need not give any.
    if (const auto o = given(d, "origins")) {
        const auto origins = same_rows(usable(*o, "origins"), positions.size(), "origins");
        eyes.origin.assign(origins.begin(), origins.end());
    } else {
        for (size_t i = 0; i < eyes.size(); ++i)
            eyes.origin.push_back(spawn(eyes.position[i], eyes.normal[i], extent));
    }
    eyes.density = numbers(d, "density", eyes.size(), 1.f);
    // Places in the tile, for oracles that process eye points in an order of their own.
    if (d.contains("order") && !d["order"].is_none()) {
        const auto order = UintArray::ensure(d["order"]);
        if (!order || order.ndim() != 2 || size_t(order.shape(0)) != eyes.size() || order.shape(1) != 2)
            throw py::value_error("order must have shape (N, 2)");
        for (size_t i = 0; i < eyes.size(); ++i) {
            eyes.order_x.push_back(order.at(py::ssize_t(i), 0));
            eyes.order_y.push_back(order.at(py::ssize_t(i), 1));
        }
        const auto tile = d["tile"].cast<std::array<uint32_t, 2>>();
        eyes.tile_width = tile[0];
        eyes.tile_height = tile[1];
    }
    return eyes;
}

py::dict eye_block_dict(const EyeBlock& eyes) {
    const py::ssize_t n = py::ssize_t(eyes.size());
    py::array_t<uint32_t> order({n, py::ssize_t(2)});
    for (size_t i = 0; i < eyes.order_x.size(); ++i) {
        order.mutable_at(py::ssize_t(i), 0) = eyes.order_x[i];
        order.mutable_at(py::ssize_t(i), 1) = eyes.order_y[i];
    }
    using namespace py::literals;
    return py::dict(
        "positions"_a = from_vec3s(eyes.position), "normals"_a = from_vec3s(eyes.normal),
        "origins"_a = from_vec3s(eyes.origin), "density"_a = py::array_t<float>(n, eyes.density.data()),
        // Arrays of points have no places in a tile
        "order"_a = eyes.order_x.size() == eyes.size() ? py::object(order) : py::object(py::none()),
        "tile"_a = py::make_tuple(eyes.tile_width, eyes.tile_height));
}

FarEnds far_ends_from(const py::dict& d, float extent) {
    FarEnds ends;
    ends.semantic = semantic_of(d["kind"].cast<std::string>());
    // The group selects counters and settings, so a wrong one would write beyond them
    ends.group = d["group"].cast<int>();
    if (ends.group < 0 || ends.group >= kLightGroups)
        throw py::value_error("group must be in [0, " + std::to_string(kLightGroups) + ")");
    ends.t_max = d["t_max"].cast<float>();
    if (!(ends.t_max >= 0)) throw py::value_error("t_max must be >= 0, got " + std::to_string(ends.t_max));
    const FloatArray p = needed(d, "positions");
    // Directions must be unit vectors, as those of a frame are
    const auto positions = is_direction(ends.semantic) ? units(p, "directions") : usable(p, "positions");
    const size_t n = positions.size();
    ends.count = n;
    // Only surfaces have a side, from which rays must keep off
    const bool surfaces = ends.semantic == Semantic::kSurface;
    std::optional<FloatArray> normals = given(d, "normals"), stops = given(d, "ends");
    if (surfaces && !normals) throw py::value_error("normals must be given for surfaces");
    const auto normal =
        normals ? same_rows(surfaces ? units(*normals, "normals") : usable(*normals, "normals"), n, "normals")
                : std::span<const Vec3>{};
    const auto stop = stops ? same_rows(usable(*stops, "ends"), n, "ends") : std::span<const Vec3>{};
    ends.density = numbers(d, "density", n, 0.f);
    // Padded like the lights of a frame, since kernels read whole vectors.
    const size_t padded = row_words_for(n) * kWordBits;
    for (auto* v : {&ends.x, &ends.y, &ends.z, &ends.nx, &ends.ny, &ends.nz, &ends.tx, &ends.ty, &ends.tz})
        v->assign(padded, 0.f);
    ends.density.resize(padded, 0.f);
    for (size_t k = 0; k < n; ++k) {
        const Vec3 at = positions[k], off = normal.empty() ? Vec3{} : normal[k];
        // Rays to a surface end before it, as those of a frame do. Points and directions are their own ends.
        const Vec3 end = !stop.empty() ? stop[k] : surfaces ? spawn(at, off, extent) : at;
        ends.x[k] = at.x;
        ends.y[k] = at.y;
        ends.z[k] = at.z;
        ends.nx[k] = off.x;
        ends.ny[k] = off.y;
        ends.nz[k] = off.z;
        ends.tx[k] = end.x;
        ends.ty[k] = end.y;
        ends.tz[k] = end.z;
    }
    return ends;
}

py::dict far_ends_dict(const FarEnds& ends) {
    const auto rows = [&](const std::vector<float>& x, const std::vector<float>& y,
                          const std::vector<float>& z) {
        py::array_t<float> a({py::ssize_t(ends.count), py::ssize_t(3)});
        float* to = a.mutable_data();
        for (size_t k = 0; k < ends.count; ++k) {
            *to++ = x[k];
            *to++ = y[k];
            *to++ = z[k];
        }
        return a;
    };
    using namespace py::literals;
    return py::dict("kind"_a = kKinds[size_t(ends.semantic)], "group"_a = ends.group, "t_max"_a = ends.t_max,
                    "positions"_a = rows(ends.x, ends.y, ends.z),
                    "normals"_a = rows(ends.nx, ends.ny, ends.nz), "ends"_a = rows(ends.tx, ends.ty, ends.tz),
                    "density"_a = py::array_t<float>(py::ssize_t(ends.count), ends.density.data()));
}

std::vector<ShadowQuery> queries_from(const FarEnds& ends, std::span<const uint32_t> index) {
    std::vector<ShadowQuery> queries(index.size());
    for (size_t k = 0; k < index.size(); ++k)
        queries[k] = {.eye = index[k],
                      .semantic = ends.semantic,
                      .group = uint8_t(ends.group),
                      .far = {ends.x[k], ends.y[k], ends.z[k]},
                      .far_normal = {ends.nx[k], ends.ny[k], ends.nz[k]},
                      .ray_end = {ends.tx[k], ends.ty[k], ends.tz[k]},
                      .density = ends.density[k],
                      .t_max = ends.t_max};
    return queries;
}

// Byte by byte, word by word: NumPy's bool has one byte.
py::array_t<bool> unpacked(const BitMatrix& bits) {
    py::array_t<bool> out({py::ssize_t(bits.rows()), py::ssize_t(bits.columns())});
    auto* to = reinterpret_cast<uint8_t*>(out.mutable_data());
    for (size_t r = 0; r < bits.rows(); ++r)
        for (size_t w = 0, left = bits.columns(); left > 0; ++w) {
            const Word word = bits.row(r)[w];
            const size_t n = std::min(left, kWordBits);
            for (size_t j = 0; j < n; ++j) to[j] = word >> j & 1;
            to += n;
            left -= n;
        }
    return out;
}

py::array_t<uint64_t> packed(const BitMatrix& bits) {
    const size_t words = words_for(bits.columns());
    py::array_t<uint64_t> out({py::ssize_t(bits.rows()), py::ssize_t(words)});
    for (size_t r = 0; r < bits.rows(); ++r)
        // Padding words of a row are not part of the answer.
        std::memcpy(out.mutable_data(py::ssize_t(r), 0), bits.row(r), words * sizeof(Word));
    return out;
}

}  // namespace viscache::bindings
