#pragma once
// An image as a linear function of its environment light (VisMap Sec. 6.2): once camera paths are traced and
// maps are looked up, another light costs a weighted sum per pixel and no ray.
#include "viscache/render/eye_paths.h"
#include "viscache/vismap/map_source.h"

namespace viscache {

/// Radiance × solid angle over the cells of the maps, along the Morton curve: one row per channel.
struct CellLight {
    std::array<std::vector<double>, 3> channel;
};

/// J = ∫ L·B̃·Ṽ of every pixel, for any L. B̃ is the mean of B at the centres of a cell's quarters: it does not
/// depend on the light, so that it is kept.
class Relighting {
public:
    /// Keeps the product of B̃ and Ṽ of all eye points.
    Relighting(const EyePathTracer& tracer, const MapSource& maps, Control& control);

    /// J of every pixel, row-major; without the light that the camera sees. The same for any number of
    /// threads.
    void image(const CellLight& light, std::span<std::array<double, 3>> pixels, int threads) const;
    /// What every cell's light is multiplied with in one pixel: (red, green, blue) per cell.
    std::vector<std::array<double, 3>> transfer(size_t pixel) const;

    int width() const { return width_; }
    int height() const { return height_; }
    int map_level() const { return m_; }
    size_t nbytes() const;
    /// Eye points that no record speaks for: black.
    size_t without_record() const { return without_record_; }
    const Counters& counters() const { return counters_; }

private:
    static constexpr size_t kBlock = 16;  ///< cells kept together

    struct Point {
        uint32_t pixel;  ///< of the frame
        uint32_t first_block, blocks;
        size_t first_value;
        bool coloured;  ///< three values per cell: red, green, blue of a block one after another
        Rgb colour;     ///< of all values
    };
    /// Eye points of one tile with the blocks where light arrives.
    struct Part {
        std::vector<Point> points;
        std::vector<uint16_t> block;
        std::vector<float> value;
    };
    struct Worker;
    template <class Visit>
    void for_each_value(const Part& part, const Point& point, Visit visit) const;

    int width_, height_, m_;
    std::vector<Part> parts_;
    size_t without_record_ = 0;
    Counters counters_;
};

}  // namespace viscache
