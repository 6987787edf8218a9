"""What a worker keeps from one task to the next."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any


class Newest:
    """The newest thing made, so that a worker makes it once and not once per task."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: tuple[Any, Any] | None = None

    def get(self, key: Any, make: Callable[[], Any]) -> Any:
        """What was made for this key last, else what `make` makes now."""
        with self._lock:
            if self._kept is None or self._kept[0] != key:
                self._kept = None  # before the next one takes memory
                self._kept = (key, make())
            return self._kept[1]
