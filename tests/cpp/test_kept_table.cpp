// aqvc: entries of a kept table.
#include "check.h"
#include "viscache/aqvc/kept_table.h"

namespace viscache::test::kept_table_tests {
namespace {

constexpr uint32_t kSlots = 101;

KeptTable table() { return KeptTable(kSlots * 4, 31, HashScheme::kScheme2); }

/// Runs a frame in which one tile writes these slots with the given digests and bits.
void write(KeptTable& table, std::vector<uint32_t> slots, uint32_t digest, bool visible) {
    std::vector<PackedWrite> writes;
    for (uint32_t slot : slots) writes.push_back(pack_write({slot, digest}, visible));
    Counters counters;
    table.begin_frame();
    table.keep(0, writes);
    table.end_frame(counters);
}

std::vector<KeptEntry> entries(const KeptTable& table) {
    std::vector<KeptEntry> all(table.bits().occupied());
    table.read(all);
    return all;
}

void check_entry(const KeptEntry& entry, KeptEntry expected, const std::string& what) {
    check_equal(entry.slot, expected.slot, what + ": slot");
    check_equal(entry.digest, expected.digest, what + ": digest");
    check_equal(entry.visible, expected.visible, what + ": visible");
    check_equal(entry.current, expected.current, what + ": current");
}

void entries_come_in_slot_order_with_their_bits() {
    KeptTable kept = table();
    check_equal(entries(kept).size(), size_t{0}, "an empty table has no entries");
    write(kept, {77, 3}, 1000, true);
    write(kept, {100}, 9, false);
    const std::vector<KeptEntry> all = entries(kept);
    check_equal(all.size(), size_t{3}, "entries");
    check_entry(all[0], {3, 1000, true, true}, "first");
    check_entry(all[1], {77, 1000, true, true}, "second");
    check_entry(all[2], {100, 9, false, true}, "third");
}

void entries_of_an_epoch_are_those_written_in_it() {
    KeptTable kept = table();
    write(kept, {3, 77}, 1000, true);
    kept.next_epoch();
    for (const KeptEntry& e : entries(kept)) check(!e.current, "a new epoch: nothing is current");
    write(kept, {77, 50}, 20, false);
    const std::vector<KeptEntry> all = entries(kept);
    check_equal(all.size(), size_t{3}, "entries of both epochs");
    check_entry(all[0], {3, 1000, true, false}, "kept");
    check_entry(all[1], {50, 20, false, true}, "new");
    check_entry(all[2], {77, 20, false, true}, "overwritten");
    kept.next_epoch();
    for (const KeptEntry& e : entries(kept)) check(!e.current, "the next epoch: nothing is current");
}

const Suite suite{
    {"kept table: entries come in slot order with their bits", entries_come_in_slot_order_with_their_bits},
    {"kept table: entries of an epoch are those written in it", entries_of_an_epoch_are_those_written_in_it},
};

}  // namespace
}  // namespace viscache::test::kept_table_tests
