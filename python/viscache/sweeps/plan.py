"""The frames of a sweep; all settings are checked before the first ray."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from viscache.base.provenance import cpu_model, provenance
from viscache.oracles.correct import in_words
from viscache.scene.cameras import camera_in_words
from viscache.settings import by_name
from viscache.settings.spelling import nearest
from viscache.shot.shot import BareShot
from viscache.sweeps import designs

Over: TypeAlias = "Mapping[str, Any] | Sequence[Mapping[str, Any]]"
RESERVED = ("repeat", "seed", "group", "point", "reference")


@dataclass(frozen=True, kw_only=True, slots=True)
class Point:
    """One row of the table: a setting and a repeat."""

    index: tuple[int, ...]
    values: dict[str, Any]
    repeat: int
    seed: int
    key: str
    paired: str
    converged: str | None


@dataclass(kw_only=True, slots=True)
class Plan:
    """All frames of a sweep, known before the first ray."""

    names: list[str]  # of the columns: last parts of the dotted names
    dims: list[str]
    coords: dict[str, tuple[str, list[Any]]]
    points: list[Point] = field(default_factory=list)
    tasks: dict[str, BareShot] = field(default_factory=dict)
    metrics: list[str] = field(default_factory=list)
    repeats: int = 1
    seed: int = 0

    def order(self) -> list[str]:
        """Keys, each point's references first."""
        keys = (k for p in self.points for k in (p.paired, p.converged, p.key) if k is not None)
        return list(dict.fromkeys(keys))


def make_plan(
    base: BareShot,
    source: Any,
    *,
    over: Over,
    repeats: int,
    converged: Mapping[str, int] | None,
    metrics: list[str],
) -> Plan:
    """The frames of a sweep with checked settings; renders nothing.

    Workers open a `source` that is text, and get the scene of `base` otherwise.
    """
    resolved: dict[str, Any] = {role: base.setting(role) for role in by_name.ROLES}
    owners, dims, coords, combinations = _grid(over, resolved)
    plan = Plan(
        names=[o[1] for o in owners],
        dims=dims,
        coords=coords,
        metrics=metrics,
        repeats=repeats,
        seed=base.seed,
    )

    def add(chosen: Mapping[str, Any], **more: int) -> str:
        """Put a frame on the plan; returns its key."""
        exact = by_name.name_of("visibility", chosen["visibility"]) == "exact"
        shot = base.with_(**chosen, use=None if exact else base.use, **more)
        plan.tasks[shot.key] = shot.opened_by(source) if isinstance(source, str) else shot
        return shot.key

    second = _converged(converged)
    exact = by_name.make("visibility", "exact")
    for index, values in combinations:
        changed: dict[str, Any] = dict(resolved)
        for (role, name), value in zip(owners, values, strict=True):
            changed[role] = by_name.replaced(changed[role], {name: value}, role)
        reference = {**changed, "visibility": exact}
        last = None
        if second:
            whole = _of_all_lights(reference)
            last = add(whole, seed=second[0], spp=second[1])
        for repeat in range(repeats):
            paired = add(reference, seed=base.seed + repeat)
            key = add(changed, seed=base.seed + repeat)
            row = dict(zip(plan.names, values, strict=True))
            plan.points.append(
                Point(
                    index=(*index, repeat),
                    values=row,
                    repeat=repeat,
                    seed=base.seed + repeat,
                    key=key,
                    paired=paired,
                    converged=last,
                )
            )
    return plan


def _of_all_lights(chosen: Mapping[str, Any]) -> Mapping[str, Any]:
    """The settings without picks, which would only add noise to a converged reference."""
    if not getattr(chosen["integrator"], "pick", 0):
        return chosen
    whole = by_name.replaced(chosen["integrator"], {"pick": 0}, "integrator")
    return {**chosen, "integrator": whole}


def _grid(
    over: Over, resolved: Mapping[str, Any]
) -> tuple[
    list[tuple[by_name.Role, str]],
    list[str],
    dict[str, tuple[str, list[Any]]],
    list[tuple[tuple[int, ...], tuple[Any, ...]]],
]:
    """(owners of the parameters, dims, coords, [(index, values)]) of a grid or list of points."""
    if not over:
        raise ValueError("over must name at least one parameter, got nothing")
    if isinstance(over, Mapping):
        columns = {
            name: _values(name, designs.values_of(name, values)) for name, values in over.items()
        }
    else:
        names = list(over[0])
        for number, point in enumerate(over):
            if set(point) != set(names):
                raise ValueError(
                    f"points must all have the names {names}, got {list(point)} at point {number}"
                )
        columns = {name: [point[name] for point in over] for name in names}
    kinds: dict[by_name.Role, Any] = {role: resolved[role] for role in by_name.ROLES}
    owners = [by_name.owner(name, kinds, bare=("visibility",)) for name in columns]
    short = [name for _, name in owners]
    for name in short:
        if short.count(name) > 1 or name in RESERVED:
            raise ValueError(f"over must have distinct last names, none of {RESERVED}, got {short}")
    lists = list(columns.values())
    if isinstance(over, Mapping):
        indices: list[tuple[int, ...]] = [()]
        for values in lists:
            indices = [(*i, j) for i in indices for j in range(len(values))]
        picked = [tuple(v[i] for v, i in zip(lists, index, strict=True)) for index in indices]
        coords = {name: (name, values) for name, values in zip(short, lists, strict=True)}
        return owners, short, coords, list(zip(indices, picked, strict=True))
    rows: list[tuple[tuple[int, ...], tuple[Any, ...]]] = [
        ((i,), values) for i, values in enumerate(zip(*lists, strict=True))
    ]
    coords = {name: ("point", values) for name, values in zip(short, lists, strict=True)}
    return owners, ["point"], coords, rows


def _values(name: str, values: Any) -> list[Any]:
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise ValueError(f"over {name} must be a list of values, got {values!r}")
    kept = [v.item() if hasattr(v, "item") else v for v in values]
    if not kept or len({repr(v) for v in kept}) < len(kept):
        raise ValueError(f"over {name} must have at least one value and none twice, got {kept}")
    return kept


def definition_of(
    plan: Plan, base: BareShot, source: Any, converged: Mapping[str, int] | None
) -> dict[str, Any]:
    """The description of a sweep in its store, for tables and reports."""
    scene = base.opened
    return {
        "scene": _scene_text(scene, source),
        "scene_hash": str(scene.content_hash),
        "triangles": int(getattr(scene, "triangles", 0)),
        **{r: by_name.described(r, base.setting(r)) for r in by_name.ROLES},
        "size": list(base.size or ()),
        "spp": base.spp,
        "use": in_words(base.use),
        "camera": camera_in_words(base.camera),
        "seed": plan.seed,
        "repeats": plan.repeats,
        "converged": dict(converged) if converged else None,
        "metrics": plan.metrics,
        "names": plan.names,
        "dims": plan.dims,
        "coords": {name: [dim, values] for name, (dim, values) in plan.coords.items()},
        "points": [dataclasses.asdict(point) for point in plan.points],
        "provenance": provenance(base.threads),
        "cpu": cpu_model(),
    }


def positive(name: str, value: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{name} must be an integer >= 1, got {value!r}")
    return value


def _converged(converged: Mapping[str, int] | None) -> tuple[int, int] | None:
    """(seed, spp) of the converged reference."""
    if converged is None:
        return None
    for name in converged:
        if name not in ("spp", "seed"):
            raise ValueError(f"converged has no {name!r}{nearest(name, ('spp', 'seed'))}")
    if "spp" not in converged:
        raise ValueError(f"converged must name spp, got {dict(converged)}")
    return (int(converged.get("seed", 1000)), positive("converged.spp", converged["spp"]))


def _scene_text(scene: Any, source: Any) -> str:
    if isinstance(source, str):
        return source
    return str(getattr(scene, "spec", None) or getattr(scene, "name", "scene"))
