"""Grids of settings, rendered, stored and compared."""
