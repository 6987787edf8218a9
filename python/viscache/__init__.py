"""Visibility caches for ray tracing: trade shadow rays for accuracy, and measure the trade."""

import copyreg as _copyreg
import sys as _sys
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import NoReturn as _NoReturn

from viscache import (
    aqvc,
    correlation,
    metrics,
    notebook,
    plots,
    report,
    scenes,
    testing,
    vismap,
    vlf,
)
from viscache._core import SceneDescription
from viscache.aqvc.rows import AqvcRows
from viscache.aqvc.table import AqvcTable
from viscache.base import tonemap, workers
from viscache.base.provenance import VERSION
from viscache.calls import Shot
from viscache.frame import Frame
from viscache.metrics import temporal, variance
from viscache.oracles.correct import Correct
from viscache.oracles.points import EyePoints, FarEnds
from viscache.passes import over_time
from viscache.passes.over_time import passes_over_time
from viscache.passes.progressive import Progressive
from viscache.scene import Intersection, Scene, SceneError, Sky, load_scene
from viscache.scene.cameras import Camera, look_at, orthographic
from viscache.scenes.travelling import reduced as _reduced
from viscache.settings import integrators as _integrators
from viscache.settings import rays as _rays
from viscache.settings import visibility as _visibility
from viscache.settings.audit import AuditPixels, AuditQueries
from viscache.settings.integrators import *  # noqa: F403
from viscache.settings.rays import *  # noqa: F403
from viscache.settings.visibility import *  # noqa: F403
from viscache.settings.vpls import Vpls
from viscache.shot import tiles
from viscache.shot.connections import Connections, connections
from viscache.shot.query_record import record_queries
from viscache.shot.render import render
from viscache.shot.thumbnails import thumbnail as _thumbnail
from viscache.shot.voxel_counts import VoxelCounts
from viscache.sweeps import designs
from viscache.sweeps.front import pareto
from viscache.sweeps.sweep import sweep
from viscache.sweeps.tune import tune
from viscache.vismap import (
    MapSettings,
    Relighting,
    VisibilityMapCache,
    cached_ambient_occlusion,
)
from viscache.vlf import aligned_occlusion
from viscache.vlf.field import VisibilityField

__version__ = VERSION

__all__ = [
    "AqvcRows",
    "AqvcTable",
    "AuditPixels",
    "AuditQueries",
    "Camera",
    "Connections",
    "Correct",
    "EyePoints",
    "FarEnds",
    "Frame",
    "Intersection",
    "MapSettings",
    "Progressive",
    "Relighting",
    "Scene",
    "SceneDescription",
    "SceneError",
    "Shot",
    "Sky",
    "VisibilityField",
    "VisibilityMapCache",
    "VoxelCounts",
    "Vpls",
    "__version__",
    "aligned_occlusion",
    "aqvc",
    "cached_ambient_occlusion",
    "connections",
    "correlation",
    "designs",
    "load_scene",
    "look_at",
    "metrics",
    "notebook",
    "orthographic",
    "pareto",
    "passes_over_time",
    "plots",
    "record_queries",
    "render",
    "report",
    "scenes",
    "sweep",
    "temporal",
    "testing",
    "tiles",
    "tune",
    "variance",
    "vismap",
    "vlf",
]
__all__ += _integrators.__all__ + _rays.__all__ + _visibility.__all__

# Public modules in rooms have their names of before, too
for _module in (over_time, temporal, tiles, tonemap, variance, workers):
    _sys.modules[f"viscache.{_module.__name__.rpartition('.')[2]}"] = _module

# Scenes know neither the renderer nor built-in names, so what needs these is set here
Scene._picture = staticmethod(_thumbnail)
_copyreg.pickle(Scene, _reduced)


def __dir__() -> list[str]:
    """The public names, without modules that imports added."""
    return sorted(__all__)


if not _TYPE_CHECKING:

    def __getattr__(name: str) -> _NoReturn:
        """Refuse a name that is not there; experiments are a package of their own."""
        if name in ("bench", "extremes", "figures", "parity"):
            raise ModuleNotFoundError(f"viscache.{name} is viscache_lab.{name} now")
        raise AttributeError(f"module 'viscache' has no attribute {name!r}")
