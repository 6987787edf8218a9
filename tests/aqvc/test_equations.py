"""Every numbered equation of AQVC against its transcription, and mutations that must fail."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from core import testing
from reference import aqvc as reference
from viscache import _core

aqvc = _core.aqvc
PAPERS = Path(__file__).resolve().parents[2] / "docs" / "papers.md"


@dataclass(frozen=True)
class Equation:
    """A bound function, its transcription, and ranges of its arguments (log-uniform)."""

    bound: Callable[..., np.ndarray]
    transcription: Callable[..., np.ndarray]
    ranges: tuple[tuple[float, float], ...]
    rtol: float = 1e-13

    def arguments(self):
        rng = np.random.default_rng(7)
        return [np.exp(rng.uniform(np.log(a), np.log(b), 1000)) for a, b in self.ranges]

    def holds(self, got, *, over):
        """Whether `got` is the transcription's value; integers must be equal."""
        want = self.transcription(*over)
        return bool(np.allclose(got, want, rtol=self.rtol, atol=0))


def bins(mode):
    """Eq. 4 through the key of a surface point: slot 1 of a normal (n, 0, √(1 − n²))."""

    def bound(component):
        n = np.stack([component, 0 * component, np.sqrt(1 - component**2)], 1).astype(np.float32)
        p, one = aqvc.AqvcParameters(c_n=8, normal_mode=mode), np.ones(len(n))
        return aqvc.full_keys(p, (0, 0, 0), 1.0, n, n, 9 * one, 0, n, n, one)[0][:, 1]

    return bound


def bins_transcribed(rounding):
    return lambda n: reference.normal_bins(n.astype(np.float32).astype(float), 8, rounding)


def hashes(scheme):
    """Eq. 10 of keys whose slots follow from one number, over all of 32 bits."""

    def keys(x):
        return (x[:, None] * np.arange(1, 16) ** 3).astype(np.int64).astype(np.int32)

    def bound(x):
        return np.asarray(aqvc.hash_keys(keys(x), scheme), np.float64)

    def transcribed(x):
        one = getattr(reference, scheme)
        return np.array([one([int(j) for j in key]) for key in keys(x)], np.float64)

    return bound, transcribed


WIDE, FEW = (1e-4, 1e4), (0.1, 64.0)
EQUATIONS = {
    "Eq. 2": Equation(testing.expected_paths, reference.expected_paths, (WIDE,) * 5),
    "Eq. 3": Equation(
        testing.patch_area_product, reference.patch_area_product, (WIDE, WIDE, WIDE, FEW)
    ),
    "Eq. 4": Equation(bins("round"), bins_transcribed(True), ((0.01, 0.98),), 0),
    "Eq. 4 printed": Equation(bins("floor"), bins_transcribed(False), ((0.01, 0.98),), 0),
    "Eq. 5": Equation(testing.patch_area, reference.patch_area, (WIDE, WIDE)),
    "Eq. 6": Equation(testing.resolution_pair, reference.resolution_pair, (WIDE, WIDE, FEW, WIDE)),
    "Eq. 7": Equation(aqvc.resolution_eye, reference.resolution_eye, (WIDE, FEW, WIDE)),
    "Eq. 7 light": Equation(testing.resolution_light, reference.resolution_light, (WIDE, WIDE)),
    "Eq. 8": Equation(lambda r: testing.ladder(r)[0], reference.ladder, ((1.0, 1e6),), 0),
    "Eq. 9": Equation(testing.resolution_environment, reference.resolution_environment, (WIDE,)),
    "Eq. 9 printed": Equation(
        lambda d: testing.resolution_environment(d, printed=True),
        reference.resolution_environment_printed,
        (WIDE,),
    ),
    "Eq. 10": Equation(*hashes("scheme2"), ((1e3, 1e7),), 0),
    "Eq. 10 scheme 1": Equation(*hashes("scheme1"), ((1e3, 1e7),), 0),
}


def test_the_list_has_every_equation_that_is_built():
    built = re.findall(r"^\| AQVC (Eq\. \d+) .*\*\*here\*\* \|$", PAPERS.read_text(), re.MULTILINE)
    assert len(built) > 5 and set(built) <= set(EQUATIONS)


@pytest.mark.parametrize("name", EQUATIONS)
def test_an_equation_equals_its_transcription(name):
    equation = EQUATIONS[name]
    arguments = equation.arguments()
    assert equation.holds(equation.bound(*arguments), over=arguments)


@pytest.mark.parametrize("factor", [1.01, 0.99])
@pytest.mark.parametrize("name", EQUATIONS)
def test_a_result_or_argument_changed_by_1_percent_fails(name, factor):
    """Mutation: each term of each equation is held by the comparison."""
    equation = EQUATIONS[name]
    arguments = equation.arguments()
    assert not equation.holds(equation.bound(*arguments) * factor, over=arguments)
    for i in range(len(arguments)):
        changed = [a * factor if k == i else a for k, a in enumerate(arguments)]
        assert not equation.holds(equation.bound(*changed), over=arguments), f"argument {i}"
