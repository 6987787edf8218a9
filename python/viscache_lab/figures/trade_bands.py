"""Bands of the figure `trade`, written before any full run.

They are the goals of a trial with a prototype ("expected: a prototype …"): 512² tiles of 128²,
1024 virtual lights that stay the same, C_E 10, ten passes with independent eye samples. `viscache
bench progressive` missed most of its goals since (docs/performance/progressive.md): the passes of
viscache share one sequence per pixel, which makes exact passes hard to beat. The goals stand here
all the same. A *gain* is squared error · CPU seconds of the one over that of the other.
"""

from __future__ import annotations

import math

from viscache_lab.experiment import Band

#: Corrected passes over exact ones by packets, nMSE.
GAIN = {
    "room": Band(7, math.inf, "expected: a prototype measured 8.4 to 9.3"),
    "apartment": Band(7, math.inf, "expected: a prototype measured 8.1 to 8.3"),
    "conference": Band(7, math.inf, "expected: a prototype measured 7.3"),
    "sponza-dabrovic": Band(6, math.inf, "expected: a prototype measured 5.9 to 6.3"),
    "living-room": Band(4, math.inf, "expected: a prototype measured 4.2 to 4.4"),
}

#: The same by squared errors relative to each pixel.
RELATIVE_GAIN = {
    "room": Band(5, math.inf, "expected: a prototype measured 6.8 to 6.9"),
    "apartment": Band(5, math.inf, "expected: a prototype measured 4.4 to 5.1"),
    "conference": Band(5, math.inf, "expected: a prototype measured 5.6 to 6.1"),
    "sponza-dabrovic": Band(6, math.inf, "expected: a prototype measured 5.8 to 6.3"),
    "living-room": Band(1.1, math.inf, "expected: a prototype measured 1.1 to 1.3"),
}

#: Corrected passes over those of `vc.Exact()`, in every scene, nMSE.
NEVER_WORSE = Band(1, math.inf, "expected: correction falls back to exact rays where it loses")

#: Corrected passes over 16 picks, nMSE.
OVER_PICKS = Band(1.3, math.inf, "expected: a prototype measured 1.3 to 2.5 where lights stay")
#: Scenes of that band.
ROOMS = ("room", "apartment", "conference")

#: nMSE of biased passes over that of corrected ones, after the last pass, in `ROOMS`.
STALLS = Band(1, math.inf, "expected: the bias stays, the noise of corrections does not")

#: |t| of the energy of passes against exact passes of the same samples.
UNBIASED = Band(0, 4, "expected: no bias; 15 degrees of freedom, two rows a scene")
