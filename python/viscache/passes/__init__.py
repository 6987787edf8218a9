"""Frames in passes, and their error over time."""
