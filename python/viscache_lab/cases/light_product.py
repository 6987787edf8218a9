"""Measures how much of the environment light is occluded in a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.tonemap import LUMINANCE as WEIGHTS
from viscache.scene import Scene
from viscache.scene.cameras import Camera, find_camera
from viscache.settings.checks import require
from viscache.vismap import equations

Array = npt.NDArray[np.float64]
LUMINANCE = np.array(WEIGHTS)
LEAVE = 1e-5  # offset of rays from the surface, as a fraction of the scene's size
CONSTANT_EDGE = 128  # texels along the edge of a constant environment; maps have at most as many


@dataclass(frozen=True, kw_only=True, slots=True)
class Hits:
    """First hits of N rays from a camera."""

    positions: Array  # (N, 3)
    normals: Array  # (N, 3), geometric normals facing the camera
    towards: Array  # (N, 3) unit vectors to the camera
    starts: Array  # (N, 3) origins of shadow rays, offset from the surface
    materials: npt.NDArray[np.int64]  # (N,) index of the material; -1: no surface


def blocked_share(
    scene: Scene, *, size: tuple[int, int], samples: int, camera: Camera | None = None
) -> Array:
    """Fraction of light-product samples that are occluded, per pixel: (H, W) in [0, 1].

    Directions are sampled with a density ∝ luminance(L)·B over the texels of the environment, with
    B = BRDF·cos at their centres, as in the visibility-map paper. NaN without surface or light. The
    scene has flat meshes without instances or textures; one ray through the centre of each pixel.
    """
    directions, texels = environment_texels(scene)
    radiance = texels.reshape(-1, 3).astype(float)
    hits = first_hits(scene, find_camera(scene, camera), size)
    rng = np.random.Generator(np.random.PCG64(0))
    share = np.full(size[0] * size[1], np.nan)
    for pixel in np.flatnonzero(hits.materials >= 0):
        product = (reflected(scene, hits, pixel, directions) * radiance) @ LUMINANCE
        if product.sum() > 0:
            drawn = directions[drawn_texels(product, samples, rng)]
            origins = np.broadcast_to(hits.starts[pixel], drawn.shape)
            share[pixel] = scene.occluded(origins, drawn).mean()
    return share.reshape(size[1], size[0])


def drawn_texels(density: Array, samples: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Stratified texels (samples,) from a density (T,) that is not all zero."""
    total = np.cumsum(density)
    at = (np.arange(samples) + rng.random(samples)) / samples * total[-1]
    return np.asarray(np.minimum(np.searchsorted(total, at, side="right"), len(density) - 1))


def environment_texels(scene: Scene) -> tuple[Array, npt.NDArray[np.float32]]:
    """Centres (R², 3) of the environment's texels, row by row, and their radiance (R, R, 3).

    ValueError if the scene has other lights, or images besides that of its environment.
    """
    kinds = [light["kind"] for light in scene.lights]
    alone = kinds in (["environment"], ["constant"])
    require(alone, "scene must be lit by its environment alone", kinds)
    scale = np.array(scene.lights[0]["scale"], np.float32)
    if kinds == ["constant"]:
        texels = np.ones((CONSTANT_EDGE, CONSTANT_EDGE, 3), np.float32)
    else:
        description = scene.description()
        n_images = len(description.images)
        require(n_images == 1, "scene must have one image, its environment", n_images)
        texels = equations.EnvironmentMap.from_latlong(description.image_pixels(0)).pixels
    middle = (np.arange(len(texels)) + 0.5) / len(texels)
    square = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)
    directions = equations.equal_area_to_direction(square.astype(np.float32))
    return directions.astype(float), np.ascontiguousarray(texels * scale)


def first_hits(scene: Scene, camera: Camera, size: tuple[int, int]) -> Hits:
    """First hits through the centres of the pixels of a pinhole, row by row."""
    require(camera.view_height == 0, "camera must be a pinhole", camera.name)
    origin, ray = np.array(camera.origin), _pixel_rays(camera, size)
    hit = scene.intersect(np.broadcast_to(origin, ray.shape), ray)
    meshes = scene.meshes()
    corners = np.concatenate([m["vertices"][m["triangles"]] for m in meshes]).astype(float)
    owner = np.repeat([m["material"] for m in meshes], [len(m["triangles"]) for m in meshes])
    a, b, c = corners[hit.triangle].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    normals *= -np.sign((normals * ray).sum(1, keepdims=True))
    found = hit.triangle >= 0
    positions = origin + ray * np.where(found, hit.t, 0)[:, None]
    return Hits(
        positions=positions,
        normals=normals,
        towards=-ray,
        starts=positions + normals * LEAVE * np.ptp(scene.bounds, axis=0).max(),
        materials=np.where(found, owner[hit.triangle], -1),
    )


def reflected(scene: Scene, hits: Hits, index: int | np.integer[Any], directions: Array) -> Array:
    """B = BRDF·cos (T, 3) at one of the hits, for light from unit directions (T, 3)."""
    material = scene.materials[hits.materials[index]]
    cosine = directions @ hits.normals[index]
    above = cosine > 0
    normal = tuple(hits.normals[index].tolist())
    point = equations.ShadingPoint(
        material["kind"],
        tuple(hits.towards[index].tolist()),
        ns=normal,
        ng=normal,
        base=material["base_color"],
        specular=material["specular"],
        roughness=material["roughness"],
        eta=material["eta"],
        coat=material["coat"],
        nonlinear=material["nonlinear"],
        metal_eta=material["metal_eta"],
        metal_k=material["metal_k"],
        beckmann=material["beckmann"],
    )
    out = np.zeros_like(directions)
    brdf = equations.eval_bsdf(point, directions[above].astype(np.float32))
    out[above] = brdf * cosine[above, None]
    return out


def _pixel_rays(camera: Camera, size: tuple[int, int]) -> Array:
    """Unit directions (H·W, 3) through the centres of the pixels."""
    width, height = size
    x = (np.arange(width) + 0.5) / width * 2 - 1 + 2 * camera.shift_x
    y = 1 - (np.arange(height) + 0.5) / height * 2 + 2 * camera.shift_y
    reach = math.tan(camera.fov_rad / 2)
    across, upwards = (
        (reach, reach * height / width)
        if camera.fov_is_horizontal
        else (reach * width / height, reach)
    )
    ray: Array = (
        np.array(camera.forward)
        + (across * x)[None, :, None] * np.array(camera.right)
        + (upwards * y)[:, None, None] * np.array(camera.up)
    ).reshape(-1, 3)
    return np.asarray(ray / np.linalg.norm(ray, axis=1, keepdims=True))
