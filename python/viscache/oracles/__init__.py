"""Visibility caches as modules: arrays of points in, bits out; oracles written in Python."""
