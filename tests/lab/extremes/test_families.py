"""Every family holds here, and each of its checks fails when what it measures is broken."""

import dataclasses
import importlib
import itertools
import pkgutil
from contextlib import contextmanager, nullcontext

import numpy as np
import pytest

import viscache as vc
from viscache_lab.experiment import FAMILIES
from viscache_lab.experiment.checks import checked
from viscache_lab.extremes import families, pictures
from viscache_lab.extremes.families import machine

pytestmark = pytest.mark.extreme

#: Of the fast tests: one case in so many.
SAMPLE = 15
MODULES = [
    importlib.import_module(f"{families.__name__}.{m.name}")
    for m in pkgutil.iter_modules(families.__path__)
]
#: Refused or not measured with frames in some cases: what breaks them is below.
RENDER = vc.render
TOLD = machine._told


def cases(name, every):
    return itertools.islice(FAMILIES[name].function(False), len(name) % every, None, every)


def forget_frames():
    """Frames that families keep from case to case; those of other processes stay."""
    for module in [*MODULES, pictures]:
        for value in list(vars(module).values()):
            own = getattr(value, "__module__", "") == module.__name__
            if own and hasattr(value, "cache_clear") and value is not TOLD:
                value.cache_clear()


class FirstDamaged:
    """`vc.render`, whose first frame is thrice as bright, has a negative pixel, and more rays."""

    def __init__(self):
        self.frames = 0

    def __call__(self, *given, **more):
        frame = RENDER(*given, **more)
        self.frames += 1
        if self.frames > 1:
            return frame
        layers = {}
        for name, layer in frame.layers.items():
            layers[name] = np.array(layer) * np.float32(3) + np.float32(0.01)
            layers[name][0, 0] = -1
        counters = {**frame.counters, "rays": 1.5 * frame.counters["rays"] + 1}
        return dataclasses.replace(frame, layers=layers, counters=counters)


@contextmanager
def damaged(monkeypatch):
    forget_frames()
    made = FirstDamaged()
    with monkeypatch.context() as patch:
        patch.setattr(vc, "render", made)
        yield made
    forget_frames()


def leaky(answer):
    """Answers of rays of which one in twenty is wrong."""

    def asked(*given, **more):
        found = np.array(answer(*given, **more))
        found[::20] ^= True
        return found

    return asked


def every_other(function, changed):
    """A function with other arguments at every second call."""
    calls = itertools.count()
    return lambda *given, **more: function(*given, **(more | (changed if next(calls) % 2 else {})))


def drifting(*given, **more):
    """`vc.render`, whose sums of very many samples are 2 % too large."""
    frame = RENDER(*given, **more)
    if more.get("spp", 1) < 10_000:
        return frame
    layers = {n: np.array(layer) * np.float32(1.02) for n, layer in frame.layers.items()}
    return dataclasses.replace(frame, layers=layers)


def accepting(*given, env, **more):
    """`vc.render`, which takes what is not finite for a large number."""
    return RENDER(*given, env=[min(float(value), 1e30) for value in env], **more)


def silent_and_damaged(monkeypatch):
    """Nothing is warned of, and the first frame is wrong."""
    monkeypatch.setattr(vc.Scene, "warnings", [])
    monkeypatch.setattr(vc, "render", FirstDamaged())


#: What breaks the checks that a damaged first frame does not, by words of their names.
OTHERS = {
    "share of random rays": lambda m: m.setattr(vc.Scene, "visible", leaky(vc.Scene.visible)),
    "share that leaves": lambda m: m.setattr(vc.Scene, "visible", leaky(vc.Scene.visible)),
    "rays that hit": lambda m: m.setattr(vc.Scene, "visible", leaky(vc.Scene.visible)),
    "hit disagree": lambda m: m.setattr(vc.Scene, "occluded", leaky(vc.Scene.occluded)),
    "without a warning": silent_and_damaged,
    "mean of 100 parts": lambda m: m.setattr(vc, "render", drifting),
    "another variant": lambda m: m.setenv("VISCACHE_ISA", "another"),
    "against": lambda m: m.setattr(
        machine, "_told", lambda other: dict.fromkeys(machine.digests(), "another")
    ),
    "tables that differ": lambda m: m.setattr(
        vc.correlation, "measure", every_other(vc.correlation.measure, {"seed": 4})
    ),
    "caches that differ": lambda m: m.setattr(
        vc.VisibilityMapCache, "update", every_other(vc.VisibilityMapCache.update, {"size": (9, 9)})
    ),
    "not refused": lambda m: m.setattr(vc, "render", accepting),
    "could not be set": lambda m: m.setattr(machine, "float_mode", lambda bits: nullcontext()),
    "answers of rays": lambda m: m.setattr(
        vc.Scene, "intersect", every_other(vc.Scene.intersect, {"rays": vc.Vlf(snap=True)})
    ),
}


def broken_otherwise(case, monkeypatch):
    """Whether one of `OTHERS` makes the case fail."""
    for words, break_ in OTHERS.items():
        if words in case.name:
            forget_frames()
            with monkeypatch.context() as patch:
                break_(patch)
                failed = not checked(case).holds
            forget_frames()
            if failed:
                return True
    return False


def refused(case):
    """Ends of a range that a frame's settings refuse by name; no frame shows them."""
    return case.name.startswith(("Aqvc", "VisMaps", "Vlf", "Bsp"))


@pytest.mark.parametrize("name", FAMILIES)
def test_a_sample_of_a_family_holds(name):
    found = [checked(case) for case in cases(name, SAMPLE)]
    assert [check.line() for check in found if not check.holds] == []
    assert found


def never_failing(name, every, monkeypatch):
    """Cases that hold although the first frame is damaged, or another part is broken."""
    lame, unseen = [], 0
    for case in cases(name, every):
        with damaged(monkeypatch) as frames:
            failed = not checked(case).holds
        if failed or broken_otherwise(case, monkeypatch):
            continue
        if frames.frames == 0 and refused(case):
            unseen += 1
            continue
        lame.append(case.name)
    assert unseen <= 12  # of about 200
    return lame


@pytest.mark.parametrize("name", FAMILIES)
def test_a_sample_of_the_checks_fails_when_something_is_broken(name, monkeypatch):
    assert never_failing(name, SAMPLE, monkeypatch) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.release) if n in ("isa", "lights") else n for n in FAMILIES],
)
def test_every_check_fails_when_something_is_broken(name, monkeypatch):
    assert never_failing(name, 1, monkeypatch) == []


def test_families_have_names_and_cases_of_their_own():
    assert len(FAMILIES) >= len(MODULES)
    for name, family in FAMILIES.items():
        assert name.isidentifier() and family.description
        names = [case.name for case in family.function(False)]
        assert len(names) == len(set(names))
        assert all(case.why for case in family.function(False))
