#pragma once
// What a rendered frame offers a source of oracles before its first item.
#include <cmath>
#include <functional>

#include "viscache/render/frame.h"

namespace viscache {

class RenderedStart final : public FrameStart {
public:
    /// Renders the same view with other frame settings and another source.
    using Render = std::function<FrameResult(const FrameSettings&, OracleSource&, Control&)>;
    /// The rays and the time of small frames are added to `out`.
    /// `pick`: lights of a group that each eye point picks; 0: all.
    RenderedStart(const FrameSettings& frame, std::vector<const FarEnds*> lights, FrameResult& out,
                  Render render, int pick = 0)
        : frame_(frame), lights_(std::move(lights)), out_(out), render_(std::move(render)), pick_(pick) {}
    std::span<const FarEnds* const> lights() const override { return lights_; }
    size_t lights_per_point() const override {
        return pick_ > 0 ? size_t(pick_) : FrameStart::lights_per_point();
    }
    int threads() const override { return frame_.threads; }
    /// One per sample: pixels that see no surface have fewer, and those with glass more.
    uint64_t eye_points() const override {
        return uint64_t(frame_.width) * uint64_t(frame_.height) * uint64_t(frame_.spp);
    }
    Counters ask_small(size_t pixels, OracleSource& source, Control& control) override {
        // The same seed and samples as the frame, fewer pixels
        FrameSettings settings = frame_;
        const double scale =
            std::min(1.0, std::sqrt(double(pixels) / (double(frame_.width) * frame_.height)));
        settings.width = int(std::ceil(frame_.width * scale));
        settings.height = int(std::ceil(frame_.height * scale));
        settings.spp = 1;
        // An audit of the small frame would cost rays and answer no question
        settings.audit_pixels = 0;
        settings.audit_share = 0;
        const FrameResult small = render_(settings, source, control);
        for (int g = 0; g < kLightGroups; ++g)
            // Its rays count as the frame's, so that a source cannot hide what it costs
            out_.counters.group(g).rays += small.counters.groups[size_t(g)].rays;
        out_.counters.light_rays += small.counters.light_rays;
        out_.counters.camera_rays += small.counters.camera_rays;
        out_.stages.merge(small.stages);
        // Its tiles were counted as progress; the frame starts from none
        control.done = 0;
        return small.counters;
    }

private:
    const FrameSettings& frame_;
    std::vector<const FarEnds*> lights_;
    FrameResult& out_;
    Render render_;
    int pick_;
};

}  // namespace viscache
