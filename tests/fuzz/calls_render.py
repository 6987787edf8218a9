"""Calls that give frames."""

import json
import pickle
from pathlib import Path

import numpy as np

import viscache as vc
from fuzz import scenes, settings
from fuzz.outcome import WrongError
from fuzz.values import Dice

THREADS = 1


def checked(frame: vc.Frame, signed: bool = False) -> vc.Frame:
    """The frame, whose layers must be finite, and whose colours not negative if not `signed`."""
    for name, layer in frame.layers.items():
        if name == "variance" and np.abs(frame.image).max() > 1e18:
            continue  # its squares do not fit into 32 bits
        if not np.isfinite(layer).all():
            raise WrongError(f"layer {name} is not finite")
    if not signed and (frame.image < 0).any():
        raise WrongError("a colour is negative")
    in_json(frame.summary())
    return frame


def in_json(value) -> None:
    """What a summary must be: JSON without NaN."""
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise WrongError(f"not JSON: {error} in {value}") from error


def is_signed(given) -> bool:
    """Whether a control variate may overshoot: pictures then are right in the mean alone."""
    maps = isinstance(given.get("visibility"), vc.VisMaps) or given.get("visibility") == "vismap"
    return given.get("use", "correct" if maps else None) not in (None, "replace")


def options(dice: Dice):
    """Keyword arguments of a frame."""
    made = {
        "size": settings.size(dice),
        "camera": scenes.camera(dice),
        "threads": THREADS,
        "visibility": settings.visibility(dice),
        "rays": settings.rays(dice),
    }
    if dice.chance(0.15):
        made["use"] = dice.pick("replace", "correct", "x", vc.Correct(), lambda: 1)
    if dice.chance(0.2):
        made["env"] = scenes.environment(dice)
    if dice.chance(0.3):
        made["spp"] = dice.whole(1, 4)
    if dice.chance(0.3):
        made["seed"] = dice.whole(0, 2**63 - 1)
    return made


def render(dice: Dice) -> None:
    """`render` with any settings, perhaps twice with what is kept, perhaps audited."""
    scene, integrator, given = scenes.scene(dice), settings.integrator(dice), options(dice)
    if dice.chance(0.15):
        given["keep"] = dice.pick(
            lambda: vc.AqvcTable(table_bytes=dice.pick(4, 1 << 16, 5), check=dice.real(0, 1)),
            lambda: vc.AqvcRows(max_bytes=dice.whole(1, 1 << 20)),
            lambda: vc.VoxelCounts(),
        )()
        checked(vc.render(scene, integrator, **given), is_signed(given))
    if dice.chance(0.1):
        classes = dice.pick(vc.AuditPixels, vc.AuditQueries)
        given["audit"] = dice.pick("pixels", "queries", "x", settings.made(dice, classes))
    checked(vc.render(scene, integrator, **given), is_signed(given))


def shots(dice: Dice) -> None:
    """`Shot`: a value, which travels and then gives the same picture."""
    given = options(dice)
    shot = vc.Shot(scenes.scene(dice), settings.integrator(dice), **given)
    frame = checked(shot.render(), is_signed(given))
    again = pickle.loads(pickle.dumps(shot))
    if again != shot or again.render().sha256 != frame.sha256:
        raise WrongError("a shot that travelled gives another picture")


def passes(dice: Dice) -> None:
    """`Progressive`: passes, a stop by error or time, saved and loaded, merged."""
    scene, integrator, given = scenes.scene(dice), settings.integrator(dice), options(dice)
    given["visibility"] = given["visibility"] or "exact"
    picture = vc.Progressive(scene, integrator, **given)
    n = dice.whole(1, 3)
    if isinstance(n, int) and n > 1000:
        n = 3  # a thousand million passes take as long as they take
    checked(picture.passes(n), signed=True)  # by default every pass is corrected
    if dice.chance(0.3):
        picture.until(rel_l1=dice.real(0.01, 1), passes=dice.whole(1, 4))
    if dice.chance(0.5):
        picture.save("state.npz")
        again = vc.Progressive(scene, integrator, **given)
        again.load("state.npz")
        if not np.array_equal(again.frame.image, picture.frame.image):
            raise WrongError("a saved picture came back otherwise")
        Path("state.npz").unlink()


def parts(dice: Dice) -> None:
    """`tiles.render` gives the frame that `render` gives."""
    scene, integrator, given = scenes.scene(dice), settings.integrator(dice), options(dice)
    joined = checked(
        vc.tiles.render(scene, integrator, parts=dice.whole(1, 7), **given), is_signed(given)
    )
    if given["visibility"] is None and not np.array_equal(
        joined.image, vc.render(scene, integrator, **given).image
    ):
        raise WrongError("parts give another picture")


def lists(dice: Dice) -> None:
    """`connections`, answered by a cache and recorded."""
    given = options(dice)
    visibility = given.pop("visibility") or "exact"
    given.pop("use", None)
    found = vc.connections(scenes.scene(dice), settings.integrator(dice), **given)
    checked(found.frame(found.answers(visibility)), is_signed({"visibility": visibility}))
    if dice.chance(0.3):
        vc.record_queries(found, visibility, "queries.h5", max_bytes=1 << 24)


def tune(dice: Dice) -> None:
    """`tune` for an error."""
    found = vc.tune(
        vc.scenes.build(dice.pick(*scenes.QUICK)),
        vc.Direct(n_area=2, n_environment=2, n_brdf=2),
        rel_l1_reflected=dice.real(1e-3, 0.5),
        size=dice.pick((8, 8), (16, 10), (1, 1)),
        threads=THREADS,
    )
    # One sample has no upper end of its interval; `viscache tune --json` prints null
    in_json({k: v for k, v in found.as_dict().items() if k != "interval"})


def compared(dice: Dice) -> None:
    """`passes_over_time` of a cache and exact visibility."""
    vc.passes_over_time(
        vc.scenes.build(dice.pick(*scenes.QUICK)),
        settings.integrator(dice),
        {"exact": "exact", "other": settings.visibility(dice) or "aqvc"},
        passes=dice.whole(1, 3),
        reference=2,
        size=settings.size(dice),
        threads=THREADS,
    )


def flickering(dice: Dice) -> None:
    """`temporal.flicker` of a few frames."""
    scene, given = vc.scenes.cube_on_plane(), {"size": settings.size(dice), "threads": THREADS}
    frames = [checked(vc.render(scene, "direct", seed=i, **given)) for i in range(dice.pick(1, 3))]
    exposure = None if dice.chance(0.5) else dice.real(0.01, 100)
    found = vc.temporal.flicker(frames, frames[::-1], exposure=exposure)
    if not np.isfinite(found.above):
        raise WrongError("the flicker is not finite")


def ambient(dice: Dice) -> None:
    """`cached_ambient_occlusion`."""
    checked(
        vc.cached_ambient_occlusion(
            scenes.scene(dice),
            settings=settings.map_settings(dice),
            size=settings.size(dice),
            camera=scenes.camera(dice),
            width=dice.real(1e-3, 1),
            weighted=dice.chance(0.5),
            spp=dice.whole(1, 3),
            seed=dice.whole(0, 9),
            threads=THREADS,
        )
    )


def relit(dice: Dice) -> None:
    """`Relighting` under any sky."""
    cache = vc.VisibilityMapCache(scenes.scene(dice), vc.MapSettings(m=4, n_startup=20))
    light = vc.Relighting(
        cache, size=settings.size(dice), camera=scenes.camera(dice), threads=THREADS
    )
    checked(light.under(scenes.environment(dice), rotation_deg=dice.number()))


CALLS = {
    "render": ((render, 12), (shots, 2), (lists, 3)),
    "passes": ((passes, 6), (parts, 3), (tune, 1), (compared, 1), (flickering, 1)),
    "maps_to_frames": ((ambient, 3), (relit, 3)),
}
