#pragma once
// Sources of quantized caches for a frame: with one table per tile, per frame, or kept between frames.
#include "viscache/aqvc/quantized_cache.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

/// Caches that are cleared for each tile.
class AqvcSource : public OracleSource {
public:
    /// `spp`: samples per pixel. `exact` makes the oracles of the exact groups, and must outlive the source;
    /// nullptr: packets of rays.
    AqvcSource(const Scene& scene, const RayCaster& caster, const AqvcParameters& parameters, int spp,
               OracleSource* exact = nullptr);
    void prepare(FrameStart& frame, Control& control) override;
    // Corrections check answers by rays, and check those of few lights often: then more lights are exact.
    void expect_corrections() override { few_ = kFewCorrected; }
    std::unique_ptr<VisibilityOracle> make() override { return make_cache(); }
    int dealt_tile_edge() const override;
    void report(Counters& counters, SourceReport& out) const override;

protected:
    std::unique_ptr<QuantizedCache> make_cache(FrameTable* table = nullptr) const;
    const AqvcParameters parameters_;

private:
    const Scene& scene_;
    const RayCaster& caster_;
    int spp_;
    OracleSource* exact_;
    size_t few_ = kFewLights;
    size_t shared_in_frame_ = 0;  ///< lights that all eye points share
};

/// Caches that share one table of the frame between all threads, for bidirectional path tracing.
class FrameTableSource final : public AqvcSource {
public:
    FrameTableSource(const Scene& scene, const RayCaster& caster, const AqvcParameters& parameters, int spp)
        : AqvcSource(scene, caster, parameters, spp), table_(parameters) {}
    std::unique_ptr<VisibilityOracle> make() override { return make_cache(&table_); }
    // One table of the frame: whichever thread takes a tile, the table is the same.
    int dealt_tile_edge() const override { return 0; }
    void begin_round(size_t items) override { table_.begin_round(items); }
    void end_item(VisibilityOracle& oracle, size_t item) override {
        table_.keep(item, dynamic_cast<QuantizedCache&>(oracle).writes());
    }
    void end_round(Counters& counters) override { table_.end_round(counters); }

private:
    FrameTable table_;
};

/// Caches that read and extend a table kept between frames. An interrupted frame writes nothing to it.
class KeptTableSource final : public AqvcSource {
public:
    /// `table` must outlive the source.
    KeptTableSource(const Scene& scene, const RayCaster& caster, const AqvcParameters& parameters, int spp,
                    KeptTable& table, KeptChecks checks)
        : AqvcSource(scene, caster, parameters, spp), table_(table), checks_(checks) {}
    std::unique_ptr<VisibilityOracle> make() override;
    void begin_round(size_t) override { table_.begin_frame(); }
    void end_item(VisibilityOracle& oracle, size_t item) override {
        table_.keep(item, dynamic_cast<QuantizedCache&>(oracle).kept_writes());
    }
    void end_round(Counters& counters) override { table_.end_frame(counters); }
    void report(Counters& counters, SourceReport& out) const override;

private:
    KeptTable& table_;
    KeptChecks checks_;
};

/// Caches whose level waves start from kept rows and extend them. The owner of the rows commits them.
class AqvcRowsSource final : public AqvcSource {
public:
    /// `rows` must outlive the source.
    AqvcRowsSource(const Scene& scene, const RayCaster& caster, const AqvcParameters& parameters, int spp,
                   AqvcRows& rows, OracleSource* exact = nullptr)
        : AqvcSource(scene, caster, parameters, spp, exact), rows_(rows) {}
    std::unique_ptr<VisibilityOracle> make() override;
    void begin_round(size_t tiles) override { rows_.begin_frame(tiles); }
    void end_item(VisibilityOracle&, size_t item) override { rows_.end_tile(item); }
    void report(Counters& counters, SourceReport& out) const override;

private:
    AqvcRows& rows_;
};

}  // namespace viscache
