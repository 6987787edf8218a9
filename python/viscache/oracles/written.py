"""Oracles written in Python: classes with a method `block` as visibility settings."""

from __future__ import annotations

import copy
import dataclasses
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.oracles.points import EyePoints, FarEnds, ends_of, eyes_of, pack
from viscache.settings.checks import checked_floats, require
from viscache.settings.source_context import SourceContext

Bits: TypeAlias = npt.NDArray[np.uint64]


@runtime_checkable
class Written(Protocol):
    """A visibility setting of your own: a dataclass with a method `block`.

    Methods
    -------
    block(eyes, lamps, wanted)
        `eyes` : EyePoints of one tile, `lamps` : FarEnds of one light group, `wanted` : (N, M)
        bool, the connections that contribute light. Returns visibility as (N, M) bool or as rows of
        bits (N, ⌈M/64⌉) uint64, or a pair of it and the weights (N, M) of visible connections.
        `eyes.trace(lamps, wanted)` traces rays, and `eyes[rows].trace` those of some eye points.
    pairs(eyes, index, ends), optional
        Samples that belong to one eye point each: connection k joins `eyes[index[k]]` with far end
        k. Returns (K,) bool, or a pair of it and weights (K,). Without this method, rays answer.
    begin_frame(lights), optional
        Called once per frame with the list of its shared FarEnds.
    begin_tile(eyes), optional
        Called before the queries of a tile.

    Every thread has a shallow copy of the object, made after `begin_frame`. So a tile may keep
    values in attributes, but they must not change the answers to later tiles.
    """

    def block(self, eyes: EyePoints, lamps: FarEnds, wanted: npt.NDArray[np.bool_]) -> Any:
        """What is visible."""


def is_written(visibility: Any) -> bool:
    """Whether a visibility setting is an oracle written in Python."""
    return (
        not isinstance(visibility, type)
        and callable(getattr(visibility, "block", None))
        and not hasattr(visibility, "source")
    )


def parameters(visibility: Any) -> dict[str, Any]:
    """Names and values of the fields of a dataclass; nothing of other classes."""
    if not dataclasses.is_dataclass(visibility):
        return {}
    return {f.name: getattr(visibility, f.name) for f in dataclasses.fields(visibility)}


def source(visibility: Any, context: SourceContext) -> _core.OracleSource:
    """The source of one frame's oracles."""
    return _core.PythonSource(context.scene, context.caster, WrittenSource(visibility))


class WrittenSource:
    """One frame of an oracle written in Python, as `bindings/python_oracle.h` calls it."""

    def __init__(self, visibility: Any) -> None:
        self.visibility = copy.copy(visibility)

    def begin_frame(self, lights: list[dict[str, Any]]) -> None:
        """Call `begin_frame` of the oracle, if it has one."""
        begin = getattr(self.visibility, "begin_frame", None)
        if begin is not None:
            begin([ends_of(arrays) for arrays in lights])

    def oracle(self, tracer: _core.PythonTracer) -> WrittenOracle:
        """The oracle of one thread."""
        return WrittenOracle(copy.copy(self.visibility), tracer)


class WrittenOracle:
    """One thread's copy: arrays in and out, answers checked."""

    def __init__(self, visibility: Any, tracer: _core.PythonTracer) -> None:
        self.visibility, self.tracer = visibility, tracer
        self.eyes: EyePoints | None = None

    def begin_tile(self, arrays: dict[str, Any]) -> None:
        """Set the eye points of the next queries."""
        self.eyes = eyes_of(arrays, self._trace)
        begin = getattr(self.visibility, "begin_tile", None)
        if begin is not None:
            begin(self.eyes)

    def block(
        self, ends: dict[str, Any], wanted: npt.NDArray[np.bool_]
    ) -> tuple[Bits, npt.NDArray[np.float32] | None]:
        """All eye points of the tile × one light group."""
        assert self.eyes is not None
        lamps = ends_of(ends)
        seen, weights = _parted(self.visibility.block(self.eyes, lamps, wanted))
        shape = (len(self.eyes), len(lamps))
        return bits_of(
            seen, shape, f"{type(self.visibility).__name__}.block must return"
        ), _weights(weights, shape)

    def pairs(
        self, index: npt.NDArray[np.uint32], ends: dict[str, Any]
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.float32] | None]:
        """Connections that belong to one eye point each."""
        assert self.eyes is not None
        ask = getattr(self.visibility, "pairs", None)
        if ask is None:
            return self.tracer.pairs(self.eyes._arrays(), index, ends), None
        seen, weights = _parted(ask(self.eyes, index, ends_of(ends)))
        seen = np.asarray(seen)
        name = type(self.visibility).__name__
        require(
            seen.dtype == bool and seen.shape == index.shape,
            f"{name}.pairs must return bool of shape {index.shape}",
            f"{seen.dtype} of shape {seen.shape}",
        )
        return seen, _weights(weights, index.shape)

    def _trace(self, eyes: EyePoints, ends: FarEnds, wanted: npt.NDArray[np.bool_] | None) -> Bits:
        return self.tracer.block(eyes._arrays(), ends._arrays(), wanted)


def bits_of(given: Any, shape: tuple[int, int], must: str) -> Bits:
    """Rows of bits of an array of bool, or given ones; errors begin with `must`."""
    array, words = np.asarray(given), (shape[0], -(-shape[1] // 64))
    if array.dtype == bool and array.shape == shape:
        return pack(array)
    require(
        array.dtype == np.uint64 and array.shape == words,
        f"{must} bool of shape {shape} or uint64 of shape {words}",
        f"{array.dtype} of shape {array.shape}",
    )
    return np.ascontiguousarray(array)


def _parted(answer: Any) -> tuple[Any, Any]:
    if isinstance(answer, tuple):
        require(
            len(answer) == 2,
            "an answer must be an array or (array, weights)",
            f"{len(answer)} values",
        )
        return answer
    # What `scene.oracle(...).block` returns serves as well
    if hasattr(answer, "bits") and hasattr(answer, "weights"):
        return answer.bits, answer.weights
    return answer, None


def _weights(weights: Any, shape: tuple[int, ...]) -> npt.NDArray[np.float32] | None:
    if weights is None:
        return None
    rows = checked_floats(weights, "weights")
    require(rows.shape == shape, f"weights must have shape {shape}", rows.shape)
    require(bool(np.isfinite(rows).all()), "weights must be finite", "values that are not")
    return rows
