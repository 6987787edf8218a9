#pragma once
// Connects eye and light sub-paths: one visibility query for every pair with a contribution.
#include "viscache/render/subpaths.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

/// Connections of a sample tile: queries for an oracle, and the unoccluded contribution of each.
struct Connections {
    /// Eye points of the queries: vertices of eye paths, or of light paths for connections with the camera.
    EyeBlock eyes;
    std::vector<ShadowQuery> queries;
    std::vector<Rgb> contribution;  ///< weighted and divided by the samples per pixel
    std::vector<uint32_t> pixel;    ///< index in the tile; in the frame for connections with the camera
    void clear() {
        eyes.clear();
        queries.clear();
        contribution.clear();
        pixel.clear();
    }
};

/// Connects the two paths of one sample.
class Connector {
public:
    Connector(const BdptContext& context, Connections& out, Counters& counters)
        : c_(context), out_(out), counters_(counters) {}

    /// `pixel`: index in the tile of the eye path.
    void join(const Subpaths& eye_paths, const Subpaths& light_paths, size_t path, uint32_t pixel);

private:
    /// A connected path before its visibility is known.
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
