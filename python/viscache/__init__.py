"""Visibility caches for ray tracing: trade shadow rays for accuracy, and measure the trade."""

import copyreg as _copyreg
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
    temporal,
    testing,
    tiles,
    variance,
    vismap,
    vlf,
)
from viscache._core import SceneDescription
from viscache.aqvc_rows import AqvcRows
from viscache.aqvc_table import AqvcTable
from viscache.calls import Shot
from viscache.connections import Connections, connections
from viscache.frame import Frame
from viscache.oracles.correct import Correct
from viscache.oracles.points import EyePoints, FarEnds
from viscache.over_time import passes_over_time
from viscache.progressive import Progressive
from viscache.provenance import VERSION
from viscache.query_record import record_queries
from viscache.render import render
from viscache.scene import Intersection, Scene, SceneError, Sky, load_scene
from viscache.scene.cameras import Camera, look_at, orthographic
from viscache.settings import integrators as _integrators
from viscache.settings import rays as _rays
from viscache.settings import visibility as _visibility
from viscache.settings.audit import AuditPixels, AuditQueries
from viscache.settings.integrators import *  # noqa: F403
from viscache.settings.rays import *  # noqa: F403
from viscache.settings.visibility import *  # noqa: F403
from viscache.settings.vpls import Vpls
from viscache.sweeps import designs
from viscache.sweeps.front import pareto
from viscache.sweeps.sweep import sweep
from viscache.sweeps.tune import tune
from viscache.thumbnails import thumbnail as _thumbnail
from viscache.travelling import reduced as _reduced
from viscache.vismap import (
    MapSettings,
    Relighting,
    VisibilityMapCache,
    cached_ambient_occlusion,
)
from viscache.vlf import aligned_occlusion
from viscache.vlf.field import VisibilityField
from viscache.voxel_counts import VoxelCounts

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
