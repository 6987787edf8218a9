"""Scenes, their cameras and environments."""

import copyreg

from viscache.base.given import GIVEN
from viscache.scene.cameras import Camera, look_at
from viscache.scene.load import load_scene
from viscache.scene.scene import Env, Intersection, Scene, SceneError
from viscache.scene.sky import Sky

__all__ = ["Camera", "Env", "Intersection", "Scene", "SceneError", "Sky", "load_scene", "look_at"]

# Scenes know neither the renderer nor built-in names
Scene._picture = staticmethod(lambda scene: GIVEN["thumbnail"](scene))
copyreg.pickle(Scene, lambda scene: GIVEN["reduced"](scene))
