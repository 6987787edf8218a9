#pragma once
// Records of the renderer's queries, tile by tile, and frames with given answers.
//
// Both are oracles, so the same code renders the frame. The records hold the queries that any oracle would
// get, and given answers are summed like those of any oracle.
#include <map>
#include <memory>
#include <vector>

#include "viscache/render/local_samples.h"
#include "viscache/render/shared_lights.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

/// Samples of the eye points of a tile, for one light group.
struct SamplesTap {
    LocalSamples at;                ///< rows in the order of the eye points
    std::vector<Rgb> contribution;  ///< unoccluded contribution of each

    /// Appends samples of other eye points; their eye points are numbered from `first_eye` on.
    void append(const LocalSamples& s, std::span<const Rgb> values, uint32_t first_eye = 0);
};

/// Queries of a frame for one tile.
struct TileTap {
    EyeBlock eyes;
    std::vector<BitMatrix> wanted;      ///< of every shared light group
    std::map<int, SamplesTap> samples;  ///< by light group
};

/// Records the queries of a frame. Nothing is visible.
class TapSource final : public OracleSource {
public:
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override;
    void begin_round(size_t items) override { tiles_.resize(items); }
    void end_item(VisibilityOracle& oracle, size_t item) override;

    const std::vector<FarEnds>& lights() const { return lights_; }
    const std::vector<TileTap>& tiles() const { return tiles_; }

private:
    std::vector<FarEnds> lights_;
    std::vector<TileTap> tiles_;
};

/// Answers of an oracle for one tile.
struct TileAnswers {
    std::vector<BitMatrix> bits;              ///< of every shared light group
    std::vector<std::vector<float>> weights;  ///< for each group: rows × columns, or empty
    struct Samples {
        /// By eye point of the tile: answers for its samples and their weights.
        std::map<uint32_t, std::pair<std::vector<uint8_t>, std::vector<float>>> rows;
        std::vector<uint32_t> order, run_end;  ///< order and ends of batches that the oracle asked for
        bool weighted = false;
    };
    std::map<int, Samples> samples;  ///< by light group
};

/// Records the answers of the oracles of another source. The frame uses them as well.
class AnswerSource final : public OracleSource {
public:
    /// `inner` must outlive this source and serve no other frame.
    explicit AnswerSource(OracleSource& inner) : inner_(inner) {}
    void prepare(FrameStart& frame, Control& control) override { inner_.prepare(frame, control); }
    bool corrects() const override { return inner_.corrects(); }
    std::unique_ptr<VisibilityOracle> make() override;
    int dealt_tile_edge() const override { return inner_.dealt_tile_edge(); }
    void begin_round(size_t items) override {
        tiles_.resize(items);
        inner_.begin_round(items);
    }
    void end_item(VisibilityOracle& oracle, size_t item) override;
    void end_round(Counters& counters) override { inner_.end_round(counters); }
    void report(Counters& counters, SourceReport& out) const override { inner_.report(counters, out); }

    const std::vector<TileAnswers>& tiles() const { return tiles_; }

private:
    OracleSource& inner_;
    std::vector<TileAnswers> tiles_;
};

/// Unoccluded contributions of one shared group to some eye points: rows × columns.
class ContributionSource final : public OracleSource {
public:
    /// `first_row[t]`: index of the first eye point of tile t. Rows [begin, end) are wanted.
    ContributionSource(std::vector<size_t> first_row, int group, size_t begin, size_t end)
        : first_row_(std::move(first_row)), group_(group), begin_(begin), end_(end) {}
    std::unique_ptr<VisibilityOracle> make() override;
    const std::vector<Rgb>& values() const { return values_; }
    void prepare(FrameStart& frame, Control& control) override;

private:
    friend class ContributionOracle;
    std::vector<size_t> first_row_;
    int group_;
    size_t begin_, end_, columns_ = 0;
    std::vector<Rgb> values_;
};

/// Answers for one shared light group: one row per eye point, through all tiles.
struct GivenBlock {
    size_t words = 0;
    const Word* bits = nullptr;      ///< rows × words
    const float* weights = nullptr;  ///< rows × columns; nullptr: 1 each
    size_t columns = 0;
};

/// Answers for one group of samples, in the order of a TapSource.
struct GivenSamples {
    const uint8_t* visible = nullptr;
    const float* weights = nullptr;  ///< nullptr: 1 each
    /// For each tile, the order in which its eye points are added, and the ends of batches in it. Empty: the
    /// order of the eye points.
    std::vector<std::vector<uint32_t>> order, run_end;
    std::vector<size_t> first_sample;  ///< index of every eye point's first sample, and the end
};

struct GivenAnswers {
    std::vector<size_t> first_row;  ///< index of the first eye point of every tile
    std::map<int, GivenBlock> blocks;
    std::map<int, GivenSamples> samples;
};

/// A frame with these answers. Groups without answers stay dark.
class GivenSource final : public OracleSource {
public:
    explicit GivenSource(GivenAnswers answers) : answers_(std::move(answers)) {}
    std::unique_ptr<VisibilityOracle> make() override;

private:
    GivenAnswers answers_;
};

}  // namespace viscache
