"""What to render, once: the arguments of every call that renders, and the key of its picture.

A key is made of values alone: of the numbers of a camera, the bytes of a sky, the code of an
oracle. So it is the same in every process and folder, and it is another one where the picture would
be another one. Threads and names of files have no part in it.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypedDict, TypeVar

from viscache import _core
from viscache.base.array_digests import content_key
from viscache.base.provenance import VERSION
from viscache.base.sharing import MadeOnce, Newest
from viscache.oracles.correct import Correct, use_in_words
from viscache.oracles.written import Written, is_written
from viscache.scene import Env
from viscache.scene.cameras import camera_in_words, find_camera, frame_size
from viscache.scenes import sources
from viscache.settings import by_name
from viscache.settings.checks import checked_threads
from viscache.settings.integrators import Direct, Integrator
from viscache.settings.not_given import NotGiven
from viscache.settings.rays import Rays
from viscache.settings.spelling import keywords_of
from viscache.settings.visibility import Visibility
from viscache.shot.identity import by_value, environment_in_words, object_in_words

if TYPE_CHECKING:
    from typing_extensions import Self

Called = TypeVar("Called", bound=Callable[..., Any])

#: Settings that `viscache.render` takes where none is given.
_DEFAULTS: dict[by_name.Role, str] = {"visibility": "exact", "rays": "embree"}


class ShotArguments(TypedDict, total=False):
    """Keywords of every call that renders; `viscache.Shot` explains them."""

    visibility: Visibility | Written | str | None
    rays: Rays | str | None
    use: Literal["replace", "correct"] | Correct | None
    size: tuple[int, int] | None
    spp: int
    seed: int
    threads: int | None
    camera: str | int | _core.Camera | None
    env: Env | None


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class BareShot:
    """What to render, for calls to take it apart; `viscache.Shot` has the calls as methods."""

    scene: Any
    integrator: Integrator | str | None = None
    _: dataclasses.KW_ONLY
    visibility: Visibility | Written | str | None = None
    rays: Rays | str | None = None
    use: Literal["replace", "correct"] | Correct | None = None
    size: tuple[int, int] | None = None
    spp: int = 1
    seed: int = 0
    threads: int | None = None
    camera: str | int | _core.Camera | None = None
    env: Env | None = None

    _made: ClassVar[MadeOnce]  # of each shot, but no argument

    def __post_init__(self) -> None:
        for role in by_name.ROLES:
            given = getattr(self, role)
            if given is not None:
                object.__setattr__(self, role, by_name.setting(role, given))
        if self.integrator is None:
            object.__setattr__(self, "integrator", Direct())
        object.__setattr__(self, "_made", MadeOnce())

    @property
    def arguments(self) -> dict[str, Any]:
        """What was given, by name."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}

    @property
    def opened(self) -> Any:
        """The scene, read or built when it is first asked for."""
        if not isinstance(self.scene, str | os.PathLike):
            return self.scene
        return self._made.get("opened", lambda: sources.opened(self.scene))

    @property
    def parts(self) -> dict[str, Any]:
        """What decides the bytes of the picture, by name; JSON-able.

        ValueError if a part is out of range, or is not known by its value.
        """
        made = {n: self._made.get((n,), partial(make, self)) for n, (make, _) in _PARTS.items()}
        return made | {"version": VERSION}

    @property
    def key(self) -> str:
        """Hex digest of `parts`."""
        key: str = self._made.get("key", lambda: content_key(self.parts))
        return key

    def with_(self, **changes: Any) -> Self:
        """Another shot, with other arguments."""
        other = dataclasses.replace(self, **changes)
        changed = {n for n, value in changes.items() if value is not getattr(self, n)}
        for name, (_, of) in _PARTS.items():
            if of.isdisjoint(changed):
                other._has((name,), self)
        if "scene" not in changed:
            other._has("opened", self)
        return other

    def opened_by(self, spec: str) -> Self:
        """The same shot, whose scene workers open by its spec."""
        return dataclasses.replace(self, scene=spec)._known_by(self.parts)

    def setting(self, role: by_name.Role) -> Any:
        """What `viscache.render` takes for the integrator, the rays or the visibility."""
        return by_name.setting(role, getattr(self, role), _DEFAULTS.get(role))

    def _has(self, what: Any, other: BareShot) -> None:
        """Take over what another shot has made already."""
        if what in other._made:
            self._made.get(what, lambda: other._made.get(what, dict))

    def _known_by(self, parts: Mapping[str, Any]) -> Self:
        for name in _PARTS:
            self._made.get((name,), partial(parts.__getitem__, name))
        return self

    def __eq__(self, other: object) -> bool:
        return self.key == other.key if isinstance(other, BareShot) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.key)

    def __reduce__(self) -> tuple[Any, ...]:
        return _sent, (type(self), self.arguments, self.parts)

    def __repr__(self) -> str:
        usual = {f.name: f.default for f in dataclasses.fields(self)} | {"integrator": Direct()}
        said = [repr(self.scene)]
        for name, value in self.arguments.items():
            if name != "scene" and not _same(value, usual[name]):
                said.append(repr(value) if name == "integrator" else f"{name}={value!r}")
        return f"Shot({', '.join(said)})"


Kind = TypeVar("Kind", bound=BareShot)


def _sent(kind: type[Kind], given: dict[str, Any], parts: dict[str, Any]) -> Kind:
    return kind(**given)._known_by(parts)


def _same(value: Any, usual: Any) -> bool:
    """Whether a value is the default; arrays are none."""
    return type(value) is type(usual) and bool(value is usual or value == usual)


def of_shot(*without: str, **usual: Any) -> Callable[[Called], Called]:
    """`keywords_of` a shot, all but its scene and integrator."""
    return keywords_of(BareShot, *without, **usual)


def require_same(wanted: Any, given: Any, where: str, name: str = "") -> None:
    """Check that parts are the same; ValueError names the first that differs, and both values."""
    if isinstance(wanted, Mapping) and isinstance(given, Mapping):
        for inner in [*wanted, *(n for n in given if n not in wanted)]:
            below = f"{name}.{inner}" if name else str(inner)
            require_same(wanted.get(inner), given.get(inner), where, below)
    elif content_key({"": wanted}) != content_key({"": given}):
        raise ValueError(f"{name or 'the picture'} must be {wanted!r} {where}, got {given!r}")


_SCENE, _LIT = Newest(), Newest()


def lit_here(shot: BareShot, scene: Any = None) -> BareShot:
    """The shot with its scene under its environment, in this process or in a worker.

    A worker keeps the newest scene. Files must be those from which the shot's parts were made.
    """
    wanted, spec = shot.parts, shot.scene
    if scene is None and isinstance(spec, str | os.PathLike):
        scene = _SCENE.get(spec, lambda: sources.opened(spec))
        if str(scene.content_hash) != wanted["scene"]:
            raise ValueError(
                f"scene {spec} is not the one the work began with (its content differs)"
            )
    elif scene is None:  # it travelled, or is a stand-in
        scene = spec
    if shot.env is None:
        return shot.with_(scene=scene)

    def lit() -> Any:
        env = environment_in_words(shot.env)
        require_same(wanted["env"], env, "as when the work began", "env")
        return scene.with_environment(shot.env, threads=shot.threads)

    known = content_key({name: wanted[name] for name in ("scene", "env")})
    return shot.with_(scene=_LIT.get(known, lit), env=None)


def frame_settings(
    size: tuple[int, int], spp: int, seed: int, threads: int | None
) -> _core.FrameSettings:
    """The C++ settings of a frame, checked."""
    width, height = size
    cores = checked_threads(threads) or len(os.sched_getaffinity(0))
    return _core.FrameSettings(width=width, height=height, spp=spp, seed=seed, threads=cores)


def _camera(shot: BareShot) -> Any:
    numbers = camera_in_words(find_camera(shot.opened, shot.camera))
    return {name: value for name, value in numbers.items() if name != "name"}


def _size(shot: BareShot) -> list[int]:
    size = frame_size(shot.size, find_camera(shot.opened, shot.camera))
    frame = frame_settings(size, shot.spp, shot.seed, shot.threads)
    return [frame.width, frame.height]


def _setting(role: by_name.Role) -> Callable[[BareShot], dict[str, Any]]:
    """What makes the part of a setting: its name and its parameters."""

    def part(shot: BareShot) -> dict[str, Any]:
        chosen = shot.setting(role)
        if is_written(chosen) or not dataclasses.is_dataclass(chosen):
            return object_in_words(chosen, role)
        known = by_name.parameters(chosen)
        if hasattr(chosen, "resolved"):  # what the preset's defaults are in this version
            known |= {"resolved": by_name.plain(chosen.resolved())}
        given = {n: v for n, v in known.items() if not isinstance(v, NotGiven)}
        return {"name": by_name.name_of(role, chosen), **by_value(given, role)}

    return part


#: Each part with the fields of a shot that decide it.
_PARTS: dict[str, tuple[Callable[[BareShot], Any], frozenset[str]]] = {
    "scene": (lambda shot: str(shot.opened.content_hash), frozenset({"scene"})),
    "integrator": (_setting("integrator"), frozenset({"integrator"})),
    "visibility": (_setting("visibility"), frozenset({"visibility"})),
    "rays": (_setting("rays"), frozenset({"rays"})),
    "use": (
        lambda shot: use_in_words(shot.use, shot.setting("visibility")),
        frozenset({"use", "visibility"}),
    ),
    "size": (_size, frozenset({"scene", "camera", "size"})),
    "spp": (lambda shot: int(shot.spp), frozenset({"spp"})),
    "seed": (lambda shot: int(shot.seed), frozenset({"seed"})),
    "camera": (_camera, frozenset({"scene", "camera"})),
    "env": (lambda shot: environment_in_words(shot.env), frozenset({"env"})),
}
