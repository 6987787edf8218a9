"""Scenes, their cameras and environments."""

from viscache.scene.cameras import Camera, look_at
from viscache.scene.load import load_scene
from viscache.scene.scene import Env, Intersection, Scene, SceneError
from viscache.scene.sky import Sky

__all__ = ["Camera", "Env", "Intersection", "Scene", "SceneError", "Sky", "load_scene", "look_at"]
