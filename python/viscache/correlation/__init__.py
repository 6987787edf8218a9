"""Correlation statistics of visibility: Section 4 of the visibility-map paper."""
