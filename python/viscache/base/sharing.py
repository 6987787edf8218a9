"""Objects that several threads share: what is made once, whose turn it is, what is not copied."""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Callable
from typing import Any, ClassVar, NoReturn, TypeVar, cast

T = TypeVar("T")

_NOTHING = object()
#: Everything with a lock, which a forked child must not find held by a thread that it lacks.
_LOCKED: weakref.WeakSet[MadeOnce | Turn] = weakref.WeakSet()


class MadeOnce:
    """Keeps what is made when it is first asked for: one object for all threads.

    A thread that asks for what another one makes waits for it. Nothing is kept where making fails.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()  # again: what is made may ask for something else
        self._made: dict[Any, Any] = {}
        _LOCKED.add(self)

    def get(self, key: Any, make: Callable[[], T]) -> T:
        """The object of this key, which is hashable, made if there is none."""
        made: Any = self._made.get(key, _NOTHING)
        if made is _NOTHING:
            with self._lock:
                made = self._made.get(key, _NOTHING)
                if made is _NOTHING:
                    self._make_room()
                    made = self._made.setdefault(key, make())
        return cast("T", made)

    def __contains__(self, key: Any) -> bool:
        return key in self._made

    def _make_room(self) -> None:
        """Called before something is made."""

    def _forked(self) -> None:
        self._lock = threading.RLock()


class Newest(MadeOnce):
    """Keeps the newest object, so that a worker makes it once and not once per task."""

    def _make_room(self) -> None:
        self._made.clear()


class Turn:
    """Lets one call at a time use an object: `with turn:`. `name` is the object's, for errors.

    Threads get their turns in the order in which they come, so that one with many calls does not
    keep out the others. A forked child refuses what another thread was using at that moment: its
    state is unknown, and nobody would ever give it back. Without `waits`, a call is refused while
    another one has the turn. `again` lets in calls within a call of the same thread, from callbacks
    and handlers of signals, which are refused otherwise.
    """

    def __init__(self, name: str, *, waits: bool = True, again: bool = False) -> None:
        self._name, self._waits, self._again = name, waits, again
        # The next thread waits inside the door, so that the last one cannot overtake it. Both may
        # be taken again, as a handler of a signal may come between any two steps.
        self._door, self._lock = threading.RLock(), threading.RLock()
        self._owner: int | None = None
        self._depth = 0
        self._lost = False
        _LOCKED.add(self)

    def __enter__(self) -> None:
        me = threading.get_ident()
        if self._lost:
            raise ValueError(
                f"{self._name} must not be in use by another thread when the process forks: "
                "use it before or after, or start processes by spawn"
            )
        if self._owner == me:
            if not self._again:
                self._refuse()
        elif self._waits:
            with self._door:
                self._lock.acquire()
        elif not self._lock.acquire(blocking=False):
            self._refuse()
        self._owner = me
        self._depth += 1

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._owner = None
            self._lock.release()

    def _refuse(self) -> NoReturn:
        raise ValueError(f"{self._name} must not be in use by another call")

    def _forked(self) -> None:
        self._door = threading.RLock()
        if self._owner is None:
            self._lock = threading.RLock()
        else:
            self._lost = self._owner != threading.get_ident()


class Uncopied:
    """An object whose state is there once: a copy would share it, or tear it."""

    #: What to do instead.
    _instead: ClassVar[str] = "make another one"

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        raise TypeError(f"{type(self).__name__} must not be copied or pickled: {self._instead}")


def _forked() -> None:
    for locked in _LOCKED:
        locked._forked()


os.register_at_fork(after_in_child=_forked)
