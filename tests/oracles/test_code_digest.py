"""What the store of a sweep knows of the code of an oracle written in Python."""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import viscache as vc
from viscache.oracles.code_digest import code_digest

SOURCE = '''
import functools
import math
from dataclasses import dataclass

SCALE = 1.5
TABLE = {"a": 1}
UNUSED = 4


def helper(x):
    return deeper(x) + SCALE


def deeper(x):
    return x + 1


def decorated(function):
    @functools.wraps(function)
    def inner(*args):
        return function(*args)

    return inner


class Base:
    def twice(self, x):
        return 2 * x


@dataclass(frozen=True)
class Own(Base):
    """An oracle."""

    cell: float = 0.25
    kinds = ("a", "b")

    @decorated
    def block(self, eyes, lamps, wanted):
        # a comment
        if self.cell in {"x", "y", "z", 3.5}:
            return None
        rows = [helper(v) + self.bias for v in eyes]
        return self.twice(rows), TABLE["a"], math.pi, lambda y: y + 7

    @property
    def bias(self):
        return self.offset(1)

    @staticmethod
    def offset(x):
        return x + 3
'''


def digest_of(source, folder):
    """Of a class in a file, and of the same one in a console, which has no file."""
    found = []
    (folder / "own.py").write_text(source)
    for where in (str(folder / "own.py"), "<console>"):
        space = {"__name__": "own"}
        exec(compile(source, where, "exec", dont_inherit=True), space)
        found.append(code_digest(space["Own"]))
    assert found[0] == found[1]
    return found[0]


def test_layout_and_what_is_not_used_do_not_matter(tmp_path):
    first = digest_of(SOURCE, tmp_path)
    assert first == digest_of(SOURCE, tmp_path)
    for old, new in (
        ("# a comment", "# another comment\n\n"),
        ("import math\n", "import math\n\n\n\n"),
        ("UNUSED = 4", "UNUSED = 5"),
    ):
        assert old in SOURCE
        assert digest_of(SOURCE.replace(old, new), tmp_path) == first, old


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("2 * x", "3 * x"),  # a base class
        ("x + 3", "x + 4"),  # a static method
        ("offset(1)", "offset(2)"),  # a property
        ("y + 7", "y + 8"),  # a function in a method
        ("helper(v) +", "helper(v) -"),
        ("deeper(x) + SCALE", "deeper(x) - SCALE"),  # a function that a method calls
        ("x + 1", "x + 2"),  # a function that this one calls
        ("SCALE = 1.5", "SCALE = 1.6"),
        ('{"a": 1}', '{"a": 2}'),
        ("math.pi", "math.e"),
        ('"z", 3.5', '"z", 4.5'),
        ('("a", "b")', '("a", "c")'),  # an attribute of the class
        ("return function(*args)", "return not function(*args)"),  # a decorator
        ("self.cell in", "self.cell not in"),
    ],
)
def test_every_change_of_what_it_does_is_seen(old, new, tmp_path):
    assert old in SOURCE
    assert digest_of(SOURCE.replace(old, new), tmp_path) != digest_of(SOURCE, tmp_path)


def test_copies_and_uses_leave_it():
    first = code_digest(AllRays)
    frames = [vc.render("slits", "direct", visibility=AllRays(), size=(24, 16)) for _ in range(2)]
    assert frames[0].sha256 == frames[1].sha256 and code_digest(AllRays) == first
    assert code_digest(NoRays) != first


def test_code_that_cannot_be_read_is_told():
    class Compiled:
        block = np.add  # a function without bytecode

    with pytest.warns(UserWarning, match=r"the code of .*Compiled\.block cannot be read"):
        code_digest(Compiled)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code_digest(AllRays)


@dataclass(frozen=True)
class AllRays:
    """Exact, and how often it was asked."""

    table: Any = None

    def block(self, eyes, lamps, wanted):
        return eyes.trace(lamps, wanted)


@dataclass(frozen=True)
class NoRays(AllRays):
    """Everything is visible."""

    def block(self, eyes, lamps, wanted):
        return np.ones((len(eyes), len(lamps)), dtype=bool)


def test_a_sweep_renders_anew_when_the_class_changes(tmp_path, monkeypatch):
    given = {"visibility": AllRays(), "size": (24, 16), "metrics": ["rel_l1"]}
    tables, frames = [], []
    for n in range(3):
        if n == 2:  # the first two have the same code
            monkeypatch.setattr(AllRays, "block", NoRays.block)
        over = {"integrator.n_vpls": [8]}
        swept = vc.sweep("slits", "whitted", over=over, directory=tmp_path, **given)
        tables.append(float(swept["rel_l1"].mean()))
        frames.append(len(list((tmp_path / "frames").iterdir())))
    assert tables[0] == tables[1] == 0 < tables[2]
    assert frames[0] == frames[1] == frames[2] - 1


def test_a_swept_oracle_must_be_a_dataclass():
    class Plain:
        def block(self, eyes, lamps, wanted):
            return eyes.trace(lamps, wanted)

    with pytest.raises(ValueError, match="visibility must be a dataclass, got"):
        vc.sweep("slits", "direct", visibility=Plain(), over={"integrator.n_vpls": [8]})
