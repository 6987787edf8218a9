#pragma once
// Converts visibility bits from per-axis order to one row per point.
#include "viscache/math/bits.h"
#include "viscache/math/parallel.h"
#include "viscache/vlf/aligned_blocks.h"

namespace viscache {

/// Axes traced before their bits are written to the rows; two bytes are stored per packet and axis.
constexpr size_t kAxesPerWave = 1024;
static_assert(kAxesPerWave % kWordBits == 0);

/// Traces all axes in waves, over ranges of packets: trace(axis, range, worker, lanes) stores the bits of
/// one axis for a range of packets, 16 bits per packet. Bit k of row `order[16·packet + lane]` is then the
/// bit of axis k.
template <class Trace>
void rows_by_axis(size_t axes, size_t packets_at_once, std::span<const uint32_t> order, std::span<Word> rows,
                  int threads, Control& control, Trace trace) {
    const size_t packets = in_lanes(order.size()), row_words = words_for(axes);
    const size_t ranges = (packets + packets_at_once - 1) / packets_at_once;
    // `lanes` has one row per axis and 16 bits per packet. The rows of the result have one bit per axis:
    //
    //     axis 0    [packet 0][packet 1] ...              point a   0 1 2 ... axes
    //     axis 1    [packet 0][packet 1] ...     --->     point b   0 1 2 ...
    //
    // Threads write whole entries of `lanes`, and afterwards whole words of rows: no two of them share a
    // word.
    std::vector<uint16_t> lanes(packets * std::min(axes, kAxesPerWave));
    for (size_t first = 0; first < axes; first += kAxesPerWave) {
        const size_t n = std::min(axes - first, kAxesPerWave), words = words_for(n);
        // Finish all axes of one range before the next range, so that its points stay in the caches
        parallel_for(n * ranges, threads, [&](size_t i, int worker) {
            control.check();
            const size_t k = i % n, from = i / n * packets_at_once;
            const PacketRange range{from, std::min(packets - from, packets_at_once)};
            trace(first + k, range, worker, &lanes[k * packets + from]);
            control.check();
            // Progress counts axes, each one when its last range is done.
            if (i / n + 1 == ranges) ++control.done;
        });
        constexpr size_t kPacketsPerChunk = 256;
        parallel_for((packets + kPacketsPerChunk - 1) / kPacketsPerChunk, threads, [&](size_t chunk, int) {
            const size_t last = std::min(packets, (chunk + 1) * kPacketsPerChunk);
            for (size_t p = chunk * kPacketsPerChunk; p < last; ++p)
                // Transposes 64 axes × 16 points: one word for each point.
                for (size_t w = 0; w < words; ++w) {
                    Word word[kLanes] = {};
                    for (size_t j = 0; j < std::min(kWordBits, n - w * kWordBits); ++j) {
                        const Word bits = lanes[(w * kWordBits + j) * packets + p];
                        for (size_t i = 0; i < kLanes; ++i) word[i] |= (bits >> i & 1) << j;
                    }
                    for (size_t i = 0; i < std::min(kLanes, order.size() - p * kLanes); ++i)
                        rows[order[p * kLanes + i] * row_words + first / kWordBits + w] = word[i];
                }
        });
    }
}

}  // namespace viscache
