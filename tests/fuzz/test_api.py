"""Any call of the public API works or is refused with words, whatever it is given.

`pytest tests/fuzz/test_api.py -k rays --fuzz-seconds 600 --fuzz-seed 1000` looks longer, elsewhere.
A finding is repeated by its group and seed: `-k GROUP --fuzz-seed SEED --fuzz-seconds 0`.
"""

import random
import re
import warnings
from pathlib import Path

import pytest

import viscache as vc
from fuzz import calls_geometry, calls_measure, calls_render
from fuzz.values import Dice
from viscache.settings.registry import NAMES

GROUPS = {
    **calls_geometry.CALLS,
    **calls_measure.CALLS,
    **calls_render.CALLS,
}
# Modules, whose functions are called by their own names, and what cannot be called with input
WITHOUT_INPUT = {
    "__version__",
    "SceneError",
    "Intersection",
    "notebook",
    "plots",
    "report",
    "vismap",
}
# Reached by another name: what reads files, and what functions make
ELSEWHERE = {"load_scene": "readers.py", "Camera": "vc.look_at", "Connections": "vc.connections"}


def target(group):
    """A case of a group: one of its calls, of any values."""
    calls, weights = zip(*GROUPS[group], strict=True)

    def case(seeded):
        call = seeded.choices(calls, weights)[0]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call(Dice(seeded))

    return case


@pytest.mark.fuzz
@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_any_call_works_or_says_what_must_hold(group, fuzz):
    counts = fuzz(target(group), group)
    assert counts["works"] > 0  # a fuzzer that only meets refusals finds nothing


def test_every_public_name_is_called():
    here = Path(__file__).parent
    text = "".join(
        (here / f"{name}.py").read_text()
        for name in ("calls_geometry", "calls_measure", "calls_render", "settings", "scenes")
    )
    reached = set(re.findall(r"\bvc\.(\w+)", text))
    reached |= {c.__name__ for c in NAMES["visibility"].values()}  # settings.py picks of them
    assert set(vc.__all__) - reached - WITHOUT_INPUT - set(ELSEWHERE) == set()


def test_a_case_is_decided_by_its_seed():
    def drawn(seed):
        dice = Dice(random.Random(f"x {seed}"))
        return [repr(dice.number()) for _ in range(20)] + [dice.numpy().random()]

    assert drawn(3) == drawn(3)
    assert drawn(3) != drawn(4)
