"""What may come of any input: a finite result, or an error that says what must hold."""

import re
from dataclasses import dataclass
from typing import Literal

Kind = Literal["works", "refused", "wrong", "unclean", "killed", "hangs"]

#: Errors that tell a user of an input that cannot be used; `SceneError` is a ValueError.
CLEAN = (ValueError, TypeError, MemoryError, OSError)
#: Texts of Python itself, about the inside of a function instead of its argument.
INSIDE = re.compile(
    r"object is not (?:iterable|subscriptable|callable)|unsupported operand|has no attribute"
    r"|(?:index|indices) (?:is )?out of (?:range|bounds)|math domain|not supported between"
    r"|NoneType|must be str, not|cannot unpack|not be broadcast|ambiguous|division by zero"
    r"|invalid literal for|could not convert|Invalid part index"
)


class WrongError(Exception):
    """A result that breaks a promise: not finite, negative, out of range."""


@dataclass(frozen=True)
class Outcome:
    """Of one case."""

    kind: Kind
    text: str = ""

    @property
    def allowed(self) -> bool:
        """Whether users may meet it."""
        return self.kind in ("works", "refused")


def of_error(error: BaseException) -> Outcome:
    """A refusal where the error is one of `CLEAN` and its text is about the argument."""
    text = f"{type(error).__name__}: {error}"
    if isinstance(error, WrongError):
        return Outcome("wrong", text)
    if isinstance(error, MemoryError):
        return Outcome("refused", text)
    if not isinstance(error, CLEAN) or len(str(error)) < 8 or INSIDE.search(str(error)):
        return Outcome("unclean", f"{text} [{_place(error)}]")
    return Outcome("refused", text)


def _place(error: BaseException) -> str:
    """The innermost lines of the traceback."""
    places = []
    trace = error.__traceback__
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename.rsplit("/", 1)[-1]
        places.append(f"{file}:{trace.tb_lineno}")
        trace = trace.tb_next
    return " < ".join(places[-4:][::-1])
