"""Calls that ask for rays, fields and maps."""

from pathlib import Path

import numpy as np

import viscache as vc
from fuzz import scenes, settings
from fuzz.calls_render import in_json
from fuzz.outcome import WrongError
from fuzz.values import Dice

THREADS = 1


def scene(dice: Dice) -> None:
    """A scene of any arrays, and what it says of itself."""
    made = vc.Scene.from_arrays(**scenes.mesh(dice))
    if made.triangles and not np.isfinite(made.bounds).all():
        raise WrongError("the bounds are not finite")
    if made.triangles:  # nothing has no bounds
        in_json(made.info())
    repr(made), made.warnings, made.content_hash, made.coplanar_share, made.meshes()
    made.overview_camera()
    made.with_environment(scenes.environment(dice))


def built_in(dice: Dice) -> None:
    """A built-in scene with any value of one of its parameters."""
    name = dice.pick(*vc.scenes.SCENES)
    parameters = list(vc.scenes.SCENES[name].parameters)
    values = ("0", "-1", "1", "2", "7", "nan", "inf", "1e-30", "1e30", "", "x", "true", "9" * 20)
    if name in ("courtyard", "garden", "hairball", "apartment"):  # seconds by default
        name, parameters = "slats", ["count"]
    spec = f"{name}?{dice.pick(*parameters)}={dice.pick(*values)}" if parameters else name
    in_json(vc.scenes.build(spec).info())


def numbered(scene: vc.Scene) -> int:
    """How many numbers the triangles of a scene have: instances share theirs, spheres come last."""
    spheres = sum(light["kind"] == "sphere" for light in scene.lights)
    return int(scene._core.unique_triangles) + 2208 * spheres


def check_hits(hits, triangles: int) -> None:
    """No hit leaves its triangle, or the triangles that are there."""
    hit = hits.triangle >= 0
    if not hit.any():
        return
    t, weights = hits.t[hit], hits.barycentrics[hit]
    if not (np.isfinite(t).all() and (t >= 0).all()):
        raise WrongError("a hit has a distance that is not finite")
    if hits.triangle.max() >= triangles:
        raise WrongError("a hit has a triangle that is not there")
    if not np.isfinite(weights).all() or (weights < -1e-3).any() or (weights.sum(1) > 1.001).any():
        raise WrongError("barycentric coordinates leave the triangle")


def rays(dice: Dice) -> None:
    """`visible`, `occluded` and `intersect`."""
    made, n, caster = scenes.scene(dice), dice.pick(0, 1, 16, 17, 300), settings.rays(dice)
    a, b = dice.array((n, 3)), dice.array((n, 3))
    kind = dice.random.randrange(3)
    if kind == 0:
        made.visible(a, b, rays=caster, threads=THREADS)
    elif kind == 1:
        t_max = dice.pick(np.inf, dice.number(), dice.array((n,)))
        made.occluded(a, b, t_max, rays=caster, threads=THREADS)
    else:
        check_hits(made.intersect(a, b, rays=caster, threads=THREADS), numbered(made))


def field(dice: Dice) -> None:
    """`VisibilityField` and its rays."""
    made, given = scenes.scene(dice), settings.field(dice)
    vc.VisibilityField.memory_estimate(made, given, threads=THREADS)
    found = vc.VisibilityField(made, settings=given, threads=THREADS)
    n = dice.pick(0, 1, 100)
    hits = found.intersect(dice.array((n, 3)), dice.array((n, 3)), threads=THREADS)
    check_hits(hits, numbered(made))
    found.tile_entries(dice.whole(0, found.n_directions - 1))


def moving(dice: Dice) -> None:
    """`DynamicField`: triangles come, move and go."""
    given = vc.Vlf(n_directions=dice.pick(1, 9, 33), n_tiles=dice.pick(1, 8, 32), head_room=2.0)
    made = vc.vlf.DynamicField(
        scenes.scene(dice), given, mode=dice.pick("overlay", "in_place"), threads=THREADS
    )
    numbers = [0]
    for _ in range(dice.pick(1, 4)):
        kind = dice.random.randrange(3)
        if kind == 0:
            mesh = scenes.mesh(dice)
            numbers.append(made.insert(mesh["vertices"], mesh["triangles"]))
        elif kind == 1:
            made.delete(dice.whole(0, 3) if dice.is_wild() else numbers[-1])
        else:
            matrix = (
                dice.array((4, 4))
                if dice.is_wild()
                else np.diag([1, 1, 1 + dice.random.random(), 1])
            )
            made.transform(numbers[-1], matrix)
        made.occluded(dice.array((9, 3)), dice.array((9, 3)))


def aligned(dice: Dice) -> None:
    """Rays along the axes of a field, and the axes."""
    made, n = scenes.scene(dice), dice.pick(0, 1, 33, 100)
    points, normals = dice.array((n, 3)), dice.array((n, 3), unit=True)
    count = dice.whole(1, 8193) if dice.is_wild() else dice.pick(1, 3, 9, 33)
    engine, t_max = dice.pick("auto", "batch", "embree", "field"), dice.pick(np.inf, dice.number())
    trace = dice.pick(vc.vlf.trace_aligned, vc.aligned_occlusion)
    trace(made, points, normals, count, t_max=t_max, engine=engine, threads=THREADS)
    vc.vlf.nearest_direction(normals, count)


def maps(dice: Dice) -> None:
    """`VisibilityMapCache`: records, look-ups, visibility, and a file of it."""
    made = scenes.scene(dice)
    cache = vc.VisibilityMapCache(made, settings.map_settings(dice), rays=settings.rays(dice))
    cache.update(scenes.camera(dice), size=settings.size(dice), threads=THREADS)
    n = dice.pick(0, 1, 50)
    found = cache.lookup(dice.array((n, 3)), dice.array((n, 3), unit=True), dice.real(0.01, 10))
    if not np.isfinite(found.beta).all() or (found.beta < 0).any():
        raise WrongError("a weight is negative or not finite")
    seen = cache.visibility(found, dice.array((7, 3), unit=True))
    if not np.isfinite(seen).all() or (seen < 0).any() or (seen > 1.0001).any():
        raise WrongError("visibility must lie in [0, 1]")
    cache.end_frame()
    if dice.chance(0.3):
        cache.save("cache.npz")
        if len(vc.VisibilityMapCache.load("cache.npz", made)) != len(cache):
            raise WrongError("a saved cache came back otherwise")
        Path("cache.npz").unlink()


def own(dice: Dice) -> None:
    """Your own points and lights, answered by any oracle."""
    n = dice.pick(1, 5, 40)
    eyes = vc.EyePoints(positions=dice.array((n, 3)), normals=dice.array((n, 3), unit=True))
    ends = dice.pick(
        lambda: vc.FarEnds.points(dice.array((7, 3))),
        lambda: vc.FarEnds.directions(dice.array((7, 3), unit=True)),
        lambda: vc.FarEnds.surfaces(dice.array((7, 3)), dice.array((7, 3), unit=True)),
    )()
    eyes.with_density()
    repr(ends)
    vc.Vpls(dice.array((n, 3)), dice.array((n, 3), unit=True), dice.array((n, 3)))


def equations(dice: Dice) -> None:
    """Resolutions, keys and hashes of the quantized cache."""
    n = dice.pick(0, 1, 30)
    points, normals = dice.array((n, 3)), dice.array((n, 3), unit=True)
    sizes = vc.aqvc.resolution_eye(dice.array((n,)), dice.real(0.1, 100), dice.real(0.1, 10))
    keys, _ = vc.aqvc.eye_keys(
        vc.Aqvc(), dice.array((3,)), dice.real(0.1, 10), points, normals, sizes
    )
    if vc.aqvc.hash_keys(keys).shape != (n, 2):
        raise WrongError("a key has no hash")


CALLS = {
    "scenes": ((scene, 5), (built_in, 2)),
    "rays": ((rays, 8), (aligned, 2), (own, 1), (equations, 1)),
    "fields": ((field, 3), (moving, 2)),
    "maps": ((maps, 1),),
}
