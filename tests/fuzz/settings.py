"""Settings of any class, made from the annotations and defaults of its fields."""

import typing
from dataclasses import MISSING, fields
from typing import Literal

import viscache as vc
from fuzz.values import Dice
from viscache.settings import aqvc, maps
from viscache.settings import rays as rays_module
from viscache.settings.registry import NAMES

GROUPS = ("point", "directional", "area", "environment", "vpl")
#: Fields whose values other fields or objects decide, or that ask for much work.
LEFT_OUT = {"cache", "preset", "vpls", "paper", "max_build_s", "max_records"}
#: What would take minutes although it is allowed.
MOST = {
    "n_directions": 129,
    "n_tiles": 64,
    "resolution": 256,
    "n_samples": 33,
    "n_vpls": 20,
    "n_area": 8,
    "n_environment": 8,
    "n_brdf": 8,
    "passes": 4,
    "spp": 3,
    "n_voxels": 12,
    "learn_pixels": 256,
    "n_startup": 60,
    "head_room": 100,
    "max_depth": 20,
    "bsp_depth": 8,
    "pick": 8,
}


def made(dice: Dice, cls, **given):
    """An instance with a few of its fields drawn."""
    hints = typing.get_type_hints(cls)
    names = [f for f in fields(cls) if f.init and f.name not in LEFT_OUT | set(given)]
    values = dict(given)
    for field in dice.random.sample(names, min(len(names), dice.pick(0, 1, 2, 3, 5))):
        default = None if field.default is MISSING else field.default
        values[field.name] = _value(dice, field.name, hints[field.name], default)
    if cls is vc.Direct and not dice.is_wild() and values.get("environment") != "product":
        values.pop("passes", None)
    for field in names:  # what was not drawn is small, too
        small = field.name in MOST and field.name not in {*values, "passes"}
        if small and isinstance(field.default, int):
            values[field.name] = dice.random.randint(1, min(MOST[field.name], 16))
    if "n_directions" in values and cls is vc.Vlf and not dice.is_wild():
        values["n_directions"] = dice.pick(1, 3, 9, 33, 129, "auto")
    return cls(**values)


def _value(dice: Dice, name: str, hint, default):
    """A value of the annotated type, or a wild one."""
    kinds = [k for k in (typing.get_args(hint) or (hint,)) if k is not type(None)]
    if typing.get_origin(hint) is Literal:
        return "nothing" if dice.is_wild() else dice.random.choice(typing.get_args(hint))
    kind = dice.random.choice(kinds)
    if typing.get_origin(kind) is Literal:
        return dice.random.choice(typing.get_args(kind))
    if kind is bool:
        return dice.number() if dice.is_wild() else dice.chance(0.5)
    if kind is int:
        if isinstance(default, str):  # "auto", or a number
            default = None
        low, high = _range(name, min(int(default or 1), 1), MOST.get(name, 64))
        return dice.whole(int(low), int(min(high, MOST.get(name, 1 << 20))))
    if kind is float:
        base = float(default) if isinstance(default, int | float) and default else 0.5
        low, high = _range(name, base / 2, base * 2)
        return dice.real(low, high)
    if "group" in name:
        group = "x" if dice.is_wild() else dice.pick(*GROUPS)
        kinds = {"c_e_groups": {group: dice.real(1e-3, 1e3)}, "exact_groups": (group,)}
        return () if dice.is_wild() else kinds.get(name, {group: dice.pick("on", "off", "auto")})
    return dice.number()


def _range(name: str, low: float, high: float) -> tuple[float, float]:
    """The range of the core's tables, with ends that are finite; else the given one."""
    for rows in (aqvc.ROWS, maps.ROWS, rays_module.BSP_ROWS, rays_module.FIELD_ROWS):
        row = rows.by_name.get(name)
        if row is not None and row["low"] > -1e300:
            low = row["low"] + (1e-6 if row["above"] else 0)
            return low, row["high"] if row["high"] < 1e300 else 1e6
    return low, high


def integrator(dice: Dice):
    return made(dice, dice.pick(vc.Direct, vc.Direct, vc.Whitted, vc.AmbientOcclusion, vc.Bdpt))


def visibility(dice: Dice):
    """Settings of any visibility, or its name."""
    kind = dice.random.randrange(10)
    if kind == 0:
        return dice.pick(*NAMES["visibility"], None, "x")
    if kind < 5:
        return made(dice, vc.Aqvc, preset=dice.pick("default", "fast", "paper", "as_printed"))
    if kind == 5:
        return made(dice, vc.Aqvc, preset="paper", paper=made(dice, vc.PaperForm))
    return made(dice, dice.pick(vc.VisMaps, *NAMES["visibility"].values()))


def map_settings(dice: Dice):
    return made(dice, vc.MapSettings, preset=dice.pick("low", "medium", "high", "auto"))


def rays(dice: Dice):
    """Settings of any ray caster; mostly none."""
    if dice.chance(0.6):
        return None
    return dice.pick(
        lambda: made(dice, vc.Embree), lambda: made(dice, vc.Bsp), lambda: field(dice)
    )()


def field(dice: Dice):
    """Settings of a field that builds within a second."""
    return made(
        dice, vc.Vlf, max_build_s=dice.pick(0.1, 1.0), max_bytes=dice.pick(1 << 20, 1 << 28)
    )


def size(dice: Dice):
    if dice.is_wild():
        return dice.pick(
            (0, 1), (-1, 5), (2**31, 2**31), (1.5, 2), "ab", (3,), (2**64, 1), (1, 2, 3)
        )
    return dice.pick((16, 10), (1, 1), (33, 17), (1, 40), (40, 1), (8, 8))
