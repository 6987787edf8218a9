#pragma once
// How viscache.Correct draws the answers that rays check, one row each.
#include <tuple>

#include "viscache/visibility/parameter_row.h"

namespace viscache {

/// Whether later passes have shares by class of answers.
enum class ShareClasses { kLearned, kSame };

template <>
inline constexpr std::array kNames<ShareClasses>{"learned", "same"};

/// What each is, and its range: kCorrectRows.
struct CorrectSettings {
    double share = 0;
    double certain = 0;
    ShareClasses classes = ShareClasses::kLearned;
    void validate() const;
};

// clang-format off
inline constexpr std::tuple kCorrectRows{
    row("share", &CorrectSettings::share,
        {.low = 0, .high = 1, .above = true, .open = 0, .open_word = nullptr},
        "q, the same for all queries. By default q follows the unoccluded contribution c of a connection with "
        "shared lights to its pixel: 1 where c is `certain` of a reference, and half as much with each "
        "halving of c, down to 1/256. The reference is √(a·(b + m/20)), at most m: a is the light that the "
        "group would bring to the eye point without shadows, b the part of it that the cache sees, and m the "
        "mean of a over the picture. For picked lights it is a. Then few rays remove most of the error: its "
        "square counts c², over the picture or relative to each pixel. The samples of a pixel take turns, "
        "also those of frames that go on from each other: a connection with q = 1/16 is drawn in one of "
        "sixteen. Samples of single eye points and connections of `Bdpt` have q = 0.1. The draw depends on "
        "the frame's seed and first sample, and on the positions of both ends."),
    row("certain", &CorrectSettings::certain, {.low = 0, .above = true, .open = 0},
        "Without a share: where q reaches 1. Half as much draws up to twice as many rays, and halves the "
        "noise of corrections. \"auto\": 1/32. In `vc.Progressive` the first two passes then tell by which "
        "power of two shares have the least error · cost in later ones, by their noise and by counted rays; "
        "or that exact visibility has less, which later passes then have, with a warning. Where it has far "
        "less, the first pass tells."),
    row("classes", &CorrectSettings::classes,
        "Without a share, in `vc.Progressive`: \"learned\": the first two passes tell how often answers of a "
        "class are wrong (p), and in later ones q follows c·√p, in steps of two. Their draws are independent "
        "of those of the first two. \"same\": all classes have the same shares. Single frames have learnt "
        "nothing."),
};
// clang-format on

inline void CorrectSettings::validate() const { check_rows(kCorrectRows, *this); }

}  // namespace viscache
