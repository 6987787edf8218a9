"""Scenes, their cameras and environments."""

from viscache.scene.cameras import look_at
from viscache.scene.load import load_scene
from viscache.scene.scene import Env, Intersection, Scene, SceneError

__all__ = ["Env", "Intersection", "Scene", "SceneError", "load_scene", "look_at"]
