"""Self-contained HTML reports."""

from viscache.report.write import write

__all__ = ["write"]
