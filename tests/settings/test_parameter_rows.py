"""One row per parameter: what Python makes of the C++ tables."""

import dataclasses
import inspect
import math
import re
import typing

import pytest

import viscache as vc
from viscache import _core

MAPS = {f.name for f in dataclasses.fields(vc.MapSettings)}
#: Settings, their C++ struct, and the fields that Python alone has.
TABLES = [
    (vc.MapSettings, _core.vismap.MapCacheParameters, {"preset", "order"}),
    (vc.Vlf, _core.vlf.FieldSettings, set()),
    (vc.Bsp, _core.visibility.BspSettings, set()),
    (vc.Direct, _core.DirectSettings, set()),
    (vc.Whitted, _core.WhittedSettings, set()),
    (vc.AmbientOcclusion, _core.AmbientSettings, set()),
    (vc.Bdpt, _core.BdptSettings, set()),
    (vc.ShadowMap, _core.ShadowMapSettings, set()),
    (vc.NeePlusPlus, _core.NeePlusPlusSettings, set()),
    (vc.VisMaps, _core.VisMapSettings, {*MAPS, "cache", "update", "count_misses"}),
]
tables = pytest.mark.parametrize(
    ("cls", "struct", "own"), TABLES, ids=[t[0].__name__ for t in TABLES]
)


def core(made):
    """The C++ struct of settings; that of `VisMaps` beside the one of its records."""
    return made.estimate() if isinstance(made, vc.VisMaps) else made.core()


def rows(struct):
    return {row["name"]: row for row in struct.parameter_rows()}


@tables
def test_rows_have_the_names_defaults_and_sets_of_the_fields(cls, struct, own):
    named = {f.name: f.default for f in dataclasses.fields(cls) if f.name not in own}
    defaults = {name: getattr(struct(), name) for name in rows(struct)}
    assert named == defaults
    assert {n: type(v) for n, v in named.items()} == {n: type(v) for n, v in defaults.items()}
    made = core(cls())
    assert {name: getattr(made, name) for name in defaults} == defaults
    for name, hint in typing.get_type_hints(cls).items():
        if name not in own and typing.get_origin(hint) is typing.Literal:
            words = re.findall(r'"(\w+)"', rows(struct)[name]["kind"])
            assert typing.get_args(hint) == tuple(words)
            for word in words:
                setattr(made, name, word)
                assert getattr(made, name) == word


def ends(row):
    """The numeric ends of a row's range: (accepted or None, refused)."""
    if row["kind"].startswith("{"):
        return []
    whole = row["kind"].startswith("int")
    step = (lambda v, to: int(v) + (1 if to > v else -1)) if whole else math.nextafter
    found = []
    for end, outwards in ((row["low"], -math.inf), (row["high"], math.inf)):
        if not math.isfinite(end):
            continue
        inside, beyond = (int(end) if whole else end), step(end, outwards)
        if row["above"] and end == row["low"]:
            inside, beyond = step(end, math.inf), end
        found.append((inside, [beyond]))
    return found


@tables
def test_the_ends_of_every_range_are_accepted_and_beyond_them_the_name_is_in_the_error(
    cls, struct, own
):
    beside = {
        "m_nearest": {"n_best": 1},
        "n_best": {"m_nearest": 64},
        "interleave": {"environment": "shared", "n_environment": 1 << 16},
    }
    checked = 0
    for name, row in rows(struct).items():
        for inside, refused in ends(row):
            made = cls(**{name: inside}, **beside.get(name, {}))
            assert getattr(core(made), name) == getattr(made, name) == inside
            said = (
                re.sub("^(int|float) ", "", row["kind"]).partition(" or ")[0].partition(", opt")[0]
            )
            for value in refused:
                with pytest.raises(ValueError, match=re.escape(f"{name} must be {said}")):
                    cls(**{name: value})
                with pytest.raises(ValueError, match=f"{name} must be"):
                    struct(**{name: value})
            checked += 1
    numbers = [row for row in rows(struct).values() if re.match("int|float (in|>)", row["kind"])]
    assert checked >= len(numbers) - ("max_distance" in rows(struct))


@tables
def test_what_no_number_of_the_struct_can_hold_is_refused_by_name(cls, struct, own):
    for name, row in rows(struct).items():
        if row["kind"].startswith("int"):
            for value in (1 << 64, -(1 << 64), 1.5, "many", None):
                made = struct()
                if value is None and "optional" in row["kind"]:
                    continue
                with pytest.raises(ValueError, match=f"{name} must be"):
                    setattr(made, name, value)
                assert getattr(made, name) == getattr(struct(), name)
        elif row["kind"].startswith("float"):
            for value in (math.nan, math.inf, "much"):
                with pytest.raises(ValueError, match=f"{name} must be"):
                    setattr(struct(), name, value)


@tables
def test_the_help_shows_every_row_with_its_default(cls, struct, own):
    page = inspect.getdoc(cls) or ""
    for name, row in rows(struct).items():
        shown = repr(getattr(struct(), name)).replace("'", '"')
        assert f"\n{name} : {row['kind']}, default {shown}\n    " in page
        assert " ".join(row["doc"].split()[:4]) in page
    assert max(map(len, page.splitlines())) <= 100


def test_open_values_are_words():
    assert rows(_core.vlf.FieldSettings)["n_tiles"]["kind"] == 'int in [1, 4096] or "auto"'
    core = vc.Vlf(n_directions="auto", n_tiles="auto").core()
    assert (core.n_directions, core.n_tiles, core.bsp_depth) == ("auto", "auto", "auto")
    for name, value in (("n_directions", 0), ("n_tiles", 0), ("bsp_depth", -1)):
        with pytest.raises(ValueError, match=rf"{name} must be in \[.*\], got {value}"):
            vc.Vlf(**{name: value})
    assert vc.Bsp().core().max_depth is None and vc.Bsp(max_depth=3).core().max_depth == 3
    low = vc.MapSettings(preset="low", w_min=0.7)
    assert (low.core().w_min, low.core().delta_max, low.thresholds()) == (0.7, None, (0.7, 0.10))
