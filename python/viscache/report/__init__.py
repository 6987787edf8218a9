"""Self-contained HTML reports."""

from viscache.report.costs import Offer, Verdict, verdict
from viscache.report.embed import MOST_FLIP_MAPS
from viscache.report.pair import write_difference
from viscache.report.passes import write_passes
from viscache.report.write import write

__all__ = [
    "MOST_FLIP_MAPS",
    "Offer",
    "Verdict",
    "verdict",
    "write",
    "write_difference",
    "write_passes",
]
