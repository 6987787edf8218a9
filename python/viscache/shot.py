"""What a picture shows, and the key by which its passes, parts and stored frames are known.

A key is made of values alone: of the numbers of a camera, the bytes of a sky, the code of an
oracle. So it is the same in every process and folder, and it is another one where the picture would
be another one. Threads and names of files have no part in it.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import FunctionType
from typing import Any, ClassVar

import numpy as np

from viscache import _core, sources
from viscache.array_digests import array_in_words, bytes_digest, content_key
from viscache.oracles.code_digest import code_digest
from viscache.oracles.written import is_written
from viscache.provenance import VERSION
from viscache.render import frame_settings, use_in_words
from viscache.scene import Sky
from viscache.scene.cameras import camera_in_words, find_camera, frame_size
from viscache.scene.environments import environment_pixels, existing_file
from viscache.settings import by_name
from viscache.settings.not_given import NotGiven
from viscache.sharing import MadeOnce
from viscache.vismap.cache import VisibilityMapCache
from viscache.vismap.pass_maps import records_digest

__all__ = ["Shot", "environment_in_words", "require_same"]


#: Settings that `viscache.render` takes where none is given.
_DEFAULTS: dict[by_name.Role, str] = {"visibility": "exact", "rays": "embree"}


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """What to render.

    Parameters
    ----------
    scene, integrator, visibility, rays, use, size, spp, seed, threads, camera, env
        As `viscache.render` takes them.
    """

    scene: Any
    integrator: Any
    visibility: Any = None
    rays: Any = None
    use: Any = None
    size: tuple[int, int] | None = None
    spp: int = 1
    seed: int = 0
    threads: int | None = None
    camera: Any = None
    env: Any = None

    _made: ClassVar[MadeOnce]  # of each shot, but no argument

    def __post_init__(self) -> None:
        for role in by_name.ROLES:
            chosen = by_name.setting(role, getattr(self, role), _DEFAULTS.get(role))
            object.__setattr__(self, role, chosen)
        object.__setattr__(self, "_made", MadeOnce())

    @property
    def parts(self) -> dict[str, Any]:
        """What decides the bytes of the picture, by name; JSON-able.

        Raises
        ------
        ValueError
            A part is out of range, or is not known by its value.
        """
        return self._made.get("parts", lambda: self._parts_of(_PARTS) | {"version": VERSION})

    @property
    def key(self) -> str:
        """Hex digest of `parts`."""
        return content_key(self.parts)

    def with_(self, **changes: Any) -> Shot:
        """Another shot; parts that stay the same are not made again."""
        changes = {n: value for n, value in changes.items() if value is not getattr(self, n)}
        other = dataclasses.replace(self, **changes)
        changed = [name for name, (_, of) in _PARTS.items() if not of.isdisjoint(changes)]
        return other._known_by(self.parts | other._parts_of(changed))

    def opened_by(self, spec: str) -> Shot:
        """The same shot, whose scene workers open by its spec."""
        return dataclasses.replace(self, scene=spec)._known_by(self.parts)

    def _parts_of(self, names: Iterable[str]) -> dict[str, Any]:
        return {name: _PARTS[name][0](self) for name in names}

    def _known_by(self, parts: dict[str, Any]) -> Shot:
        self._made.get("parts", lambda: parts)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        given = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return _sent, (given, self.parts)


def _sent(given: dict[str, Any], parts: dict[str, Any]) -> Shot:
    return Shot(**given)._known_by(parts)


def require_same(wanted: Any, given: Any, where: str, name: str = "") -> None:
    """Check that parts are the same; ValueError names the first that differs, and both values."""
    if isinstance(wanted, Mapping) and isinstance(given, Mapping):
        for inner in [*wanted, *(n for n in given if n not in wanted)]:
            below = f"{name}.{inner}" if name else str(inner)
            require_same(wanted.get(inner), given.get(inner), where, below)
    elif content_key({"": wanted}) != content_key({"": given}):
        raise ValueError(f"{name or 'the picture'} must be {wanted!r} {where}, got {given!r}")


def _camera(shot: Shot) -> Any:
    numbers = camera_in_words(find_camera(_scene(shot), shot.camera))
    return {name: value for name, value in numbers.items() if name != "name"}


def _size(shot: Shot) -> list[int]:
    size = frame_size(shot.size, find_camera(_scene(shot), shot.camera))
    frame = frame_settings(size, shot.spp, shot.seed, shot.threads)
    return [frame.width, frame.height]


def _scene(shot: Shot) -> Any:
    known = not isinstance(shot.scene, str | os.PathLike)
    return shot.scene if known else sources.opened(shot.scene)


def _setting(role: by_name.Role) -> Callable[[Shot], dict[str, Any]]:
    """What makes the part of a setting: its name and its parameters."""

    def part(shot: Shot) -> dict[str, Any]:
        chosen = getattr(shot, role)
        if is_written(chosen) or not dataclasses.is_dataclass(chosen):
            return _own(chosen, role)
        known = by_name.parameters(chosen)
        if hasattr(chosen, "resolved"):  # what the preset's defaults are in this version
            known |= {"resolved": by_name.plain(chosen.resolved())}
        given = {n: v for n, v in known.items() if not isinstance(v, NotGiven)}
        return {"name": by_name.name_of(role, chosen), **by_value(given, role)}

    return part


#: Each part with the fields of a shot that decide it.
_PARTS: dict[str, tuple[Callable[[Shot], Any], frozenset[str]]] = {
    "scene": (lambda shot: str(_scene(shot).content_hash), frozenset({"scene"})),
    "integrator": (_setting("integrator"), frozenset({"integrator"})),
    "visibility": (_setting("visibility"), frozenset({"visibility"})),
    "rays": (_setting("rays"), frozenset({"rays"})),
    "use": (
        lambda shot: use_in_words(shot.use, shot.visibility),
        frozenset({"use", "visibility"}),
    ),
    "size": (_size, frozenset({"scene", "camera", "size"})),
    "spp": (lambda shot: int(shot.spp), frozenset({"spp"})),
    "seed": (lambda shot: int(shot.seed), frozenset({"seed"})),
    "camera": (_camera, frozenset({"scene", "camera"})),
    "env": (lambda shot: environment_in_words(shot.env), frozenset({"env"})),
}


def environment_in_words(env: Any) -> Any:
    """An environment by its content: the file's bytes, the pixels, or the numbers.

    Raises
    ------
    SceneError
        There is no such file.
    ValueError
        It is no environment.
    """
    if env is None or isinstance(env, Sky):
        return by_value(env, "env")
    if isinstance(env, str | os.PathLike):
        return f"file sha256 {bytes_digest(existing_file(env).read_bytes())}"
    pixels = environment_pixels(env)
    return array_in_words(pixels) if pixels.ndim == 3 else np.resize(pixels, 3).tolist()


def by_value(value: Any, what: str, within: tuple[int, ...] = ()) -> Any:
    """A value in words, JSON-able and the same in every process.

    Raises
    ------
    ValueError
        An object says nothing of its value, or contains itself.
    """
    if isinstance(value, np.generic):
        value = value.item()
    elif isinstance(value, np.ndarray) and value.dtype.hasobject:
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    try:
        words = _known(value)
    except Exception as error:
        raise ValueError(_unknown(value, what)) from error
    if words is not None:
        return words
    if id(value) in within:
        raise ValueError(_unknown(value, what))
    within = (*within, id(value))
    if isinstance(value, Mapping):
        named = {n if isinstance(n, str) else repr(by_value(n, what, within)): n for n in value}
        return {n: by_value(value[key], f"{what}.{n}", within) for n, key in named.items()}
    if isinstance(value, list | tuple):
        return [by_value(v, what, within) for v in value]
    if isinstance(value, set | frozenset):
        return sorted((by_value(v, what, within) for v in value), key=repr)
    if dataclasses.is_dataclass(value) and type(value).__module__.startswith("viscache."):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return {"name": type(value).__name__, **by_value(fields, what, within)}
    return by_value(_copied(value, what), what, within)


def _copied(value: Any, what: str) -> Any:
    """How an object would be copied: its class and its state."""
    try:
        made = value.__reduce_ex__(4)
    except Exception as error:
        raise ValueError(_unknown(value, what)) from error
    if isinstance(made, str):
        return made
    return [list(part) if hasattr(part, "__next__") else part for part in made]


def _known(value: Any) -> Any:
    """Objects whose content has a short name, else None."""
    if isinstance(value, type | FunctionType):
        return f"{value.__qualname__} {code_digest(value, warns=False)}"
    if isinstance(value, VisibilityMapCache):
        return f"maps sha256 {records_digest(value)}"
    if isinstance(value, _core.Camera):
        return camera_in_words(value)
    if isinstance(value, bytes | bytearray):
        return f"bytes sha256 {bytes_digest(value)}"
    if isinstance(value, Path):
        return str(value)
    own = getattr(value, "content_hash", None)
    if isinstance(own, str):
        return f"{type(value).__name__} {own}"
    if hasattr(value, "__array__"):
        array = np.asarray(value)
        return None if array.dtype.hasobject else array_in_words(array)
    return None


def _own(chosen: Any, role: str) -> dict[str, Any]:
    """A setting that is not viscache's: its code and what its attributes say."""
    cls = type(chosen)
    named = {"name": cls.__qualname__, "code": code_digest(cls)}
    if isinstance(getattr(chosen, "content_hash", None), str):
        return named | {"content_hash": chosen.content_hash}
    fields = dataclasses.fields(chosen) if dataclasses.is_dataclass(chosen) else ()
    values = {f.name: getattr(chosen, f.name) for f in fields} | getattr(chosen, "__dict__", {})
    if not values:  # its slots
        values = {"state": _copied(chosen, role)[2:]}
    return {**named, **by_value(values, role)}


def _unknown(value: Any, what: str) -> str:
    return (
        f"{what} must be known by its value, as pictures are told apart by it, got"
        f" {type(value).__module__}.{type(value).__qualname__}; an attribute content_hash (text)"
        " of it, or of its oracle, can say what it is"
    )
