"""Visibility caches for ray tracing: trade shadow rays for accuracy, and measure the trade."""

__version__ = "0.1.0"

__all__ = ["__version__"]
