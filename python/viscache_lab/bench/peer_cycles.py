"""Blender's Cycles in a separate process (see `peers`): frames under a sky, direct light only."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

from viscache_lab.bench.peer_protocol import Fields, Pictures, from_below, quiet, serve, z_up


def main() -> None:
    """Answer with frames; the scene is built at the first."""
    quiet(1)  # Blender prints its progress
    bpy: Any = importlib.import_module("bpy")
    picture = CyclesPicture(bpy, Path(sys.argv[1]))
    serve({"version": bpy.app.version_string}, {"sky": picture.sky})


class CyclesPicture(Pictures):
    """The scene of a folder, turned to Blender's z up."""

    def __init__(self, bpy: Any, folder: Path) -> None:
        super().__init__(folder)
        self._bpy = bpy

    def sky(self, given: Fields, fields: Fields) -> dict[str, Any]:
        """Direct light of `sky` (H, W, 3). Its samples have one of the light and surface each."""
        bpy, scene = self._bpy, self.scene(given, fields)
        scene.cycles.samples = int(fields["spp"]) * int(fields["samples"])
        scene.cycles.seed = int(fields["seed"])
        scene.render.filepath = str(self.folder / "frame.exr")
        bpy.ops.render.render(write_still=True)
        loaded = bpy.data.images.load(scene.render.filepath, check_existing=False)
        side = int(fields["side"])
        pixels = np.empty(side * side * 4, np.float32)
        loaded.pixels.foreach_get(pixels)
        bpy.data.images.remove(loaded)
        return {"image": from_below(pixels, side)}

    def build(self, given: Fields, fields: Fields) -> Any:
        """The context's scene."""
        bpy = self._bpy
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        self._settings(scene, int(fields["side"]))
        mesh = bpy.data.meshes.new("all")
        mesh.from_pydata(z_up(self.vertices).tolist(), [], self.triangles.tolist())
        mesh.materials.append(self._grey(float(fields["albedo"])))
        scene.collection.objects.link(bpy.data.objects.new("all", mesh))
        scene.world = self._world(np.asarray(given["sky"], np.float32))
        lens = bpy.data.cameras.new("camera")
        lens.sensor_fit, lens.angle = "HORIZONTAL", float(fields["fov_rad"])
        lens.clip_start, lens.clip_end = 1e-4, 1e4
        camera = bpy.data.objects.new("camera", lens)
        origin, forward, right, up = z_up(np.asarray(given["camera"], np.float64))
        matrix = np.eye(4)
        matrix[:3] = np.stack([right, up, -forward, origin], axis=1)
        # Blender takes columns here
        camera.matrix_world = matrix.T.tolist()
        scene.collection.objects.link(camera)
        scene.camera = camera
        return scene

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


if __name__ == "__main__":
    main()
