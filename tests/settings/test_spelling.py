"""Misspelt keywords are refused with the nearest known one; settings show what differs."""

import dataclasses
import importlib
import inspect
import pickle
import pydoc

import pytest

import viscache as vc
from viscache.settings import by_name
from viscache.settings.spelling import GONE, nearest, spelled

#: Made by the library, from C++ or by hand without keywords: nothing to misspell.
NOT_CONSTRUCTED = (tuple, dict, BaseException)
#: Returned by calls, never constructed by users.
RESULTS = {
    "Box",
    "Connections",
    "Lookup",
    "Records",
    "UpdateReport",
    "AlignedRows",
    "VisibilityRows",
}


def constructors():
    """Public classes that take keywords and have one to be misspelt."""
    modules = [
        "viscache",
        "viscache.vlf",
        "viscache.vismap",
        "viscache.correlation",
        "viscache.sweeps.designs",
        "viscache.sweeps.sweep",
    ]
    found = {}
    for name in modules:
        module = importlib.import_module(name)
        for public in getattr(module, "__all__", ["SweepFile"]):
            value = getattr(module, public)
            by_us = inspect.isclass(value) and value.__module__.startswith("viscache.")
            if by_us and "_core" not in value.__module__:
                found[f"{name}.{public}"] = value
    kept = [
        c
        for c in found.values()
        if not issubclass(c, NOT_CONSTRUCTED) and c.__name__ not in RESULTS
    ]
    return sorted(set(kept), key=str)


@pytest.mark.parametrize("cls", constructors(), ids=lambda c: c.__name__)
def test_every_public_constructor_names_the_nearest_known_keyword(cls):
    names = [n for n in inspect.signature(cls).parameters if not n.startswith("_")]
    if not names:
        with pytest.raises(TypeError, match=f"{cls.__name__} has no parameter"):
            cls(size=1)
        return
    name = names[-1]
    with pytest.raises(TypeError, match=f"{cls.__name__} has no parameter .*did you mean '{name}'"):
        cls(**{name + "e": 1})


def test_the_constructors_looked_at_are_those_that_users_call():
    names = {c.__name__ for c in constructors()}
    assert {"Aqvc", "Vlf", "Scene", "Frame", "VisibilityField", "VisibilityMapCache"} <= names
    assert {"VisMaps", "AqvcTable", "Relighting", "DynamicField", "Range"} <= names


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: vc.Aqvc(c_ee=3), r"Aqvc has no parameter 'c_ee'; did you mean 'c_e'\?"),
        (lambda: vc.render("slits", "direct", visibilities="aqvc"), "did you mean 'visibility'"),
        (lambda: vc.tune("slits", "direct", rel_l2=0.1), "did you mean 'rel_l1'"),
        (
            lambda: vc.tune("slits", "direct", metric="rel_l1"),
            "no parameter 'metric': the target names its metric, rel_l1_reflected= or rel_l1=",
        ),
        (lambda: vc.sweep("slits", "direct", ovr={}), "did you mean 'over'"),
        (lambda: vc.load_scene("a.obj", stric=True), "did you mean 'strict'"),
        (lambda: vc.look_at((0, 0, 0), (1, 1, 1), fov=3), "did you mean 'fov_deg'"),
        (lambda: vc.correlation.measure("slits", n_point=3), "did you mean 'n_points'"),
        (lambda: vc.cached_ambient_occlusion("slits", sizes=3), "did you mean 'size'"),
    ],
)
def test_public_calls_name_the_nearest_known_keyword(call, says):
    with pytest.raises(TypeError, match=says):
        call()


def test_without_a_near_name_all_known_ones_are_listed():
    with pytest.raises(TypeError, match="Embree has no parameter 'zzz'; known: robust, watertight"):
        vc.Embree(zzz=1)
    assert nearest("a", []) == "; there are none"


def test_classes_and_functions_stay_what_they_were():
    cache = vc.Aqvc(c_e=7, c_n=6)
    assert pickle.loads(pickle.dumps(cache)) == cache and hash(cache) == hash(vc.Aqvc(c_e=7, c_n=6))
    assert dataclasses.replace(cache, c_e=8).c_n == 6
    with pytest.raises(TypeError, match="did you mean 'c_e'"):
        dataclasses.replace(cache, c_ee=8)
    assert list(inspect.signature(vc.Exact).parameters) == [
        "order",
        "coherent",
        "sky_engine",
        "engine",
    ]
    assert "c_e" in pydoc.render_doc(vc.Aqvc) and vc.render.__name__ == "render"
    assert inspect.signature(vc.render).parameters["spp"].default == 1


def test_what_is_decorated_still_raises_its_own_errors():
    @spelled
    def told(a, *, b=2):
        return a + b

    assert told(1) == 3 and told(1, b=3) == 4
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'a'"):
        told(b=1)


@pytest.mark.parametrize(
    ("settings", "shown"),
    [
        (vc.Aqvc(), "Aqvc()"),
        (vc.Aqvc(c_e=8), "Aqvc(c_e=8.0)"),
        (vc.Aqvc(preset="fast", c_e=8), "Aqvc(preset='fast', c_e=8.0)"),
        (vc.Whitted(n_vpls=64), "Whitted(n_vpls=64)"),
        (vc.Vlf(n_directions=33, lazy=True), "Vlf(n_directions=33, lazy=True)"),
        (vc.Embree(), "Embree()"),
        (vc.MapSettings(preset="low"), "MapSettings(preset='low')"),
        (vc.VisMaps(alpha="one"), "VisMaps(alpha='one')"),
        (vc.ShadowMap(bias=0.5), "ShadowMap(bias=0.5)"),
    ],
)
def test_settings_show_what_differs(settings, shown):
    assert repr(settings) == shown
    assert eval(shown, {name: getattr(vc, name) for name in vc.__all__}) == settings


def test_what_keeps_work_is_called_directory():
    for function in (vc.sweep, vc.correlation.measure, vc.correlation.correlate):
        parameters = inspect.signature(function).parameters
        assert "directory" in parameters and "store" not in parameters


@pytest.mark.parametrize("name", GONE)
def test_a_parameter_that_went_says_what_there_is_instead(name):
    whose, _, parameter = name.partition(".")
    made = getattr(vc, whose, None) or getattr(vc.correlation, whose)
    with pytest.raises(TypeError, match=f"has no parameter '{parameter}': ") as caught:
        made(**{parameter: 1})
    assert str(caught.value).endswith(GONE[name])
    if inspect.isclass(made):
        assert parameter not in inspect.signature(made).parameters
        settings = vc.Aqvc() if made is vc.PaperForm else made()
        role = "visibility" if isinstance(settings, vc.Aqvc) else "integrator"
        for spelled_as in (parameter, f"{role}.{parameter}"):
            with pytest.raises(ValueError, match=f"{whose} has no parameter .*: ") as refused:
                by_name.assign({role: settings}, [f"{spelled_as}=1"], bare=(role,))
            assert str(refused.value).endswith(GONE[name])


def test_the_symbols_of_the_papers_are_names():
    assert vc.Aqvc(C_E=8, C_N=4) == vc.Aqvc(c_e=8, c_n=4)
    assert by_name.make("visibility", "aqvc?C_E=8") == vc.Aqvc(c_e=8)
    chosen = by_name.assign({"visibility": vc.Aqvc()}, ["visibility.C_Z=2"], bare=("visibility",))
    assert chosen["visibility"] == vc.Aqvc(c_z=2)
    with pytest.raises(TypeError, match="c_e must be given once, got C_E too"):
        vc.Aqvc(c_e=8, C_E=4)
    with pytest.raises(TypeError, match=r"Aqvc has no parameter 'c_q'; did you mean"):
        vc.Aqvc(C_Q=8)
