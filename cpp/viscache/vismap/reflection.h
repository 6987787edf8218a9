#pragma once
// Reflection as a function of the incoming direction, B = f·cos, sampled at the centres of quadtree nodes.
#include <span>

#include "viscache/scene/bsdf.h"
#include "viscache/vismap/product_kernels.h"

namespace viscache {

/// The function from which the tree of B̃ is built. Levels and codes are those of node_directions.h.
class Reflection {
public:
    virtual ~Reflection() = default;
    /// B at the sixteen centres of `level` that start at node `first`, a multiple of 16.
    virtual void sample(int level, uint32_t first, RgbBlock& out) const = 0;
    /// touched[i] = 1 if B may be positive somewhere in node `first` + i.
    virtual void touched(int level, uint32_t first, std::span<uint8_t> touched) const = 0;
    /// True if B is zero for every direction.
    virtual bool black() const = 0;
};

/// Diffuse and glossy surfaces: `eval_bsdf`·cos up to float rounding, sixteen directions at a time.
class SurfaceReflection final : public Reflection {
public:
    explicit SurfaceReflection(const ShadingPoint& point) : lobe_(lobe_constants(point)) {}
    void sample(int level, uint32_t first, RgbBlock& out) const override;
    void touched(int level, uint32_t first, std::span<uint8_t> touched) const override;
    bool black() const override { return lobe_.black; }

private:
    LobeConstants lobe_;
};

}  // namespace viscache
