#pragma once
// A scene's triangles for shafts, built once for all frames.
#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "viscache/scene/scene.h"
#include "viscache/shafts/shaft_tree.h"
#include "viscache/visibility/query.h"

namespace viscache {

class ShaftScene {
public:
    /// Builds nothing so far. `max_bytes` bounds the tree; 0: no bound.
    explicit ShaftScene(std::shared_ptr<const Scene> scene, uint64_t max_bytes = uint64_t{1} << 32);

    /// Why packets must answer everything; empty if shafts can be used.
    const std::string& refusal() const { return refusal_; }
    uint64_t triangles() const { return triangles_; }
    /// True once the tree is built.
    bool has_tree() const { return has_tree_.load(std::memory_order_acquire); }
    /// Coordinates of the tree are those of the scene times this power of two: the scene's size is then in
    /// [1, 2), and no bound leaves the range of float.
    float scale() const { return scale_; }
    /// False for points so far from the origin, in units of the scene's size, that packets must answer.
    bool is_near(Vec3 p) const { return max_abs(p) * scale_ <= 1024; }
    /// The tree. The first call, which any thread may make, builds it with `threads` threads; so does the
    /// next one after a cancelled build. Throws std::logic_error after a refusal.
    const ShaftTree& tree(int threads, const Control& control) const;

private:
    std::shared_ptr<const Scene> scene_;
    float scale_ = 1;
    std::string refusal_;
    uint64_t triangles_ = 0;
    mutable std::once_flag once_;
    mutable ShaftTree tree_;
    mutable std::atomic<bool> has_tree_ = false;
};

}  // namespace viscache
