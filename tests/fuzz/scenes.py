"""Scenes, environments and cameras of every kind."""

import numpy as np

import viscache as vc
from fuzz.values import Dice
from viscache import _core as core

QUICK = (
    "cube_on_plane",
    "cornell_box",
    "thin_wall",
    "slits",
    "random_triangles?triangles=100",
    "slats",
)


def scene(dice: Dice) -> vc.Scene:
    """Built-in, described, or of any triangles."""
    kind = dice.random.randrange(10)
    if kind < 5:
        return vc.scenes.build(dice.pick(*QUICK))
    if kind < 7:
        return described(dice)
    return vc.Scene.from_arrays(**mesh(dice), **({"env": environment(dice)} if kind == 9 else {}))


def mesh(dice: Dice):
    """Arguments of a mesh: vertices, triangles, perhaps normals, colours and a base colour."""
    count = dice.pick(3, 4, 10, 100)
    triangles = dice.numpy().integers(0, count, (dice.pick(1, 2, 10, 200), 3))
    if dice.is_wild():
        count = dice.pick(0, 1, 2, count)
        triangles = dice.pick(
            triangles + count,
            -triangles,
            triangles.astype(np.float32),
            triangles[:, :2],
            triangles.ravel(),
            triangles.tolist(),
            triangles.astype(np.int8),
            triangles[:0],
            triangles * 2**40,
            triangles.astype(object),
            triangles > 1,
            None,
        )
    made = {"vertices": dice.array((count, 3)), "triangles": triangles}
    if dice.chance(0.3):
        made["normals"] = dice.array((count, 3), unit=True)
    if dice.chance(0.3):
        rows = dice.pick(count, count, len(triangles) if triangles is not None else 1)
        made["colors"] = dice.numpy().random((rows, dice.pick(3, 4)))
        if dice.is_wild():
            made["colors"] = dice.pick("red", 3, dice.array((count, 3)), np.uint8([[1, 2, 3]]))
    if dice.chance(0.3):
        made["base_color"] = tuple(dice.random.uniform(-0.01, 1.01) for _ in "rgb")
        if dice.is_wild():
            made["base_color"] = dice.pick("red", 3, None, (1, 1), {}, (1, "x", 0), (1, None, 0))
    return made


def environment(dice: Dice):
    """A colour or an image, perhaps with one bright pixel."""
    if dice.is_wild():
        return dice.pick("gone.exr", "", b"x", object(), {}, dice.number(), dice.array((2, 4, 3)))
    if dice.chance(0.3):
        return dice.pick(0, 1, 0.5, (1, 2, 3), 1e6, 1e-30, 1e30)
    height, width = dice.pick((1, 1), (1, 2), (2, 4), (8, 16), (33, 7))
    image = np.abs(dice.numpy().normal(size=(height, width, 3))).astype(np.float32)
    if dice.chance(0.3):
        image[:] = 0
    if dice.chance(0.4):
        image[0, width // 2] = dice.pick(1e6, 1e20, 1e30)
    return image


def camera(dice: Dice):
    """None, a place of its own, or anything."""
    if dice.chance(0.5):
        return None
    if dice.is_wild():
        return dice.pick(0, 1, -1, "camera", 1.5, [], True)
    origin = [dice.number() if dice.is_wild() else dice.random.uniform(-3, 3) for _ in "xyz"]
    target = [dice.number() if dice.is_wild() else dice.random.uniform(-1, 1) for _ in "xyz"]
    if dice.chance(0.3):
        return vc.orthographic(origin, target, height=dice.real(0.01, 100))
    return vc.look_at(origin, target, dice.pick((0, 1, 0), (0, 0, 1)), dice.real(1, 170))


def described(dice: Dice) -> vc.Scene:
    d, kinds = vc.SceneDescription(), core.MaterialKind
    if dice.chance(0.2):
        d.add_image(dice.array((dice.pick(1, 2, 8), dice.pick(1, 8), dice.pick(1, 3, 4))))
    share = dice.number if dice.is_wild() else dice.random.random
    for _ in range(dice.pick(1, 2, 3)):
        d.add_material(
            dice.pick(kinds.DIFFUSE, kinds.DIFFUSE, kinds.GLOSSY, kinds.MIRROR, kinds.DIELECTRIC),
            base_color=(share(), share(), share()),
            roughness=share(),
            eta=dice.pick(1.0, 1.5, share()),
            base_texture=dice.pick(-1, 0, 5) if dice.is_wild() else -1,
            alpha_cutoff=share(),
        )
    for _ in range(dice.pick(1, 2)):
        half = dice.pick(1, 4, 1e-6, 1e6)
        quad = np.array([[-half, 0, half], [half, 0, half], [half, 0, -half], [-half, 0, -half]])
        light = [dice.pick(0, 0, 1)] * 3 if not dice.is_wild() else [dice.number()] * 3
        material = dice.pick(-1, 9) if dice.is_wild() else 0
        d.add_mesh(
            quad + np.float64([0, dice.pick(0, 1, 1e-7), 0]),
            np.uint32([[0, 1, 2], [0, 2, 3]]),
            material=material,
            emission=light,
            emits_two_sided=dice.chance(0.5),
        )
    for _ in range(dice.pick(0, 1, 3)):
        place, power = [dice.number() for _ in "xyz"], [dice.pick(0, 1, 10, share())] * 3
        kind = dice.random.randrange(3)
        if kind == 0:
            d.add_point_light(place, power)
        elif kind == 1:
            d.add_directional_light(place, power)
        else:
            d.add_sphere_light(place, dice.real(1e-3, 1), power)
    if dice.chance(0.3):
        d.set_environment([dice.pick(0, 1, share())] * 3)
    if dice.chance(0.2):
        size, along = dice.real(0.1, 10), share()
        d.add_instance([0], [[size, 0, 0, along], [0, size, 0, 0], [0, 0, size, 0]])
    return vc.Scene.from_description(d, threads=1)
