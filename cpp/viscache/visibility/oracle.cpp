#include "viscache/visibility/oracle.h"

#include <algorithm>

#include "viscache/visibility/local_samples.h"

namespace viscache {

size_t PairsAsk::size() const { return samples ? samples->size() : queries.size(); }

std::span<const ShadowQuery> PairsAsk::as_queries(std::vector<ShadowQuery>& made) const {
    if (!samples) return queries;
    made.clear();
    made.reserve(samples->size());
    for_each_sample(*samples, [&](uint32_t eye, size_t i) { made.push_back(samples->query(eye, i)); });
    return made;
}

std::span<const float> Answer::corrected_weights(size_t r, std::vector<float>& scratch) const {
    const std::span<const float> given = weights_of(r);
    const std::span<const Correction> changes = corrections_of(r);
    if (changes.empty()) return given;
    Word* const visible = bits->row(r);
    scratch.assign(bits->columns(), 1.f);
    std::copy(given.begin(), given.end(), scratch.begin());
    for (const Correction& c : changes) {
        float& weight = scratch[c.column];
        weight = (get_bit(visible, c.column) ? weight : 0.f) + c.weight;
        weight != 0 ? set_bit(visible, c.column) : clear_bit(visible, c.column);
    }
    return scratch;
}

}  // namespace viscache
