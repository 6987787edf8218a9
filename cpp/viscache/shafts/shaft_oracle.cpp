#include "viscache/shafts/shaft_oracle.h"

#include <bit>

#include "viscache/shafts/shaft_choice.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

namespace {

/// The rays of a tile towards one light, as the exact oracle aims them.
class TileRays final : public ShaftRays {
public:
    TileRays(const RayCaster& caster, const EyeBlock& eyes, std::span<const uint32_t> order, Vec3 light)
        : caster_(caster), eyes_(eyes), order_(order), light_(light) {}

    uint32_t occluded(size_t packet, uint32_t mask) override {
        RayPacket16 rays;
        for (size_t i = 0; i < kShaftLanes; ++i) {
            rays.start(i, eyes_.origin[order_[std::min(packet * kShaftLanes + i, order_.size() - 1)]]);
            rays.aim(i, light_);
        }
        aim_at_points16(rays);
        return caster_.occluded16(uint16_t(mask), rays, Coherence::kCoherent);
    }

private:
    const RayCaster& caster_;
    const EyeBlock& eyes_;
    std::span<const uint32_t> order_;
    Vec3 light_;
};

/// Number of queries to these lights of the first 64.
uint64_t queries_in(const BitMatrix& wanted, Word some) {
    uint64_t n = 0;
    for (size_t i = 0; i < wanted.rows(); ++i) n += uint64_t(std::popcount(wanted.row(i)[0] & some));
    return n;
}

/// Copies all but these lights of the first 64.
void copy_without(const BitMatrix& wanted, Word some, BitMatrix& rest) {
    rest.reset(wanted.rows(), wanted.columns());
    for (size_t i = 0; i < wanted.rows(); ++i) {
        std::ranges::copy(wanted.row_span(i), rest.row(i));
        rest.row(i)[0] &= ~some;
    }
}

void add_bits(const BitMatrix& from, BitMatrix& to) {
    for (size_t i = 0; i < to.rows(); ++i)
        for (size_t w = 0; w < to.row_words(); ++w) to.row(i)[w] |= from.row(i)[w];
}

}  // namespace

void ShaftTotals::add(const Sums& more) {
    // Oracles of all threads add here, once per block
    const std::lock_guard lock(mutex_);
    sums_.queries += more.queries;
    sums_.left_to_packets += more.left_to_packets;
    sums_.work.merge(more.work);
}

ShaftTotals::Sums ShaftTotals::sums() const {
    const std::lock_guard lock(mutex_);
    return sums_;
}

void ShaftOracle::begin_tile(const EyeBlock& eyes) {
    exact_->begin_tile(eyes);
    // The points are sorted when the first block wants shafts, which may be never
    is_prepared_ = false;
}

/// True if no coordinate is so large that bounds leave the range of float.
bool ShaftOracle::fits(const EyeBlock& eyes, const FarEnds& lights) {
    if (!is_sorted(eyes)) {
        eyes_fit_ = true;
        for (const Vec3 o : eyes.origin) eyes_fit_ = eyes_fit_ && scene_.is_near(o);
    }
    if (!eyes_fit_) return false;
    for (size_t k = 0; k < lights.count; ++k)
        if (!scene_.is_near({lights.tx[k], lights.ty[k], lights.tz[k]})) return false;
    return true;
}

/// Sorts the eye points of the tile, once.
void ShaftOracle::prepare(const EyeBlock& eyes) {
    if (is_sorted(eyes)) return;
    order_ = packet_order(eyes.origin);
    eyes_.build(eyes.origin, eyes.normal, order_, scene_.scale());
    is_prepared_ = true;
}

Answer ShaftOracle::block(const BlockAsk& ask, Counters& counters) {
    const EyeBlock& eyes = ask.eyes;
    const FarEnds& lights = ask.lights;
    const BitMatrix& wanted = ask.wanted;
    // Directions have no point in which the planes of a shaft meet
    if (is_direction(lights.semantic)) return exact(exact_->block(ask, counters));
    const uint64_t queries = count_bits(wanted);
    // Sorting and building nodes pays from some queries per eye point on; what is sorted already
    // costs nothing
    const bool is_few = options_.choose && !is_sorted(eyes) && queries < kLeastLightsPerPoint * eyes.size();
    const bool is_sparse =
        options_.choose && queries * kShaftLanes < kLeastQueriesPerPacket * eyes.size() * lights.count;
    // A log names who answered each query, which shafts do not know
    if (queries == 0 || is_few || is_sparse || ask.log || !fits(eyes, lights)) {
        totals_.add({0, queries, {}});
        return exact(exact_->block(ask, counters));
    }
    prepare(eyes);
    gather_rows(wanted, order_, wanted_);
    visible_.reset(wanted.rows(), wanted.columns());
    memory_.counts = {};
    // A few lights show which is cheaper
    const Word trial = options_.choose ? kTrialLights : 0;
    if (trial) answer_word(0, trial, eyes, lights);
    // Decided by counted work, never by time, so every run answers alike
    const bool pays = shafts_pay(memory_.counts) || !trial;
    for (size_t w = 0; pays && w < words_for(lights.count); ++w)
        answer_word(w, w == 0 ? ~trial : ~Word{0}, eyes, lights);
    BitMatrix& visible = new_bits(wanted.rows(), wanted.columns());
    scatter_rows(visible_, order_, visible);
    // Queries count as rays whoever answers them: frames with and without shafts have equal
    // counters
    const uint64_t answered = pays ? queries : queries_in(wanted, trial);
    GroupCounters& group = counters.group(lights.group);
    group.queries += answered;
    group.rays += answered;
    group.occluded += answered - count_bits(visible);
    totals_.add({answered, queries - answered, memory_.counts});
    if (!pays) {
        // What the trial has answered stands; packets answer the rest
        copy_without(wanted, trial, rest_);
        add_bits(*exact_->block({eyes, lights, rest_}, counters).bits, visible);
    }
    return exact({.bits = &visible});
}

/// Answers some of 64 lights.
void ShaftOracle::answer_word(size_t w, Word some, const EyeBlock& eyes, const FarEnds& lights) {
    const ShaftTree& tree = scene_.tree(1, control());
    const AnswerLight answer = shaft_kernel(options_.isa);
    const float scale = scene_.scale();
    columns_.read(wanted_, w, eyes_);
    for (Word rest = columns_.all() & some; rest; rest &= rest - 1) {
        check_cancelled();
        const size_t j = size_t(std::countr_zero(rest)), k = w * kWordBits + j;
        const Vec3 end{lights.tx[k], lights.ty[k], lights.tz[k]}, at = end * scale;
        TileRays rays(caster_, eyes, order_, end);
        // Covers the roundings of shafts, and how far outside of a triangle Embree may hit it
        const float size = std::max({tree.bounds.magnitude(), max_abs(at), eyes_.magnitude()});
        constexpr float kShare = kOffsetUlps * kUlp;
        const ShaftLight light{.tree = tree,
                               .eyes = eyes_,
                               .columns = columns_,
                               .column = j,
                               .light = {at.x, at.y, at.z},
                               .ends = {kShare * std::max(max_abs(at), eyes_.magnitude()), kShare},
                               .slack = 4e-6f * size,
                               .bounds = options_.bounds,
                               .wanted = columns_.wanted(j),
                               .visible = columns_.visible(j)};
        // The measure of `shafts_pay`: packets that ask against those that were traced
        for (size_t p = 0; p < eyes_.packets(); ++p) memory_.counts.asked += light.wanted[p] != 0;
        answer(light, memory_, rays);
    }
    columns_.write(visible_, w);
}

}  // namespace viscache
