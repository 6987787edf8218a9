"""`vc.aqvc`: the equations as users call them give what the core computes, and refuse bad input."""

import numpy as np
import pytest

import viscache as vc
from viscache import _core

RNG = np.random.default_rng(5)
POINTS = RNG.uniform(-1, 1, (50, 3)).astype(np.float32)
NORMALS = RNG.normal(size=(50, 3)).astype(np.float32)
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
SIZES = np.full(50, 30.0)
GIVEN = {
    "settings": vc.Aqvc(c_n=6),
    "center": (0, 0, 0),
    "radius": 2.0,
    "points": POINTS,
    "normals": NORMALS,
    "resolutions": SIZES,
}


def test_keys_are_the_eye_side_of_whole_ones():
    keys, valid = vc.aqvc.eye_keys(**GIVEN)
    far = np.zeros_like(POINTS)
    whole, _, good, _ = _core.aqvc.full_keys(
        vc.Aqvc(c_n=6).core(), [0, 0, 0], 2.0, POINTS, NORMALS, SIZES, 0, far, far, np.ones(50)
    )
    assert valid.all() and np.array_equal(valid, good)
    assert np.array_equal(keys, whole[:, :8]) and len(np.unique(keys, axis=0)) > 10
    assert np.array_equal(vc.aqvc.hash_keys(whole), _core.aqvc.hash_keys(whole))
    padded = np.hstack([keys, np.zeros((50, 7), np.int32)])
    assert np.array_equal(vc.aqvc.hash_keys(keys), _core.aqvc.hash_keys(padded))


def test_resolutions_broadcast():
    found = vc.aqvc.resolution_eye([100.0, 400.0], 8.0, 2.0)
    assert np.array_equal(found, [vc.aqvc.resolution_eye(d, 8.0, 2.0) for d in (100.0, 400.0)])
    assert found[1] == pytest.approx(2 * found[0])  # cells are as wide as four times fewer paths


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"settings": "aqvc"}, r"settings must be vc.Aqvc\(...\), got 'aqvc'"),
        ({"center": (0, 0)}, r"center must have shape \(3,\), got \(2,\)"),
        ({"radius": -1.0}, r"radius must be in \(0, inf\), got -1.0"),
        ({"points": POINTS[0]}, r"points must have shape \(N, 3\), got \(3,\)"),
        ({"normals": NORMALS[:9]}, r"normals must have shape \(50, 3\), got \(9, 3\)"),
        ({"resolutions": 30.0}, r"resolutions must have shape \(50,\), got \(\)"),
        ({"points": [["x", "y", "z"]]}, "points must be numbers"),
    ],
)
def test_bad_input_is_refused(wrong, says):
    with pytest.raises(ValueError, match=says):
        vc.aqvc.eye_keys(**GIVEN | wrong)


def test_bad_keys_are_refused():
    with pytest.raises(ValueError, match="keys must be int32, got dtype"):
        vc.aqvc.hash_keys(np.zeros((3, 8)))
    with pytest.raises(ValueError, match=r"keys must be \(N, 0..15\), got \(3, 16\)"):
        vc.aqvc.hash_keys(np.zeros((3, 16), np.int32))
