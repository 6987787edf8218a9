"""The visibility-map cache (Clarberg, Akenine-Möller 2008)."""

from viscache.vismap.ambient import cached_ambient_occlusion
from viscache.vismap.cache import Lookup, Records, UpdateReport, VisibilityMapCache
from viscache.vismap.estimate import VisMaps
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
