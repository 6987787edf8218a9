"""The visibility-map cache (Clarberg, Akenine-Möller 2008)."""

from viscache.settings.maps import MapSettings
from viscache.settings.vismaps import VisMaps
from viscache.vismap.ambient import cached_ambient_occlusion
from viscache.vismap.cache import VisibilityMapCache
from viscache.vismap.records import Lookup, Records, UpdateReport
from viscache.vismap.relighting import Relighting

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
