"""How much of the light that could arrive is hidden: facts of scenes under environment light."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache._core import sampling
from viscache.cameras import find_camera
from viscache.checks import require
from viscache.scene import Scene
from viscache.tonemap import LUMINANCE

__all__ = ["blocked_share"]

Array = npt.NDArray[np.float64]
LEAVE = 1e-5  # of the scene's size: rays start this far from the surface


def blocked_share(
    scene: Scene,
    *,
    camera: str | int | _core.Camera | None = None,
    size: tuple[int, int] = (64, 48),
    samples: int = 256,
    seed: int = 0,
) -> Array:
    """Share of light-product samples that are occluded, per pixel.

    Directions are drawn from the density ∝ luminance(L)·B over the texels of the environment,
    B = BRDF·cos at their middles: the importance sampling that the visibility-map paper
    starts from.

    Parameters
    ----------
    scene : Scene
        Lit by one environment image and nothing else; flat-shaded meshes, not instanced, of diffuse
        and glossy materials without textures.
    camera : str, int or Camera, optional
        The scene's first by default.
    size : (width, height)
        One ray through the middle of each pixel.
    samples : int >= 1
        Directions per pixel.

    Returns
    -------
    (H, W) float64
        In [0, 1]; NaN where a pixel sees no surface, or one that no light could reach.
    """
    directions, radiance = _environment(scene)
    position, normal, view, material = _first_hits(scene, find_camera(scene, camera), size)
    materials = _core.scene_materials(scene._core)
    rng = np.random.Generator(np.random.PCG64(seed))
    start = position + normal * LEAVE * np.ptp(scene.bounds, axis=0).max()
    share = np.full(size[0] * size[1], np.nan)
    for pixel in np.flatnonzero(material >= 0):
        weight = _reflected(materials[material[pixel]], normal[pixel], view[pixel], directions)
        total = np.cumsum((weight * radiance) @ np.array(LUMINANCE))
        if total[-1] > 0:
            stratified = (np.arange(samples) + rng.random(samples)) / samples
            drawn = directions[np.searchsorted(total, stratified * total[-1], side="right")]
            origins = np.broadcast_to(start[pixel], drawn.shape)
            share[pixel] = scene.occluded(origins, drawn).mean()
    return share.reshape(size[1], size[0])


def _environment(scene: Scene) -> tuple[Array, Array]:
    """Middles (T, 3) of the environment's texels and their radiance (T, 3)."""
    kinds = [light["kind"] for light in scene.lights]
    require(kinds == ["environment"], "scene must be lit by one environment image", kinds)
    pixels = _core.description_of(scene._core).image_pixels(0)
    texels = sampling.EnvironmentMap.from_latlong(pixels).pixels
    middle = (np.arange(len(texels)) + 0.5) / len(texels)
    square = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)
    directions = sampling.equal_area_to_direction(square.astype(np.float32))
    return directions.astype(float), texels.reshape(-1, 3).astype(float)


def _first_hits(
    scene: Scene, camera: _core.Camera, size: tuple[int, int]
) -> tuple[Array, Array, Array, npt.NDArray[np.int64]]:
    """Position, normal turned to the camera and direction to it (N, 3); material, -1 for none."""
    width, height = size
    x = (np.arange(width) + 0.5) / width * 2 - 1
    y = 1 - (np.arange(height) + 0.5) / height * 2
    reach = math.tan(camera.fov_rad / 2)
    across, upwards = (reach, reach * height / width) if camera.fov_is_horizontal else (
        reach * width / height, reach)  # fmt: skip
    ray = (
        np.array(camera.forward)
        + (across * x)[None, :, None] * np.array(camera.right)
        + (upwards * y)[:, None, None] * np.array(camera.up)
    ).reshape(-1, 3)
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    origin = np.array(camera.origin)
    hit = scene.intersect(np.broadcast_to(origin, ray.shape), ray)
    meshes = scene.meshes()
    corners = np.concatenate([m["vertices"][m["triangles"]] for m in meshes]).astype(float)
    owner = np.repeat([m["material"] for m in meshes], [len(m["triangles"]) for m in meshes])
    a, b, c = corners[hit.triangle].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    normal *= -np.sign((normal * ray).sum(1, keepdims=True))
    found = hit.triangle >= 0
    position = origin + ray * np.where(found, hit.t, 0)[:, None]
    return position, normal, -ray, np.where(found, owner[hit.triangle], -1)


def _reflected(material: dict[str, Any], normal: Array, view: Array, towards: Array) -> Array:
    """BRDF · cos (T, 3) of light from the directions `towards` (T, 3)."""
    cosine = towards @ normal
    above = cosine > 0
    unit = tuple(normal.tolist())
    point = sampling.ShadingPoint(
        material["kind"], tuple(view.tolist()), ns=unit, ng=unit, base=material["base_color"],
        specular=material["specular"], roughness=material["roughness"])  # fmt: skip
    out = np.zeros_like(towards)
    out[above] = sampling.eval_bsdf(point, towards[above].astype(np.float32))
    return out * np.maximum(cosine, 0)[:, None]
