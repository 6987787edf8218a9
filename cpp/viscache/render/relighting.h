#pragma once
// An image as a linear function of the environment (VisMap Sec. 6.2). Camera paths are traced and maps are
// looked up once. After that, another environment costs one weighted sum per pixel and no rays.
#include "viscache/render/eye_paths.h"
#include "viscache/vismap/map_source.h"

namespace viscache {

/// Radiance × solid angle of the cells of the maps, along the Morton curve: one array per channel.
struct CellLight {
    std::array<std::vector<double>, 3> channel;
};

/// J = ∫ L·B̃·Ṽ of every pixel, for any L. B̃ is the mean of B at the centres of the four quarters of a cell.
/// It does not depend on the light, so it is stored.
class Relighting {
public:
    /// Stores the product of B̃ and Ṽ for all eye points.
    Relighting(const EyePathTracer& tracer, const MapSource& maps, Control& control);

    /// J of every pixel, row-major, without light that the camera sees directly. The result does not depend
    /// on the number of threads.
    void image(const CellLight& light, std::span<std::array<double, 3>> pixels, int threads) const;
    /// Factor of the light of every cell in one pixel: (red, green, blue) per cell.
    std::vector<std::array<double, 3>> transfer(size_t pixel) const;

    int width() const { return width_; }
    int height() const { return height_; }
    int map_level() const { return m_; }
    size_t nbytes() const;
    /// Eye points without a record. They stay black.
    size_t unserved() const { return unserved_; }
    const Counters& counters() const { return counters_; }

private:
    static constexpr size_t kBlock = 16;  ///< cells per block

    struct Point {
        uint32_t pixel;  ///< index in the frame
        uint32_t first_block, blocks;
        size_t first_value;
        bool coloured;  ///< three values per cell: a red, a green and a blue block
        Rgb colour;     ///< common factor of all values
    };
    /// Eye points of one tile with the blocks that reflect light.
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
    size_t unserved_ = 0;
    Counters counters_;
};

}  // namespace viscache
