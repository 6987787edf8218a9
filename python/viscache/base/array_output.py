"""Results that convert to arrays: `np.asarray(frame)`, `torch.from_dlpack(frame)`."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy.typing as npt


class ArrayOutput:
    """A result with one main array, which NumPy's and DLPack's protocols return."""

    __slots__ = ()

    @abstractmethod
    def _array(self) -> npt.NDArray[Any]:
        """The array; it is shared, not copied."""

    def __array__(
        self, dtype: npt.DTypeLike | None = None, copy: bool | None = None
    ) -> npt.NDArray[Any]:
        own = self._array()
        made = own if dtype is None else own.astype(dtype, copy=False)
        if copy is False and made is not own:
            raise ValueError(f"copy must not be False for dtype {made.dtype}, got {own.dtype}")
        return made.copy() if copy and made is own else made

    def __dlpack__(self, **asked: Any) -> Any:
        return self._array().__dlpack__(**asked)

    def __dlpack_device__(self) -> tuple[int, int]:
        kind, number = self._array().__dlpack_device__()
        return (int(kind), int(number))
