"""Built-in procedural scenes: deterministic, sized by parameters, in metres.

Every function returns a scene; `build("room?triangles=200000&lights=24")` does so from text and
`SCENES` lists them with their parameters. Triangles come from shape, not from subdivided walls:
`coplanar_share` measures it.
"""

from __future__ import annotations

from viscache.scene.coplanar import coplanar_share
from viscache.scenes.apartment import apartment
from viscache.scenes.church import church
from viscache.scenes.classroom import classroom_camera, classroom_like
from viscache.scenes.conference import conference
from viscache.scenes.courtyard import courtyard
from viscache.scenes.dynamics import dynamics
from viscache.scenes.garage import garage
from viscache.scenes.garden import garden
from viscache.scenes.hairball import hairball
from viscache.scenes.mushrooms import mushrooms
from viscache.scenes.registry import SCENES, SceneInfo, build, parse
from viscache.scenes.room import room
from viscache.scenes.simple import (
    bumpy_spheres,
    cornell_box,
    cube_on_plane,
    random_triangles,
    slats,
    slits,
    stairs,
    thin_wall,
    window_room,
)

__all__ = [
    "SCENES",
    "SceneInfo",
    "apartment",
    "build",
    "bumpy_spheres",
    "church",
    "classroom_camera",
    "classroom_like",
    "conference",
    "coplanar_share",
    "cornell_box",
    "courtyard",
    "cube_on_plane",
    "dynamics",
    "garage",
    "garden",
    "hairball",
    "mushrooms",
    "parse",
    "random_triangles",
    "room",
    "slats",
    "slits",
    "stairs",
    "thin_wall",
    "window_room",
]
