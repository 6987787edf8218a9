#include "viscache/correlation/bin_edges.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace viscache {
namespace {

/// Larger than any key.
constexpr uint32_t kNever = ~0u;
constexpr size_t kMaxEdges = 8192, kMaxCells = size_t{1} << 20;

void check_edges(std::span<const double> edges, const char* name, double last) {
    const std::string n = name;
    if (edges.size() < 2 || edges.size() > kMaxEdges)
        throw std::invalid_argument(n + " must hold 2 to " + std::to_string(kMaxEdges) + " edges, got " +
                                    std::to_string(edges.size()));
    for (size_t i = 0; i < edges.size(); ++i) {
        if (!(edges[i] >= 0 && edges[i] <= last))
            throw std::invalid_argument(n + " must lie in [0, " + std::to_string(last) + "], got " +
                                        std::to_string(edges[i]));
        if (i && !(edges[i] > edges[i - 1]))
            throw std::invalid_argument(n + " must increase, got " + std::to_string(edges[i - 1]) +
                                        " before " + std::to_string(edges[i]));
    }
}

/// The smallest float >= x.
// A float is at or past an edge in double exactly if it is at or past this float.
float float_above(double x) {
    const float f = float(x);
    return double(f) < x ? std::nextafter(f, INFINITY) : f;
}

}  // namespace

BinEdges BinEdges::distances(std::span<const double> edges) {
    check_edges(edges, "d_edges", INFINITY);
    std::vector<uint32_t> keys;
    for (double d : edges) keys.push_back(std::isinf(d) ? kNever : distance_key(float_above(d * d)));
    return BinEdges(std::move(keys), "d_edges");
}

BinEdges BinEdges::angles(std::span<const double> edges_deg) {
    check_edges(edges_deg, "theta_edges_deg", 180);
    std::vector<uint32_t> keys;
    for (double angle : edges_deg) {
        // The squared chord of two unit vectors at an angle θ is 4 sin²(θ/2). It needs no arc cosine, and
        // orders pairs as the angle does.
        const double s = std::sin(angle * (M_PI / 180) / 2);
        // Nothing lies beyond opposite normals, so they belong to the last bin.
        keys.push_back(angle == 180 ? kNever : chord_key(float_above(4 * s * s)));
    }
    return BinEdges(std::move(keys), "theta_edges_deg");
}

BinEdges::BinEdges(std::vector<uint32_t> keys, const char* name) : keys_(std::move(keys)) { build(name); }

void BinEdges::build(const char* name) {
    std::vector<uint32_t> inner;
    for (uint32_t k : keys_)
        // An edge at 0 lies at or below every key, an infinite one beyond all: neither needs a cell.
        if (k != 0 && k != kNever) inner.push_back(k);
    const size_t zeros = size_t(std::count(keys_.begin(), keys_.end(), 0u));
    // Find the coarsest cells that hold at most one edge each
    // Wide cells make a short table. At most 2^16 keys, so that offsets fit below the code.
    shift_ = 16;
    auto shares_cell = [&](uint32_t a, uint32_t b) { return a >> shift_ == b >> shift_; };
    while (shift_ > 1 && std::adjacent_find(inner.begin(), inner.end(), shares_cell) != inner.end()) --shift_;
    const size_t cells = inner.empty() ? 0 : size_t((inner.back() >> shift_) - (inner.front() >> shift_)) + 1;
    // Edges that share a cell of two keys, or need a million cells, are closer than floats can distinguish.
    if (zeros > 1 || shift_ == 1 || cells > kMaxCells)
        throw std::invalid_argument(std::string(name) +
                                    " must lie further apart than single precision tells");
    // One cell before the first edge, one after the last
    first_cell_ = inner.empty() ? 0 : (inner.front() >> shift_) - 1;
    // Edges at 0 count from the start.
    size_t code = zeros, next = 0;
    for (uint32_t cell = first_cell_; cell < first_cell_ + cells + 2; ++cell) {
        const bool holds_edge = next < inner.size() && inner[next] >> shift_ == cell;
        const uint32_t edge = holds_edge ? inner[next] - (cell << shift_) : KeyTable::kNoEdge;
        entries_.push_back(uint32_t(code << KeyTable::kCodeShift) + KeyTable::kNoEdge - edge -
                           (cell << shift_));
        if (holds_edge) {
            ++code;
            ++next;
        }
    }
}

}  // namespace viscache
