"""viscache: visibility caches for ray tracing. Trade shadow rays for accuracy, and measure the trade."""
