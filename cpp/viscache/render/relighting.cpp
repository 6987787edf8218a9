#include "viscache/render/relighting.h"

#include "viscache/vismap/node_directions.h"
#include "viscache/vismap/record.h"
#include "viscache/vismap/reflection.h"

namespace viscache {

namespace {

constexpr int kRelitTileEdge = 32;
constexpr size_t kQuarters = 4;  // samples of B per cell

/// Ṽ of every cell.
void blend(const BlendedMaps& maps, std::vector<float>& visible) {
    // Ṽ is the blend of bits with weights β that sum to one
    std::fill(visible.begin(), visible.end(), 0.f);
    for (int i = 0; i < maps.count; ++i)
        for (size_t z = 0; z < visible.size(); ++z)
            if (get_bit(maps.bits[i], z)) visible[z] += maps.beta[i];
}

}  // namespace

/// Buffers of one thread.
struct Relighting::Worker {
    EyeTile eyes;
    MapReader maps;
    std::vector<float> visible;

    /// Adds the blocks of one eye point. `colours` is 1 or 3.
    void add(const Reflection& reflection, int m, int colours, Part& part) const {
        RgbBlock quarters;
        for (size_t first = 0; first < visible.size(); first += kBlock) {
            float sum[3][kBlock]{};
            bool any = false;
            // Blocks of a hidden part of the sky are not stored: a point in a room keeps few of
            // them
            for (size_t k = 0; k < kBlock; ++k) any |= visible[first + k] > 0;
            if (!any) continue;
            any = false;
            // One level finer than the maps: along the Morton curve the four quarters of a cell
            // follow each other, so 64 samples serve 16 cells
            for (size_t q = 0; q < kQuarters; ++q) {
                const size_t child = kQuarters * first + q * kBlock;
                reflection.sample(m + 1, uint32_t(child), quarters);
                const float* channels[3] = {quarters.r, quarters.g, quarters.b};
                for (int c = 0; c < colours; ++c)
                    for (size_t i = 0; i < kBlock; ++i)
                        sum[c][(q * kBlock + i) / kQuarters] += channels[c][i] / float(kQuarters);
            }
            for (int c = 0; c < colours; ++c)
                // The mean of the quarters, times Ṽ. Below the horizon B̃ vanishes, and the block
                // is left out
                for (size_t k = 0; k < kBlock; ++k) any |= (sum[c][k] *= visible[first + k]) > 0;
            if (!any) continue;
            part.block.push_back(uint16_t(first / kBlock));
            for (int c = 0; c < colours; ++c) part.value.insert(part.value.end(), sum[c], sum[c] + kBlock);
        }
    }
};

Relighting::Relighting(const EyePathTracer& tracer, const MapSource& maps, Control& control)
    : width_(tracer.frame.width), height_(tracer.frame.height), m_(maps.m) {
    const auto tiles = cut_tiles(width_, height_, kRelitTileEdge);
    const int threads = resolve_threads(tracer.frame.threads);
    parts_.resize(tiles.size());
    std::vector<Worker> workers{size_t(threads)};
    // Counters by tile, merged in order: they do not depend on threads
    std::vector<Counters> counted(tiles.size());
    std::vector<size_t> without_record(tiles.size());
    control.total = tiles.size();
    parallel_for(tiles.size(), threads, [&](size_t t, int worker) {
        control.check();
        Worker& w = workers[size_t(worker)];
        // A worker starts empty and is filled when it gets its first tile
        w.visible.resize(map_cells(m_));
        if (!w.maps) w.maps = maps.reader();
        tracer.trace(tiles[t], w.eyes, counted[t], control);
        Part& part = parts_[t];
        for (size_t i = 0; i < w.eyes.size(); ++i) {
            const uint32_t x = w.eyes.pixel[i] % uint32_t(w.eyes.width),
                           y = w.eyes.pixel[i] / uint32_t(w.eyes.width);
            const size_t pixel = size_t(tiles[t].y0 + int(y)) * size_t(width_) + size_t(tiles[t].x0 + int(x));
            ShadingPoint sp = w.eyes.shading[i];
            Rgb colour = w.eyes.throughput[i];
            const bool coloured = sp.kind == MaterialKind::kGlossy;
            // The colour of a diffuse surface is stored once, so that one value per cell is enough
            if (!coloured) {
                colour = colour * sp.base;
                sp.base = {1, 1, 1};
            }
            const SurfaceReflection reflection(sp);
            // Nothing that any light could change
            if (reflection.black() || !(max_component(colour) > 0)) continue;
            const BlendedMaps found = w.maps(w.eyes.block.position[i], w.eyes.block.normal[i], pixel);
            if (found.count == 0) {
                ++without_record[t];
                continue;
            }
            blend(found, w.visible);
            const auto first_block = uint32_t(part.block.size());
            const size_t first_value = part.value.size();
            w.add(reflection, m_, coloured ? 3 : 1, part);
            part.points.push_back({uint32_t(pixel), first_block, uint32_t(part.block.size()) - first_block,
                                   first_value, coloured, colour});
        }
        // The parts stay for the life of the object, which may be many frames
        part.block.shrink_to_fit();
        part.value.shrink_to_fit();
        control.done.fetch_add(1);
    });
    for (size_t t = 0; t < tiles.size(); ++t) {
        counters_.merge(counted[t]);
        without_record_ += without_record[t];
    }
}

/// Calls visit(first cell, values of the block in up to three channels).
template <class Visit>
void Relighting::for_each_value(const Part& part, const Point& p, Visit visit) const {
    // Without colours all three channels point to the same values
    const size_t stride = p.coloured ? kBlock : 0;
    const float* value = &part.value[p.first_value];
    for (uint32_t b = 0; b < p.blocks; ++b, value += p.coloured ? 3 * kBlock : kBlock)
        visit(size_t(part.block[p.first_block + b]) * kBlock, value, value + stride, value + 2 * stride);
}

void Relighting::image(const CellLight& light, std::span<std::array<double, 3>> pixels, int threads) const {
    std::fill(pixels.begin(), pixels.end(), std::array<double, 3>{});
    const double *red = light.channel[0].data(), *green = light.channel[1].data(),
                 *blue = light.channel[2].data();
    // A pixel belongs to one tile, so threads never add to the same one
    parallel_for(parts_.size(), threads, [&](size_t t, int) {
        for (const Point& p : parts_[t].points) {
            // Separate lanes, added at the end: the order of sums is fixed and the loop uses SIMD
            double lanes[3][kBlock]{};
            if (p.blocks > 0)
                for_each_value(parts_[t], p,
                               [&](size_t first, const float* r, const float* g, const float* b) {
                                   for (size_t k = 0; k < kBlock; ++k) {
                                       lanes[0][k] += double(r[k]) * red[first + k];
                                       lanes[1][k] += double(g[k]) * green[first + k];
                                       lanes[2][k] += double(b[k]) * blue[first + k];
                                   }
                               });
            const double colour[3] = {p.colour.x, p.colour.y, p.colour.z};
            for (int c = 0; c < 3; ++c) {
                double sum = 0;
                for (double lane : lanes[c]) sum += lane;
                pixels[p.pixel][size_t(c)] += sum * colour[c];
            }
        }
    });
}

std::vector<std::array<double, 3>> Relighting::transfer(size_t pixel) const {
    std::vector<std::array<double, 3>> cells(map_cells(m_));
    for (const Part& part : parts_)
        for (const Point& p : part.points)
            // A pixel may have several eye points: samples, and branches of glass
            if (p.pixel == pixel && p.blocks > 0)
                for_each_value(part, p, [&](size_t first, const float* r, const float* g, const float* b) {
                    for (size_t k = 0; k < kBlock; ++k) {
                        cells[first + k][0] += double(r[k]) * double(p.colour.x);
                        cells[first + k][1] += double(g[k]) * double(p.colour.y);
                        cells[first + k][2] += double(b[k]) * double(p.colour.z);
                    }
                });
    return cells;
}

size_t Relighting::nbytes() const {
    size_t n = 0;
    for (const Part& p : parts_)
        n += p.points.size() * sizeof(Point) + p.block.size() * sizeof(uint16_t) +
             p.value.size() * sizeof(float);
    return n;
}

}  // namespace viscache
