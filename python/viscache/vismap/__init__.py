"""The visibility-map cache (Clarberg, Akenine-Möller 2008)."""

from viscache.vismap.ambient import cached_ambient_occlusion
from viscache.vismap.cache import VisibilityMapCache
from viscache.vismap.estimate import VisMaps
from viscache.vismap.records import Lookup, Records, UpdateReport
from viscache.vismap.relighting import Relighting
from viscache.vismap.settings import MapSettings

__all__ = [
    "Lookup",
    "MapSettings",
    "Records",
    "Relighting",
    "UpdateReport",
    "VisMaps",
    "VisibilityMapCache",
    "cached_ambient_occlusion",
]
