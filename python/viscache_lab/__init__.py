"""Experiments with viscache: the papers' figures, benches, checks of extremes, parity with Mitsuba.

It imports what viscache offers to everybody; viscache imports nothing of it. Its commands are entry
points of the group `viscache.commands`.
"""
