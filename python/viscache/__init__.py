"""Visibility caches for ray tracing: trade shadow rays for accuracy, and measure the trade."""

from importlib import import_module as _import_module
from typing import Any as _Any

from viscache._core import SceneDescription  # noqa: F401 -- where the core cannot be loaded, this says so
from viscache.base.given import GIVEN as _GIVEN

#: The public names by module. A module is loaded when one of its names is first used, so that
#: `import viscache` stays quick; `__init__.pyi` has them for type checkers.
_NAMES = {
    "aqvc.rows": "AqvcRows",
    "aqvc.table": "AqvcTable",
    "base.provenance": "__version__",
    "calls": "Shot",
    "frame": "Frame",
    "oracles.correct": "Correct",
    "oracles.points": "EyePoints FarEnds",
    "passes.over_time": "passes_over_time",
    "passes.progressive": "Progressive",
    "scene": "Intersection Scene SceneError Sky load_scene",
    "scene.cameras": "Camera look_at orthographic",
    "settings.audit": "AuditPixels AuditQueries",
    "settings.integrators": "AmbientOcclusion Bdpt Direct Whitted",
    "settings.rays": "Bsp Embree Vlf",
    "settings.vpls": "Vpls",
    "shot.connections": "Connections connections",
    "shot.query_record": "record_queries",
    "shot.render": "render",
    "shot.voxel_counts": "VoxelCounts",
    "sweeps.front": "pareto",
    "sweeps.sweep": "sweep",
    "sweeps.tune": "tune",
    "vismap": "MapSettings Relighting VisibilityMapCache cached_ambient_occlusion",
    "vlf": "aligned_occlusion",
    "vlf.field": "VisibilityField",
}
#: Its `__all__` lists the other names: a new visibility method is added there only.
_METHODS = "viscache.settings.visibility"
#: Modules that are names themselves, and those that `dir` leaves out.
_MODULES = (
    "aqvc correlation metrics notebook plots report scenes testing vismap vlf"
    " metrics.temporal metrics.variance shot.tiles sweeps.designs"
)
_FURTHER = "base.tonemap base.workers passes.over_time"

_WHERE = {name: module for module, names in _NAMES.items() for name in names.split()}
_PATHS = {path.rpartition(".")[2]: path for path in f"{_MODULES} {_FURTHER}".split()}


def __dir__() -> list[str]:
    """The public names, without modules that imports added."""
    further = {path.rpartition(".")[2] for path in _FURTHER.split()}
    methods = _import_module(_METHODS).__all__
    return sorted({"SceneDescription", *_WHERE, *_PATHS, *methods} - further)


def __getattr__(name: str) -> _Any:
    """Load what has the name; experiments are a package of their own."""
    if name in ("bench", "extremes", "figures", "parity"):
        raise ModuleNotFoundError(f"viscache.{name} is viscache_lab.{name} now")
    if name in _PATHS:
        found = _import_module(f"viscache.{_PATHS[name]}")
    elif name in _WHERE:
        module = _import_module(f"viscache.{_WHERE[name]}")
        found = getattr(module, "VERSION" if name == "__version__" else name)
    elif name == "__all__":
        found = __dir__()
    elif name in _import_module(_METHODS).__all__:
        found = getattr(_import_module(_METHODS), name)
    else:
        raise AttributeError(f"module 'viscache' has no attribute {name!r}")
    return globals().setdefault(name, found)


def _thumbnail(scene: _Any) -> str:
    from viscache.shot.thumbnails import thumbnail

    return thumbnail(scene)


def _reduced(scene: _Any) -> tuple[_Any, ...]:
    from viscache.scenes.travelling import reduced

    return reduced(scene)


_GIVEN |= {"thumbnail": _thumbnail, "reduced": _reduced}
