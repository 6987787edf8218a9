"""One row per parameter: the C++ table, the settings in Python and kept tables agree with it."""

import inspect
import pickle
import re
import typing
from dataclasses import fields, replace

import numpy as np
import pytest

import viscache as vc
from core import testing
from viscache import _core
from viscache.settings import aqvc as settings
from viscache.settings.by_name import replaced
from viscache.settings.not_given import NotGiven

ROWS = {row["name"]: row for row in _core.aqvc.AqvcParameters.parameter_rows()}


def test_every_row_is_a_field_of_one_of_the_two_settings():
    own = {f.name for f in fields(vc.Aqvc)} - {"preset", "paper"}
    paper = {f.name for f in fields(vc.PaperForm)}
    assert own == {name for name, row in ROWS.items() if not row["paper"]}
    assert paper == {name for name, row in ROWS.items() if row["paper"]}


def test_closed_sets_have_the_names_of_the_table():
    sets = 0
    for cls in (vc.Aqvc, vc.PaperForm):
        for name, hint in typing.get_type_hints(cls).items():
            if name in ROWS and typing.get_origin(hint) is typing.Literal:
                names = set(re.findall(r'"(\w+)"', ROWS[name]["kind"]))
                assert set(typing.get_args(hint)) == names
                sets += 1
    assert sets == sum(row["kind"].endswith("}") for row in ROWS.values())


def test_the_help_is_one_page_with_every_default():
    assert len(fields(vc.Aqvc)) <= 16
    for cls in (vc.Aqvc, vc.PaperForm):
        page, struct = inspect.getdoc(cls) or "", _core.aqvc.AqvcParameters()
        shown = {name: p.default for name, p in inspect.signature(cls).parameters.items()}
        for f in fields(cls):
            if f.name not in ROWS:
                continue
            value = getattr(struct, f.name)
            assert f"\n{f.name} : {ROWS[f.name]['kind']}, default " in page
            assert ROWS[f.name]["doc"].split()[0] in page
            if f.name not in settings.BY_GROUP:
                assert repr(shown[f.name]) == repr(value)
        assert max(map(len, page.splitlines())) <= 100
    assert "c_n : int in [1, 64], default 8\n" in (vc.Aqvc.__doc__ or "")


def test_what_is_given_wins_over_the_preset_in_any_order():
    fast = replace(vc.Aqvc(c_n=4), preset="fast")
    assert (fast.c_n, fast.c_z, fast.by_contribution) == (4, 1.0, True)
    assert replace(fast, preset="default") == vc.Aqvc(c_n=4)
    both = replaced(vc.Aqvc(), {"c_z": 4.0, "preset": "fast"}, "visibility")
    assert both.c_z == 4.0 and both == vc.Aqvc(preset="fast", c_z=4.0)
    paper = vc.Aqvc(preset="paper", paper=vc.PaperForm(batch=0))
    assert (paper.paper.batch, paper.paper.form) == (0, "pairs")
    assert replace(paper, preset="default").paper == vc.PaperForm(batch=0)


def test_values_that_nobody_gave_are_values_and_say_so():
    cache = vc.Aqvc()
    assert isinstance(cache.c_e, NotGiven) and cache.c_e == 12 and f"{cache.c_e:g}" == "12"
    assert isinstance(cache.paper.scale_free, NotGiven) and not cache.paper.scale_free
    assert repr(cache.paper.scale_free) == "False" and repr(cache.refinement) == "'auto'"
    kept = pickle.loads(pickle.dumps(cache))
    assert kept == cache and isinstance(kept.paper.hash, NotGiven)
    assert all(not isinstance(value, NotGiven) for value in cache.resolved().values())
    assert cache.resolved()["scale_free"] is False and type(cache.resolved()["c_n"]) is int
    assert repr(vc.Aqvc(c_e=8, paper=vc.PaperForm(hash="scheme1"))) == (
        "Aqvc(c_e=8.0, paper=PaperForm(hash='scheme1'))"
    )


RANGES = [
    ("c_e", (1e-9, 1e9), (0.0, float("inf")), "c_e must be > 0 and finite"),
    ("c_l", (1e-3, 1e3), (0.5e-3, 1001.0), "c_l must be in [0.001, 1000]"),
    ("c_n", (1, 64), (0,), "c_n must be >= 1, got 0"),
    ("c_n", (1, 64), (65,), "c_n must be <= 64, got 65"),
    ("c_z", (0.01, 1024.0), (0.009, 1025.0), "c_z must be in [0.01, 1024]"),
    ("c_r", (1.001, 16.0), (1.0, 17.0), "c_r must be in [1.001, 16]"),
    ("level_step", (1.1, 100.0), (1.0, float("nan")), "level_step must be >= 1.1 and finite"),
    ("c_finest", (0.1,), (0.0, -1.0), "c_finest must be > 0 and finite"),
    ("digest_bits", (1, 31), (0, 32), "digest_bits must be in [1, 31]"),
    ("table_bytes", (4, 1 << 33), (3,), "table_bytes must be >= 4, got 3"),
    ("table_bytes", (4, 1 << 33), ((1 << 33) + 1,), "table_bytes must be <= 2^33"),
    ("c_pg", (1.1, 9.0), (1.0, float("inf")), "c_pg must be >= 1.1 and finite"),
    ("batch", (0, 9999), (-1,), "batch must be >= 0, got -1"),
    ("queue", (0, 64, 1024), (-2, 3, 1026, 8.5), "queue must be"),
    ("queue", (), (63,), "queue must be even and in [0, 1024], got 63"),
    ("hash", ("scheme1_mixed",), ("md5",), "hash must be one of scheme2, scheme1, scheme1_mixed"),
    ("quality", (), (1,), "no parameter quality"),
    ("c_w", (1, 1024), (0, 1025), "c_w must be in [1, 1024]"),
]


@pytest.mark.parametrize(("name", "good", "bad", "message"), RANGES, ids=[r[3] for r in RANGES])
def test_a_value_beyond_its_row_is_refused_with_what_must_hold(name, good, bad, message):
    for value in good:
        assert getattr(_core.aqvc.AqvcParameters(**{name: value}), name) == value
    for value in bad:
        with pytest.raises(ValueError, match=re.escape(message)):
            _core.aqvc.AqvcParameters(**{name: value})


def other_value(name):
    """A value of the parameter that is not its default."""
    special = {
        "c_n": 6,
        "digest_bits": 20,
        "queue": 64,
        "table_bytes": 8 << 20,
        "c_e_groups": {"point": 5.0},
        "refinement": "on",
        "exact_groups": ("point",),
    }
    value = getattr(_core.aqvc.AqvcParameters(), name)
    if name in special:
        return special[name]
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return next(n for n in re.findall(r'"(\w+)"', ROWS[name]["kind"]) if n != value)
    return value + 1 if isinstance(value, int) else value * 1.5


#: Parameters that choose C_E, its refinement or what is cached; frames may differ in them.
CHOOSE_CELLS = {"c_e", "c_e_groups", "refinement", "exact_groups"}
#: Parameters that a kept table does not allow to change, and the table's own parameters.
REFUSED, OF_THE_TABLE = {"form", "storage"}, {"hash", "digest_bits"}


@pytest.fixture(scope="module")
def room():
    """Every kind of light that a direct integrator with virtual point lights has."""
    description = vc.scenes.SCENES["cornell_box"].builder().description
    description.add_point_light((-0.15, 0.5, -0.1), (0.4, 0.4, 0.4))
    description.add_directional_light((0.3, 0.3, 1.0), (1.5, 1.4, 1.2))
    return vc.Scene.from_description(description).with_environment(0.5)


@pytest.mark.parametrize("name", sorted(set(ROWS) - REFUSED - OF_THE_TABLE))
def test_a_parameter_is_keyed_where_the_bits_of_other_values_are_not_found(name, room, monkeypatch):
    monkeypatch.setattr("viscache.aqvc.table.KEYED", ())
    base = vc.Aqvc(c_e=8, refinement="off", paper=vc.PaperForm(scale_free=False))
    changed = replaced(base, {name: other_value(name)}, "visibility")
    integrator = vc.Whitted(n_vpls=8, n_area=2, n_environment=4, n_brdf=4)
    rays = []
    for second in (base, changed):
        table = vc.AqvcTable(table_bytes=1 << 26)
        for visibility in (base, second):
            frame = vc.render(room, integrator, visibility=visibility, size=(40, 25), keep=table)
        rays.append(frame.counters["rays"] - frame.counters["bypassed"])
    assert rays[0] == 0
    assert (rays[1] > 0) == (ROWS[name]["keyed"] or name in CHOOSE_CELLS)


def test_hash_and_digest_are_keyed_as_they_say_what_is_kept_under_a_key():
    keys = np.random.default_rng(1).integers(-1000, 1000, (2000, 15), dtype=np.int32)
    one, other = (_core.aqvc.hash_keys(keys, scheme) for scheme in ("scheme2", "scheme1"))
    assert (one != other).any(axis=1).all()
    found = []
    for bits in (31, 4):
        table = testing.BitTable(5003, bits)
        table.put(keys[:1000], [True] * 1000)
        found.append((table.get(keys[1000:]) >= 0).sum())
    assert found[0] == 0 < found[1]
    assert all(ROWS[name]["keyed"] for name in OF_THE_TABLE)
    assert not any(ROWS[name]["keyed"] for name in CHOOSE_CELLS | REFUSED)


def test_every_keyed_parameter_must_be_that_of_the_frames_before(room):
    table, base = vc.AqvcTable(table_bytes=1 << 20), vc.Aqvc(paper=vc.PaperForm(scale_free=False))
    vc.render(room, vc.Direct(), visibility=base, size=(8, 5), keep=table)
    for name in settings.KEYED:
        changed = replaced(base, {name: other_value(name)}, "visibility")
        with pytest.raises(ValueError, match=f"{name} must be .* as in the table's frames before"):
            vc.render(room, vc.Direct(), visibility=changed, size=(8, 5), keep=table)
