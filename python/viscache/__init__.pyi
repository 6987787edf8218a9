"""The names of `viscache`, for type checkers; `__init__.py` loads them when they are used."""

from viscache import aqvc as aqvc
from viscache import correlation as correlation
from viscache import metrics as metrics
from viscache import notebook as notebook
from viscache import plots as plots
from viscache import report as report
from viscache import scenes as scenes
from viscache import testing as testing
from viscache import vismap as vismap
from viscache import vlf as vlf
from viscache._core import SceneDescription as SceneDescription
from viscache.aqvc.rows import AqvcRows as AqvcRows
from viscache.aqvc.table import AqvcTable as AqvcTable
from viscache.base import tonemap as tonemap
from viscache.base import workers as workers
from viscache.calls import Shot as Shot
from viscache.frame import Frame as Frame
from viscache.metrics import temporal as temporal
from viscache.metrics import variance as variance
from viscache.oracles.correct import Correct as Correct
from viscache.oracles.points import EyePoints as EyePoints
from viscache.oracles.points import FarEnds as FarEnds
from viscache.passes import over_time as over_time
from viscache.passes.over_time import passes_over_time as passes_over_time
from viscache.passes.progressive import Progressive as Progressive
from viscache.scene import Intersection as Intersection
from viscache.scene import Scene as Scene
from viscache.scene import SceneError as SceneError
from viscache.scene import Sky as Sky
from viscache.scene import load_scene as load_scene
from viscache.scene.cameras import Camera as Camera
from viscache.scene.cameras import look_at as look_at
from viscache.scene.cameras import orthographic as orthographic
from viscache.settings.audit import AuditPixels as AuditPixels
from viscache.settings.audit import AuditQueries as AuditQueries
from viscache.settings.integrators import AmbientOcclusion as AmbientOcclusion
from viscache.settings.integrators import Bdpt as Bdpt
from viscache.settings.integrators import Direct as Direct
from viscache.settings.integrators import Whitted as Whitted
from viscache.settings.rays import Bsp as Bsp
from viscache.settings.rays import Embree as Embree
from viscache.settings.rays import Vlf as Vlf
from viscache.settings.visibility import *  # noqa: F403 -- what its `__all__` has
from viscache.settings.vpls import Vpls as Vpls
from viscache.shot import tiles as tiles
from viscache.shot.connections import Connections as Connections
from viscache.shot.connections import connections as connections
from viscache.shot.query_record import record_queries as record_queries
from viscache.shot.render import render as render
from viscache.shot.voxel_counts import VoxelCounts as VoxelCounts
from viscache.sweeps import designs as designs
from viscache.sweeps.front import pareto as pareto
from viscache.sweeps.sweep import sweep as sweep
from viscache.sweeps.tune import tune as tune
from viscache.vismap import MapSettings as MapSettings
from viscache.vismap import Relighting as Relighting
from viscache.vismap import VisibilityMapCache as VisibilityMapCache
from viscache.vismap import cached_ambient_occlusion as cached_ambient_occlusion
from viscache.vlf import aligned_occlusion as aligned_occlusion
from viscache.vlf.field import VisibilityField as VisibilityField

__version__: str
__all__: list[str]
