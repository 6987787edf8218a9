#pragma once
// Joining eye and light sub-paths: one visibility query for every pair that brings something.
#include "viscache/render/subpaths.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

/// The connections of a sample tile as questions to an oracle, and what each brings when it is unoccluded.
struct Connections {
    /// Eye points of the questions: vertices of eye paths; for connections with the camera those of light
    /// paths.
    EyeBlock eyes;
    std::vector<ShadowQuery> queries;
    std::vector<Rgb> contribution;  ///< weighted, over the samples per pixel
    std::vector<uint32_t> pixel;    ///< of the tile; of the frame for connections with the camera
    void clear() {
        eyes.clear();
        queries.clear();
        contribution.clear();
        pixel.clear();
    }
};

/// Makes the connections of one sample's two paths.
class Connector {
public:
    Connector(const BdptContext& context, Connections& out, Counters& counters)
        : c_(context), out_(out), counters_(counters) {}

    /// `pixel`: of the tile, where the eye path belongs.
    void join(const Subpaths& eye_paths, const Subpaths& light_paths, size_t path, uint32_t pixel);

private:
    /// A joined path without its visibility.
    struct Joint {
        Rgb value;
        Vec3 direction;  ///< unit, from the eye's end to the light's
        JoinDensities densities;
    };
    using Vertices = std::span<const PathVertex>;

    Joint with_light(const Emission& start, Vertices eye, const PathVertex& y) const;
    Joint with_vertex(Vertices eye, Vertices light) const;
    void to_surface(const Emission& start, Vertices eye, Vertices light, uint32_t eye_point, uint32_t pixel);
    void to_camera(const Emission& start, Vertices light);
    uint32_t add_eye_point(const PathVertex& v, bool keyed);
    void add(const ShadowQuery& query, Rgb value, uint32_t pixel);
    bool brings(Rgb value);
    StrategyRules rules(const Emission& start) const;

    const BdptContext& c_;
    Connections& out_;
    Counters& counters_;
};

}  // namespace viscache
