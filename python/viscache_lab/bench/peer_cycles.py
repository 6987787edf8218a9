"""Blender's Cycles in a separate process (see `peers`): frames under a sky, direct light only."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_protocol import serve


def main() -> None:
    """Answer with frames; the scene is built at the first."""
    # Blender prints its progress: our lines keep the output, it gets none
    sys.stdout = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    bpy: Any = importlib.import_module("bpy")
    picture = CyclesPicture(bpy, Path(sys.argv[1]))
    threads = len(os.sched_getaffinity(0))
    serve({"version": bpy.app.version_string, "threads": threads}, {"sky": picture.sky})


class CyclesPicture:
    """The scene of a folder with y up, turned to Blender's z up."""

    def __init__(self, bpy: Any, folder: Path) -> None:
        self._bpy, self._folder = bpy, folder
        self._sky: Any = None

    def sky(self, given: Mapping[str, Any], fields: Mapping[str, Any]) -> dict[str, Any]:
        """Direct light of `sky` (H, W, 3). Its samples have one of the light and surface each."""
        bpy = self._bpy
        if given["sky"] is not self._sky:
            self._build(given, fields)
            self._sky = given["sky"]
        scene = bpy.context.scene
        scene.cycles.samples = int(fields["spp"]) * int(fields["samples"])
        scene.cycles.seed = int(fields["seed"])
        scene.render.filepath = str(self._folder / "frame.exr")
        bpy.ops.render.render(write_still=True)
        loaded = bpy.data.images.load(scene.render.filepath, check_existing=False)
        side = int(fields["side"])
        pixels = np.empty(side * side * 4, np.float32)
        loaded.pixels.foreach_get(pixels)
        bpy.data.images.remove(loaded)
        # Rows from the bottom up
        image = pixels.reshape(side, side, 4)[::-1, :, :3].astype(np.float64)
        return {"image": image.mean(axis=2)}

    def _build(self, given: Mapping[str, Any], fields: Mapping[str, Any]) -> None:
        bpy = self._bpy
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        self._settings(scene, int(fields["side"]))
        with np.load(self._folder / "scene.npz") as file:
            mesh = bpy.data.meshes.new("all")
            mesh.from_pydata(_turned(file["vertices"]).tolist(), [], file["triangles"].tolist())
        mesh.materials.append(self._grey(float(fields["albedo"])))
        scene.collection.objects.link(bpy.data.objects.new("all", mesh))
        scene.world = self._world(np.asarray(given["sky"], np.float32))
        lens = bpy.data.cameras.new("camera")
        lens.sensor_fit, lens.angle = "HORIZONTAL", float(fields["fov_rad"])
        lens.clip_start, lens.clip_end = 1e-4, 1e4
        camera = bpy.data.objects.new("camera", lens)
        origin, forward, right, up = _turned(np.asarray(given["camera"], np.float64))
        matrix = np.eye(4)
        matrix[:3] = np.stack([right, up, -forward, origin], axis=1)
        # Blender takes columns here
        camera.matrix_world = matrix.T.tolist()
        scene.collection.objects.link(camera)
        scene.camera = camera

    @staticmethod
    def _settings(scene: Any, side: int) -> None:
        scene.render.engine = "CYCLES"
        scene.render.resolution_x = scene.render.resolution_y = side
        scene.render.resolution_percentage = 100
        scene.render.use_persistent_data = True
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        cycles = scene.cycles
        cycles.device, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", False, False
        cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        cycles.max_bounces = cycles.diffuse_bounces = 0

    def _grey(self, albedo: float) -> Any:
        material = self._bpy.data.materials.new("grey")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = (albedo, albedo, albedo, 1.0)
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
        return material

    def _world(self, sky: Any) -> Any:
        bpy = self._bpy
        rows, columns = sky.shape[:2]
        image = bpy.data.images.new("sky", columns, rows, float_buffer=True, is_data=True)
        pixels = np.ones((rows, columns, 4), np.float32)
        # Its meridian is a quarter turn from ours
        pixels[..., :3] = np.roll(sky, columns // 4, axis=1)[::-1]
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        world = bpy.data.worlds.new("sky")
        world.use_nodes = True
        nodes, links = world.node_tree.nodes, world.node_tree.links
        nodes.clear()
        texture = nodes.new("ShaderNodeTexEnvironment")
        texture.image, texture.interpolation = image, "Linear"
        background = nodes.new("ShaderNodeBackground")
        links.new(texture.outputs["Color"], background.inputs["Color"])
        output = nodes.new("ShaderNodeOutputWorld")
        links.new(background.outputs[0], output.inputs["Surface"])
        return world


def _turned(rows: Any) -> Any:
    """(x, y, z) with y up as (x, -z, y) with z up."""
    return np.stack([rows[:, 0], -rows[:, 2], rows[:, 1]], axis=1)


if __name__ == "__main__":
    main()
