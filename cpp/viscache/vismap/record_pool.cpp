#include "viscache/vismap/record_pool.h"

namespace viscache {

RecordPool::RecordPool(int m) : m_(m) {
    // Row of a record: [map] [V¹] [V²] [V³, for m ≥ 6] [hierarchy]. One look-up touches one place of memory.
    size_t words = map_words(m);
    for (int level = 1; level <= dilations(m); ++level) {
        dilated_[level - 1] = words;
        words += dilated_words(m, level);
    }
    hierarchy_ = words;
    row_words_ = words + hierarchy_words(m);
}

size_t RecordPool::extra_bytes_per_record() const {
    return (hierarchy_ - map_words(m_)) * sizeof(Word) + sizeof(AmbientRecord);
}

uint32_t RecordPool::add(const RecordHead& head, const Word* bits, const AmbientRecord& ambient) {
    const auto id = uint32_t(size());
    // A new chunk; the old ones stay where they are.
    if (id / kChunk == chunks_.size())
        chunks_.push_back(std::make_unique<BitMatrix>(kChunk, row_words_ * kWordBits));
    heads_.push_back(head);
    ambient_.push_back(ambient);
    Word* to = row(id);
    std::memcpy(to, bits, map_words(m_) * sizeof(Word));
    build_hierarchy(m_, to, to + hierarchy_);
    for (int level = 1; level <= dilations(m_); ++level) dilate(m_, to, level, to + dilated_[level - 1]);
    return id;
}

void RecordPool::keep(const std::vector<uint32_t>& ids) {
    // Ids ascend, so a record never moves to the right of one that still has to move.
    for (uint32_t to = 0; to < ids.size(); ++to) {
        const uint32_t from = ids[to];
        if (from == to) continue;
        heads_[to] = heads_[from];
        ambient_[to] = ambient_[from];
        std::memcpy(row(to), row(from), row_words_ * sizeof(Word));
    }
    heads_.resize(ids.size());
    ambient_.resize(ids.size());
    chunks_.resize((ids.size() + kChunk - 1) / kChunk);
}

}  // namespace viscache
